//! Why shadow masks cannot be written.

use crate::gpu::common::device_error::{DeviceError, feature_names};
use crate::gpu::common::requirements::check_alive;
use crate::gpu::shadow::errors::ShadowError;

/// Why shadow masks cannot be written. Nothing is recorded then.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MaskError {
    /// The device lacks what shadow volumes need, or is lost, or objects of two devices were used together.
    #[error(transparent)]
    Device(DeviceError),
    /// The frame is out of date, has no such view or light, or the device cannot draw its volumes with this number of
    /// samples.
    #[error(transparent)]
    Shadow(ShadowError),
    /// The depth texture has no depth, or shaders may not read it.
    #[error("the depth texture, of format {format:?}, cannot be read; give one with depth and usage TEXTURE_BINDING")]
    Depth {
        /// Its format.
        format: wgpu::TextureFormat,
    },
    /// Depth of 32 bits needs an optional format with stencil.
    #[error(
        "depth of format {format:?} is tested in Depth32FloatStencil8, which needs {}; make the device with it, or draw \
         the depth in Depth24Plus",
        feature_names(*.needed)
    )]
    Feature {
        /// The format of the depth.
        format: wgpu::TextureFormat,
        /// The feature that the device lacks.
        needed: wgpu::Features,
    },
    /// The target is of no format that masks have.
    #[error("the target has the format {format:?}; masks are R8Uint, R32Uint or R8Unorm")]
    TargetFormat {
        /// Its format.
        format: wgpu::TextureFormat,
    },
    /// The target has several samples or three dimensions, or cannot be drawn into.
    #[error(
        "the target has {samples} samples, {dimension:?} and usages {usage:?}; give one with one sample, two dimensions and \
         usage RENDER_ATTACHMENT"
    )]
    Target {
        /// Samples a pixel.
        samples: u32,
        /// Its dimension.
        dimension: wgpu::TextureDimension,
        /// Its usages.
        usage: wgpu::TextureUsages,
    },
    /// The target has not the size of the depth.
    #[error("the target has {target:?} pixels and the depth {depth:?}; give textures of one size")]
    Size {
        /// Width and height of the target.
        target: [u32; 2],
        /// Width and height of the depth.
        depth: [u32; 2],
    },
    /// There are more lights than the layers of the target hold.
    #[error(
        "{lights} lights need {needed} layers of {format:?}, and the target has {layers}; add layers, or give fewer lights"
    )]
    TooManyLights {
        /// Lights given.
        lights: usize,
        /// Layers that hold them.
        needed: u32,
        /// The format of the target.
        format: wgpu::TextureFormat,
        /// Layers of the target.
        layers: u32,
    },
    /// The device refuses a texture, a view or a pipeline.
    #[error("the device refuses {what}: {message}")]
    Refused {
        /// The thing that it refuses.
        what: &'static str,
        /// The message of the device.
        message: String,
    },
}

impl From<DeviceError> for MaskError {
    fn from(error: DeviceError) -> Self {
        Self::Device(error)
    }
}

impl From<ShadowError> for MaskError {
    /// A device is refused by the same case, whoever finds it.
    fn from(error: ShadowError) -> Self {
        match error {
            ShadowError::Device(error) => Self::Device(error),
            error => Self::Shadow(error),
        }
    }
}

/// The message of a device that refuses, or that is lost.
pub(super) fn refused(device: &wgpu::Device, what: &'static str, message: String) -> MaskError {
    check_alive(device).map_or_else(MaskError::Device, |()| MaskError::Refused { what, message })
}
