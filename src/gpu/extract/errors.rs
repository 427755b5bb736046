//! Why extractions cannot be made, recorded, read or drawn.

use crate::gpu::common::memory::MemoryError;
use crate::gpu::common::positions::PositionError;
use crate::gpu::common::requirements::DeviceError;
use crate::light::LightError;

/// Why an extraction cannot be recorded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EncodeError {
    /// The device is lost, or the timer is of another one.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The lights are refused.
    #[error(transparent)]
    Light(#[from] LightError),
    /// The position buffer is refused.
    #[error(transparent)]
    Positions(#[from] PositionError),
}

/// Why an extractor cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExtractorError {
    /// The device lacks what extraction needs, or is lost.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// `max_lights` is 0 or more than [`MAX_LIGHTS`](crate::MAX_LIGHTS).
    #[error(transparent)]
    Light(#[from] LightError),
    /// The mesh does not fit the device.
    #[error(transparent)]
    Memory(#[from] MemoryError),
}

/// An extraction whose results were overwritten.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "this extraction is out of date: its extractor was encoded again, which overwrites the results; use the value that \
     the last encode returned"
)]
pub struct StaleExtraction;

/// Why a light's silhouette cannot be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DrawError {
    /// A later encode overwrote the results.
    #[error(transparent)]
    Stale(#[from] StaleExtraction),
    /// The extraction has fewer lights.
    #[error("light {light} asked for, and {lights} lights were extracted; lights count from 0")]
    NoSuchLight {
        /// The light asked for.
        light: usize,
        /// Lights there are.
        lights: usize,
    },
    /// The extractor makes no lists.
    #[error("the extractor makes no lists to draw from; set `ExtractorOptions::lists`")]
    NoLists,
}

/// Why the include's bind group cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IncludeError {
    /// The device is lost.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The extractor makes no lists, or it follows the per-edge method and has no facing masks.
    #[error("the include needs lists and facing masks; make the extractor with `lists` and `Method::FaceMask`")]
    NoLists,
    /// The extraction has fewer batches of lights.
    #[error("batch {batch} of lights asked for, and there are {batches}; a batch is 32 lights, and they count from 0")]
    NoSuchBatch {
        /// The batch asked for.
        batch: usize,
        /// Batches there are.
        batches: usize,
    },
    /// A later encode overwrote the results.
    #[error(transparent)]
    Stale(#[from] StaleExtraction),
    /// The position buffer is refused.
    #[error(transparent)]
    Positions(#[from] PositionError),
    /// An array takes more than one binding, and the include reads each from one.
    #[error(transparent)]
    Memory(#[from] MemoryError),
}
