//! Textures of a picture, and what reads them.

use rimline_picture::{PictureFormat, Resources, Targets, color_pass, view};

use super::error::RenderError;
use super::gpu::granted;

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
        let targets = granted(&resources.factory.device, make).map_err(|why| RenderError::refused(size, why))?;
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
