//! Models made by code, for Rimline's demo, examples and tests, and a writer of glTF binaries. The programs `walking_figure` and
//! `shape` write them to files. Nothing here is published.
#![allow(missing_docs, reason = "fields and constants of the figure say by their names what they are")]
#![allow(clippy::missing_panics_doc, clippy::missing_errors_doc, reason = "made by code from constants")]

pub mod figure;
pub mod glb_file;
