//! Deforming without a device.

mod displace;
mod displace_bounds;
mod model;
