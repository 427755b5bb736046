//! Twins of the shadow depth query.

#[cfg(feature = "reference")]
pub(crate) mod depth_arguments;
pub(crate) mod exact_shadow_depth;
pub(crate) mod shadow_boxes;
pub(crate) mod shadow_depth;
