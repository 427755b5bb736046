//! Extraction, deformation and shadow depth on the CPU. They need no device. Extraction and shadow depth give the same
//! bits as the GPU at the same positions.
//!
//! Masks are in batches of 32 lights, one after the other, and in a batch one item after the other. The GPU has the same layout.

pub(crate) mod common;
pub(crate) mod deform;
pub(crate) mod error;
pub(crate) mod extract;
pub(crate) mod hidden;
pub(crate) mod polygon;
pub(crate) mod query;

pub use crate::layout::EdgeMasks;
pub use common::parallel::Threads;
pub use deform::deform::{Displace, deform};
pub use error::CpuError;
pub use extract::extraction::{Extraction, extract};
pub use extract::facing::FacingStatistics;
pub use hidden::hidden_faces::{HiddenCaster, HiddenFaces, HiddenStatistics};
pub use hidden::options::HiddenOptions;
pub use query::shadow_depth::{shadow_depth, shadow_depth_on_faces};
