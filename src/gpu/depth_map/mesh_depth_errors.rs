//! Why meshes and scenes cannot be drawn into depth maps.

use crate::gpu::common::memory::MemoryError;
use crate::gpu::common::positions::PositionError;
use crate::gpu::common::requirements::DeviceError;
use crate::gpu::scene::errors::SceneError;
use crate::shadow::{CameraError, DepthDirection};

/// Why the depth of a mesh cannot be drawn into a depth map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshDepthError {
    /// The device lacks what the draw needs, or is lost.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The positions cannot be read.
    #[error(transparent)]
    Positions(#[from] PositionError),
    /// The light's camera is refused.
    #[error(transparent)]
    Light(#[from] CameraError),
    /// The format holds no depth.
    #[error("{0:?} has no depth; take a depth format, such as Depth32Float")]
    Format(wgpu::TextureFormat),
    /// One draw cannot have so many vertices.
    #[error("the mesh has {0} faces, and one draw has at most 1,431,655,765; divide the mesh")]
    Faces(usize),
    /// The device refuses a buffer, a pipeline or a bind group.
    #[error("the device refuses to draw the depth of a mesh: {message}")]
    Refused {
        /// The message of the device.
        message: String,
    },
    /// The depth directions of light and pipeline differ.
    #[error("the light's depth is {light:?}, and this was made for {made:?}; give `MeshDepth::new` the light's")]
    Depth {
        /// Depth direction of the light.
        light: DepthDirection,
        /// Depth direction given to [`MeshDepth::new`](crate::gpu::MeshDepth::new).
        made: DepthDirection,
    },
}

/// Why the depth of the casters of a scene cannot be drawn into a depth map.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneDepthError {
    /// The device lacks what the draw needs, or is lost.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A handle is of another scene, or names what was removed.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The light's camera is refused.
    #[error(transparent)]
    Light(#[from] CameraError),
    /// What is drawn together does not fit one binding.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// The format holds no depth.
    #[error("{0:?} has no depth; take a depth format, such as Depth32Float")]
    Format(wgpu::TextureFormat),
    /// The device refuses a buffer, a pipeline or a bind group.
    #[error(
        "the device refuses to draw the depth of a scene: {message}; the scene must be on the same device, and its buffers not destroyed"
    )]
    Refused {
        /// The message of the device.
        message: String,
    },
    /// The depth directions of light and pipeline differ.
    #[error("the light's depth is {light:?}, and this was made for {made:?}; give `SceneDepth::new` the light's")]
    Depth {
        /// Depth direction of the light.
        light: DepthDirection,
        /// Depth direction given to [`SceneDepth::new`](crate::gpu::SceneDepth::new).
        made: DepthDirection,
    },
}
