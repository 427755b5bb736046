//! Deforming without a device.

mod displace;
