//! Queries of occluder counts without a device.

mod on_faces;
mod shadow_depth;
