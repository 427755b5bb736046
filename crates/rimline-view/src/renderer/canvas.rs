//! Textures of a picture, and what reads them.

use std::pin::pin;
use std::task::{Context, Poll, Waker};

use rimline_picture::{PictureFormat, Resources, Targets, color_pass, view};

use super::error::RenderError;

/// The targets of a picture of one size.
pub(super) struct Canvas {
    pub(super) size: [u32; 2],
    pub(super) format: PictureFormat,
    pub(super) targets: Targets,
    /// The depth without its stencil, for shaders.
    pub(super) depth: wgpu::TextureView,
    pub(super) picture: wgpu::TextureView,
}

/// The format of pictures: egui takes textures that shaders encoded as sRGB.
pub(super) fn format(samples: u32) -> PictureFormat {
    PictureFormat { samples, in_parts: false, is_encoded: true }
}

impl Canvas {
    pub(super) fn new(resources: &Resources, size: [u32; 2], samples: u32) -> Result<Self, RenderError> {
        let limit = resources.factory.device.limits().max_texture_dimension_2d;
        let [width, height] = size;
        if width.max(height) > limit {
            return Err(RenderError::Size { width, height, limit });
        }
        let format = format(samples);
        let make = || Targets::new(&resources.factory, format, size, wgpu::TextureUsages::TEXTURE_BINDING);
        let targets = granted(&resources.factory.device, size, make)?;
        let aspect = wgpu::TextureAspect::DepthOnly;
        let depth = targets.attachments[0].depth.texture();
        let depth = depth.create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() });
        Ok(Self { size, format, depth, picture: view(&targets.picture), targets })
    }

    /// Bytes of all textures.
    pub(super) fn bytes(&self) -> u64 {
        let pixels = u64::from(self.size[0]) * u64::from(self.size[1]);
        let resolved = if self.format.samples > 1 { 8 } else { 0 };
        pixels * (u64::from(self.format.samples) * (8 + 8) + resolved + 4)
    }

    /// A pass onto the picture, over what is there.
    pub(super) fn pass<'e>(&self, encoder: &'e mut wgpu::CommandEncoder) -> wgpu::RenderPass<'e> {
        color_pass(encoder, "outline", (&self.picture, None), None, None)
    }
}

/// Makes textures and buffers of a picture, unless the device refuses them: most often it lacks memory. A browser answers later
/// than this returns, to the handler of all errors.
pub(super) fn granted<T>(
    device: &wgpu::Device,
    [width, height]: [u32; 2],
    make: impl FnOnce() -> T,
) -> Result<T, RenderError> {
    if cfg!(target_arch = "wasm32") {
        return Ok(make());
    }
    // A view of a texture that was refused is invalid.
    let scopes =
        [wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Validation].map(|filter| device.push_error_scope(filter));
    let made = make();
    let answer = |scope: wgpu::ErrorScopeGuard| match pin!(scope.pop()).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(error) => error,
        Poll::Pending => None,
    };
    match scopes.into_iter().rev().filter_map(answer).reduce(|_, outer| outer) {
        Some(error) => Err(RenderError::refused([width, height], &error)),
        None => Ok(made),
    }
}
