//! NumPy archives: a ZIP of .npy arrays.

pub(crate) mod charge;
mod compare;
mod header;
mod read;
mod write;

pub use compare::{Difference, compare};
pub use header::ElementType;
pub use read::{Arrays, NpzError, PolygonArrays, read, read_points, read_with_lights};
pub use write::NpzWriter;
