//! The table of scenes. Facing, exact facing and edges have the same references as for a single mesh.

pub(crate) mod table;
