//! References of the extraction stages: facing, exact facing, edges.

pub(crate) mod batch;
pub(crate) mod edges;
pub(crate) mod exact_facing;
pub(crate) mod extraction;
pub(crate) mod facing;
pub(crate) mod per_edge;
