//! The twin of a stage that only scenes have, and the table of scenes. Facing, exact facing and edges have the same twins as for a single mesh.

pub(crate) mod clusters;
pub(crate) mod table;
