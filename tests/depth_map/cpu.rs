//! Volumes from depth maps, without a device.

mod cells;
mod maps;
mod places;
mod rules;
