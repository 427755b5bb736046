//! Model files for [`rimline`]: glTF 2.0, Wavefront OBJ, PLY, STL and NumPy archives, recognised by how they begin.
//!
//! A file may hold anything: memory has a bound ([`ReadOptions::memory_limit`]), nothing panics, and errors say what is
//! wrong, where, and what to do. Their advice names options of the command `rimline`, which go by the names of the fields of
//! [`ReadOptions`].
//!
//! ```no_run
//! use rimline_files::{ReadOptions, read};
//!
//! let file = read("house.obj".as_ref(), &ReadOptions::default())?;
//! let mesh = file.model().mesh(&file.pose(&[], 0.0)?)?;
//! println!("{} faces around {:?}", mesh.faces().len(), file.origin().to_array());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![allow(clippy::doc_markdown, reason = "NumPy is a name")]

mod charge;
mod collected;
mod coordinates;
mod error;
mod file;
mod format;
mod line;
#[doc(hidden)]
pub mod mtl;
#[doc(hidden)]
pub mod npz;
#[doc(hidden)]
pub mod obj;
mod origin;
#[doc(hidden)]
pub mod ply;
mod read;
#[doc(hidden)]
pub mod size;
#[doc(hidden)]
pub mod stl;

pub use error::FileError;
pub use file::{File, GivenPolygons, resting};
pub use format::{Foreign, Format, FormatError, archive};
pub use origin::{Settled, settle};
pub use read::{Polygons, ReadOptions, Up, open_regular, read, read_bytes, read_slices};
pub use rimline::gltf::Colors;
