//! Why volumes from depth maps cannot be made, recorded or drawn.

use crate::gpu::common::memory::MemoryError;
use crate::gpu::common::requirements::DeviceError;
use crate::gpu::shadow::ShadowFormatError;
use crate::shadow::{CameraError, DepthDirection};

/// Why pipelines cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DepthMapPipelinesError {
    /// The device lacks what the volumes need, is lost, or cannot draw into the attachments.
    #[error(transparent)]
    Format(#[from] ShadowFormatError),
    /// There is no such bit in the stencil.
    #[error("the stencil has bits 0 to 7, and `bit` is {0}")]
    Bit(u32),
}

impl From<DeviceError> for DepthMapPipelinesError {
    fn from(error: DeviceError) -> Self {
        Self::Format(error.into())
    }
}

/// Why volumes cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DepthMapVolumesError {
    /// The device lacks what the volumes need, or is lost.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The buffers do not fit the device.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// The map has no texel, or too many.
    #[error(
        "a map of {0} × {1} texels cannot be taken; it has at least one texel, and at most 2²⁹ cells: (width + 1) × (height + 1)"
    )]
    Size(u32, u32),
    /// The threshold is no depth.
    #[error("the threshold of `DepthEdges::Differences` is {0}; device depth differs by 0 to 1")]
    Threshold(f32),
    /// The bias would move the surface towards the light, or nowhere.
    #[error("`slope_bias` is {0}; take a finite number that is not negative")]
    Bias(f32),
}

/// Why volumes cannot be recorded.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DepthMapEncodeError {
    /// The device is lost, or is not the timer's device.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The camera is refused.
    #[error("the eye: {0}")]
    Camera(CameraError),
    /// The camera of the map is refused.
    #[error("the light of the map: {0}")]
    Light(CameraError),
    /// Some depths of the map lie behind infinity.
    #[error(
        "rounding put the far plane of the map's camera behind infinity; use a projection without a far plane, or a larger near distance"
    )]
    FarPlane,
    /// The texture is of another size than the volumes were made for.
    #[error("the map has {given:?} texels, and the volumes were made for {made:?}; make volumes of this size")]
    Size {
        /// Size of the texture.
        given: [u32; 2],
        /// Size given to [`DepthMapVolumes::new`](crate::gpu::DepthMapVolumes::new).
        made: [u32; 2],
    },
    /// The texture holds no depths that are known.
    #[error("{0:?} is no format of a depth map; take Depth16Unorm, Depth24Plus, Depth32Float, or R32Float")]
    Format(wgpu::TextureFormat),
    /// The texture cannot be read.
    #[error("the map's texture has {0} samples a texel; resolve it, or render the map with one")]
    Samples(u32),
    /// The texture lacks a usage.
    #[error("the map's texture lacks usage TEXTURE_BINDING")]
    Usage,
    /// The device refuses to bind the texture.
    #[error(
        "the device refuses the map's texture: {message}; give a two-dimensional view of one level, layer and aspect, on the device of the volumes"
    )]
    Refused {
        /// The message of the device.
        message: String,
    },
    /// The depth directions of camera and pipelines differ.
    #[error(
        "the eye's depth is {camera:?}, and the pipelines have {pipelines:?}; set `ShadowFormat::depth` to the camera's"
    )]
    Depth {
        /// Depth direction of the camera.
        camera: DepthDirection,
        /// Depth direction of the pipelines.
        pipelines: DepthDirection,
    },
}

/// Why volumes cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DepthMapDrawError {
    /// The pipelines are of another device.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The depth directions of volumes and pipelines differ.
    #[error(
        "the volumes were encoded for {volumes:?} depth, and the pipelines have {pipelines:?}; use the same `ShadowFormat::depth`"
    )]
    Depth {
        /// Depth direction of the volumes.
        volumes: DepthDirection,
        /// Depth direction of the pipelines.
        pipelines: DepthDirection,
    },
    /// A later encode overwrites what is drawn.
    #[error(
        "a later encode of these volumes overwrites this frame; draw a frame before the next encode, or make further volumes"
    )]
    StaleFrame,
}
