//! Parts of the command that fuzzing needs: reading and writing of NumPy archives, and reading of OBJ files. The
//! command itself is `main.rs`. The interface is only for other programs of this repository, and anything may change.
#![allow(clippy::doc_markdown, reason = "NumPy is a name")]

#[doc(hidden)]
pub mod npz;
#[doc(hidden)]
pub mod obj;
