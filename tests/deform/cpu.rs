//! Deforming without a device.

mod displace;
mod model;
