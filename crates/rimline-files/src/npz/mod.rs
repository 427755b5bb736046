//! NumPy archives: a ZIP of .npy arrays.

mod compare;
#[cfg(feature = "depth-map")]
mod depth_map;
mod header;
mod points;
mod read;
mod write;

pub use compare::{Difference, compare};
#[cfg(feature = "depth-map")]
pub use depth_map::{DepthMapArrays, Depths, MAX_SIDE, read_depth_map};
pub use header::ElementType;
pub use points::{PointArrays, Points, read_points};
pub use read::{Arrays, NpzError, PolygonArrays, read, read_with_lights};
pub use write::{NpzWriter, write_origin};
