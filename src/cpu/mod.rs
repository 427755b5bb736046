//! Extraction, deformation, occluder counts and the search for occluded faces on the CPU. They need no device. Extraction by
//! [`Predicate::Exact`](crate::Predicate::Exact) and occluder counts have the same bits as on the GPU at the same positions.
//!
//! Masks are in batches of 32 lights, one after the other, and in a batch one item after the other. The GPU has the same
//! layout.

pub(crate) mod common;
pub(crate) mod deform;
pub(crate) mod error;
pub(crate) mod extract;
pub(crate) mod occlusion;
pub(crate) mod polygon;
pub(crate) mod query;

pub use crate::layout::EdgeMasks;
pub use common::parallel::Threads;
pub use deform::deform::{Displace, deform};
pub use error::CpuError;
pub use extract::extraction::{Extraction, extract};
pub use extract::facing::FacingStatistics;
pub use occlusion::occluded_faces::{OccludedFaces, OcclusionCaster, OcclusionStatistics};
pub use occlusion::options::OcclusionOptions;
pub use polygon::orientation::Orientation;
pub use polygon::polygon_pairs::Boundary;
pub use query::shadow_depth::{shadow_depth, shadow_depth_on_faces};
