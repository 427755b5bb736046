//! Results of the stages for a file.

use std::ops::Range;

use rimline::reference::layout::{ExtractionStatistics, ShadowLight, ShadowStatistics};
use rimline::wgpu;

/// Results and choices for a file.
pub(crate) struct Found {
    /// The choice for each light. For a file of many casters it is the most that any of them needs.
    pub(crate) lights: Vec<ShadowLight>,
    /// The silhouette edges for each light.
    pub(crate) silhouettes: Vec<u32>,
    pub(crate) extraction: ExtractionStatistics,
    pub(crate) shadow: ShadowStatistics,
    /// Whether the bounds and overflows of `shadow` are the file's own. With several files they are known for all of
    /// them together.
    pub(crate) is_whole: bool,
}

/// A run of faces of a file whose masks lie in one buffer.
pub(crate) struct FacingRun {
    pub(crate) faces: Range<u32>,
    /// Facing masks for each batch of 32 lights.
    pub(crate) facing: Vec<wgpu::Buffer>,
}

/// Where a file's facing masks lie.
#[derive(Default)]
pub(crate) struct FacingMasks {
    pub(crate) runs: Vec<FacingRun>,
    /// The place of each face in its buffer.
    pub(crate) slots: Vec<u32>,
}
