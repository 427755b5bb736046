//! Why shadow volumes cannot be made, recorded or drawn.

use crate::gpu::common::memory::MemoryError;
use crate::gpu::common::positions::PositionError;
use crate::gpu::common::requirements::DeviceError;
use crate::gpu::extract::errors::ExtractionIncludeError;
use crate::gpu::extract::errors::StaleExtraction;
use crate::light::LightError;
use crate::shadow::{CameraError, Counting, DepthDirection};

/// Why shadow volumes cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShadowVolumesError {
    /// The device lacks what shadow volumes need, is lost, or is not that of the pipelines or the timer.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The extractor makes no lists or no facing masks.
    #[error(transparent)]
    Include(#[from] ExtractionIncludeError),
    /// The buffers of the volumes do not fit the device.
    #[error(transparent)]
    Memory(#[from] MemoryError),
}

/// Why shadow volumes cannot be recorded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShadowEncodeError {
    /// The device is lost, or is not the timer's device.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// An array of the extraction does not fit one binding.
    #[error(transparent)]
    Include(#[from] ExtractionIncludeError),
    /// The position buffer is refused.
    #[error(transparent)]
    Positions(#[from] PositionError),
    /// The camera is refused.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// A light is refused, because its `w` is negative.
    #[error(transparent)]
    Light(#[from] LightError),
    /// The extraction belongs to another extractor. The volumes read the lists of the extractor that they were made
    /// for.
    #[error(
        "these volumes were made for another extractor; encode them with an extraction of the one given to `ShadowVolumes::new`"
    )]
    OtherExtractor,
    /// A later encode of the extractor overwrote what the volumes read.
    #[error(transparent)]
    Stale(#[from] StaleExtraction),
    /// The depth directions of camera and pipelines differ. Near and far would be exchanged.
    #[error(
        "the camera's depth is {camera:?}, and the pipelines that the volumes were made with have {pipelines:?}; set \
         `ShadowFormat::depth` to the camera's"
    )]
    Depth {
        /// Depth direction of the camera.
        camera: DepthDirection,
        /// Depth direction of the pipelines.
        pipelines: DepthDirection,
    },
    /// The camera has a far plane, which would cut off dark caps.
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
    /// The pipelines belong to another device.
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
    /// The frame has no light with this index.
    #[error("light {light} asked for, and {lights} lights were encoded; lights count from 0")]
    NoSuchLight {
        /// The light that was asked for.
        light: usize,
        /// Lights of the frame.
        lights: usize,
    },
    /// The pipelines have another counting method than the volumes.
    #[error(
        "volumes made for {volumes:?} drawn with pipelines of {pipelines:?}; draw them with pipelines of the counting \
         method given to `ShadowVolumes::new`"
    )]
    Counting {
        /// Counting method of the volumes.
        volumes: Counting,
        /// Counting method of the pipelines.
        pipelines: Counting,
    },
    /// The pipelines have another depth direction than the volumes.
    #[error(
        "volumes made for {volumes:?} depth drawn with pipelines of {pipelines:?} depth; take a `ShadowFormat` of that"
    )]
    Depth {
        /// Depth direction of the volumes.
        volumes: DepthDirection,
        /// Depth direction of the pipelines.
        pipelines: DepthDirection,
    },
    /// The camera of the volumes makes a mirror image and the pipelines are made for none, or the other way round. Near
    /// caps would be counted against the sides.
    #[error(
        "volumes whose camera needs front faces {volumes:?} drawn with pipelines of {pipelines:?}; change the sign of the row \
         of y of a camera that mirrors by mistake, or set `ShadowFormat::front_face`"
    )]
    FrontFace {
        /// The front faces of the volumes' camera.
        volumes: wgpu::FrontFace,
        /// The front faces of the pipelines.
        pipelines: wgpu::FrontFace,
    },
    /// The pipelines clip at the far plane, and those that the volumes were made with do not.
    #[error(
        "volumes made for z-fail with a far plane drawn with pipelines for none; set `ShadowFormat::has_far_plane`"
    )]
    FarPlane,
    /// The pipelines count in other bits than the volumes were made for, so counts wrap elsewhere.
    #[error(
        "volumes made for counts of {volumes} bits drawn with pipelines of {pipelines}; take a `ShadowFormat` of the same \
         `count_bits` (for a scene, `SceneOptions::count_bits`)"
    )]
    CountBits {
        /// Bits of counts that the volumes were made for.
        volumes: u32,
        /// Bits of counts of the pipelines.
        pipelines: u32,
    },
}
