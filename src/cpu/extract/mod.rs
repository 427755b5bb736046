//! Twins of the extraction: facing, exact facing, edges, lists, draw arguments.

pub(crate) mod arguments;
pub(crate) mod batch;
pub(crate) mod compact;
pub(crate) mod edges;
pub(crate) mod exact_facing;
pub(crate) mod extraction;
pub(crate) mod facing;
pub(crate) mod per_edge;
