//! The shadow depth query on the GPU.

mod plan;
pub(crate) mod shadow_query;
