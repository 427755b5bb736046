//! NumPy archives: a ZIP of .npy arrays.

mod header;
mod read;
mod write;

pub(crate) use header::ElementType;
pub(crate) use read::{NpzError, read, read_points};
pub(crate) use write::NpzWriter;
