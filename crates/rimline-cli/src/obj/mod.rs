//! Wavefront OBJ files: positions, and faces of any number of corners.

mod coordinates;
mod line;
mod read;

pub use read::{ObjError, begins_like, read};
