//! Twins of the stages that only scenes have. Facing, exact facing and edges have the same twins as for a single mesh.

pub(crate) mod chunks;
pub(crate) mod clusters;
pub(crate) mod needs;
pub(crate) mod occluded;
pub(crate) mod reach;
pub(crate) mod table;
