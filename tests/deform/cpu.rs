//! Deforming without a device.

mod bounds;
mod displace;
mod model;
