//! Queries of occluder counts without a device.

mod shadow_depth;
