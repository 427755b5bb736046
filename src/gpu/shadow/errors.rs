//! Why shadow volumes cannot be made, recorded or drawn.

use crate::gpu::common::memory::MemoryError;
use crate::gpu::common::positions::PositionError;
use crate::gpu::common::requirements::DeviceError;
use crate::gpu::extract::errors::IncludeError;
use crate::gpu::extract::errors::StaleExtraction;
use crate::light::LightError;
use crate::shadow::{CameraError, Counting, DepthDirection};

/// Why shadow volumes cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShadowVolumesError {
    /// The device lacks what shadow volumes need, is lost, or is another than the pipelines' or the timer's.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The extractor makes no lists or no facing masks.
    #[error(transparent)]
    Include(#[from] IncludeError),
    /// The volumes' own buffers do not fit the device.
    #[error(transparent)]
    Memory(#[from] MemoryError),
}

/// Why shadow volumes cannot be recorded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShadowEncodeError {
    /// The device is lost, or another than the timer's.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// An array of the extraction does not fit one binding.
    #[error(transparent)]
    Include(#[from] IncludeError),
    /// The position buffer is refused.
    #[error(transparent)]
    Positions(#[from] PositionError),
    /// The camera is refused.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A light is refused: one with a negative `w`.
    #[error(transparent)]
    Light(#[from] LightError),
    /// The volumes read the lists of the extractor that they were made for.
    #[error(
        "these volumes were made for another extractor; encode them with an extraction of the one given to `ShadowVolumes::new`"
    )]
    OtherExtractor,
    /// A later encode of the extractor overwrote what the volumes read.
    #[error(transparent)]
    Stale(#[from] StaleExtraction),
    /// Near and far would be taken for each other.
    #[error(
        "the camera's depth is {camera:?}, and the pipelines that the volumes were made with have {pipelines:?}; set \
         `ShadowFormat::depth` to the camera's"
    )]
    Depth {
        /// Of the camera.
        camera: DepthDirection,
        /// Of the pipelines.
        pipelines: DepthDirection,
    },
    /// Dark caps would be cut off at the camera's far plane.
    #[error(
        "{counting:?} with a camera that has a far plane needs `ShadowFormat::has_far_plane` (and \
         `Features::DEPTH_CLIP_CONTROL`); set it, use an infinite far plane, or `Counting::Auto`"
    )]
    FarPlane {
        /// The counting method.
        counting: Counting,
    },
}

/// Why volumes cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ShadowDrawError {
    /// The pipelines are of another device.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A later encode of the extractor overwrote what is drawn.
    #[error(transparent)]
    Stale(#[from] StaleExtraction),
    /// A later encode of the volumes overwrote what is drawn.
    #[error(
        "this frame is out of date: its volumes were encoded again, which overwrites them; draw the value that the last \
         encode returned"
    )]
    StaleFrame,
    /// The frame has fewer lights.
    #[error("light {light} asked for, and {lights} lights were encoded; lights count from 0")]
    NoSuchLight {
        /// The light asked for.
        light: usize,
        /// Lights there are.
        lights: usize,
    },
    /// What was listed is not what the pipelines draw.
    #[error(
        "volumes made for {volumes:?} drawn with pipelines of {pipelines:?}; draw them with pipelines of the counting \
         method given to `ShadowVolumes::new`"
    )]
    Counting {
        /// Of the volumes.
        volumes: Counting,
        /// Of the pipelines given.
        pipelines: Counting,
    },
    /// The pipelines take far for near.
    #[error(
        "volumes made for {volumes:?} depth drawn with pipelines of {pipelines:?} depth; take a `ShadowFormat` of that"
    )]
    Depth {
        /// Of the volumes.
        volumes: DepthDirection,
        /// Of the pipelines given.
        pipelines: DepthDirection,
    },
    /// The pipelines clip at the far plane, unlike those that the volumes were made with.
    #[error(
        "volumes made for z-fail with a far plane drawn with pipelines for none; set `ShadowFormat::has_far_plane`"
    )]
    FarPlane,
}
