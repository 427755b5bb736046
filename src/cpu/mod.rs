//! Extraction, deforming and shadow depths on the CPU. They need no device, and give the GPU's bits at the same positions.
//!
//! Masks are laid out as on the GPU: word after batch of 32 lights, within a word item after item.

pub(crate) mod common;
pub(crate) mod deform;
pub(crate) mod extract;
pub(crate) mod query;
#[cfg(feature = "reference")]
pub(crate) mod shadow;

pub use crate::layout::Masks;
pub use common::parallel::Threads;
pub use deform::deform::{Displace, deform};
pub use extract::extraction::{CpuExtraction, extract};
pub use extract::facing::FacingCounts;
pub use query::shadow_depth::shadow_depth;
