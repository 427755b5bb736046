//! NumPy archives: a ZIP of .npy arrays.

mod header;
mod read;
mod write;

pub(crate) use header::ElementType;
pub(crate) use read::{NpzError, read};
pub(crate) use write::NpzWriter;
