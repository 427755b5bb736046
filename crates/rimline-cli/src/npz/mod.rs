//! NumPy archives: a ZIP of .npy arrays.

mod compare;
mod header;
mod read;
mod write;

pub(crate) use compare::{Difference, compare};
pub(crate) use header::ElementType;
pub(crate) use read::{Arrays, NpzError, read, read_points, read_with_lights};
pub(crate) use write::NpzWriter;
