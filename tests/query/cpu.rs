//! The shadow depth query without a device.

mod shadow_depth;
