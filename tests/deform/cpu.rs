//! Deforming without a device.

mod bounds;
mod displace;
mod displace_bounds;
mod model;
