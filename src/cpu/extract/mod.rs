//! Twins of the extraction stages: facing, exact facing, edges, lists, draw arguments.

#[cfg(feature = "reference")]
pub(crate) mod arguments;
pub(crate) mod batch;
#[cfg(feature = "reference")]
pub(crate) mod compact;
pub(crate) mod edges;
pub(crate) mod exact_facing;
pub(crate) mod extraction;
pub(crate) mod facing;
pub(crate) mod per_edge;
