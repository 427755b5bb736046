//! The shadow depth query without a device.

mod on_faces;
mod shadow_depth;
