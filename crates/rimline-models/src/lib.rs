//! Models made by code, for Rimline's viewer, demo, examples and tests. The programs `walking_figure` and `shape` write
//! a figure and shapes to files. [`catalogue`] has a file for each class of inputs. All are made by [`maker`], which
//! writes bad files, too. [`scenes`] are the viewer's own, and [`check`] compares the bits that a device finds for
//! them with the CPU's. There is no promise of stability.
#![allow(missing_docs, reason = "fields and constants of the figure say by their names what they are")]
#![allow(clippy::missing_panics_doc, clippy::missing_errors_doc, reason = "made by code from constants")]

pub mod catalogue;
pub mod check;
pub mod figure;
pub mod maker;
pub mod scenes;
