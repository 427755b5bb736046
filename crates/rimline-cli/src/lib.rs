//! What other programs of this repository need of the command: its reading and writing of NumPy archives and of OBJ files, for
//! fuzzing. The command itself is `main.rs`. Nothing here is meant for others, and anything may change.
#![allow(clippy::doc_markdown, reason = "NumPy is a name")]

#[doc(hidden)]
pub mod npz;
#[doc(hidden)]
pub mod obj;
