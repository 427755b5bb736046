//! Queries of occluder counts on the GPU.

pub(crate) mod errors;
pub(crate) mod options;
mod plan;
pub(crate) mod points;
pub(crate) mod shadow_query;
