//! CPU references of the query of occluder counts.

pub(crate) mod exact_shadow_depth;
pub(crate) mod shadow_boxes;
pub(crate) mod shadow_depth;
