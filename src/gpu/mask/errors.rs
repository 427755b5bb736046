//! Why shadow masks cannot be written.

use crate::gpu::common::device_error::{DeviceError, contain, feature_names};
use crate::gpu::common::memory::any_error;
use crate::gpu::common::requirements::check_alive;
use crate::gpu::shadow::errors::ShadowError;

/// Why shadow masks cannot be written. Nothing is recorded then.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what fields are")]
pub enum MaskError {
    /// The device lacks what shadow volumes need, or is lost, or objects of two devices were used together.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The frame is out of date, has no such view or light, or the device cannot draw its volumes with this number of
    /// samples.
    #[error(transparent)]
    Shadow(ShadowError),
    /// The depth texture has no depth, or shaders may not read it.
    #[error("the depth texture, of format {format:?}, cannot be read; give one with depth and usage TEXTURE_BINDING")]
    Depth { format: wgpu::TextureFormat },
    /// Depth of 32 bits needs an optional format with stencil.
    #[error(
        "depth of format {format:?} is tested in Depth32FloatStencil8, which needs {}; make the device with it, or draw \
         the depth in Depth24Plus",
        feature_names(*.needed)
    )]
    Feature { format: wgpu::TextureFormat, needed: wgpu::Features },
    /// The target is of no format that masks have.
    #[error("the target has the format {format:?}; masks are R8Uint, R32Uint or R8Unorm")]
    TargetFormat { format: wgpu::TextureFormat },
    /// The target has several samples or three dimensions, or cannot be drawn into.
    #[error(
        "the target has {samples} samples, {dimension:?} and usages {usage:?}; give one with one sample, two dimensions and \
         usage RENDER_ATTACHMENT"
    )]
    Target { samples: u32, dimension: wgpu::TextureDimension, usage: wgpu::TextureUsages },
    /// The target has not the size of the depth.
    #[error("the target has {target:?} pixels and the depth {depth:?}; give textures of one size")]
    Size { target: [u32; 2], depth: [u32; 2] },
    /// There are more lights than the layers of the target hold.
    #[error(
        "{lights} lights need {needed} layers of {format:?}, and the target has {layers}; add layers, or give fewer lights"
    )]
    TooManyLights { lights: usize, needed: u32, format: wgpu::TextureFormat, layers: u32 },
    /// The device refuses a texture, a view or a pipeline.
    #[error("the device refuses {what}: {message}")]
    Refused { what: &'static str, message: String },
}

contain!(ShadowError in MaskError::Shadow but Device);

/// Runs `make`, and returns the message of a device that refuses, behind a hint, or that is lost.
pub(super) fn tried<T>(
    device: &wgpu::Device,
    [what, hint]: [&'static str; 2],
    make: impl FnOnce() -> T,
) -> Result<T, MaskError> {
    any_error(device, make).map_err(|message| {
        let refused = |()| MaskError::Refused { what, message: format!("{hint}{message}") };
        check_alive(device).map_or_else(MaskError::Device, refused)
    })
}
