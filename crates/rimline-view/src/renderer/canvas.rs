//! Textures of a picture, and what reads them.

use rimline_picture::{Part, PictureFormat, Resources, Targets, color_pass, view};

use super::error::RenderError;
use super::gpu::granted;

/// How a picture is drawn.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Quality {
    /// Samples a pixel.
    pub(super) samples: u32,
    /// How many pixels of the window a pixel of the picture is wide and high: 1 or 2.
    pub(super) step: u32,
}

/// Pictures of more pixels have steps of 2 where the device is software and something moves.
const MOST_HURRIED: u64 = 1 << 18;

impl Quality {
    /// The quality that software devices have time for while something moves.
    pub(super) fn hurried([width, height]: [u32; 2]) -> Self {
        let pixels = u64::from(width) * u64::from(height);
        Self { samples: 1, step: if pixels > MOST_HURRIED { 2 } else { 1 } }
    }
}

/// The targets of a picture of one size.
pub(super) struct Canvas {
    /// The size of the picture in pixels of the window.
    pub(super) of: [u32; 2],
    pub(super) quality: Quality,
    /// The pixels that are drawn, and how many there are.
    pub(super) part: Part,
    pub(super) size: [u32; 2],
    pub(super) format: PictureFormat,
    pub(super) targets: Targets,
    /// The depth without its stencil, for shaders.
    pub(super) depth: wgpu::TextureView,
    pub(super) picture: wgpu::TextureView,
}

/// The format of pictures: encoded as sRGB by shaders, since the panel's targets are not sRGB.
pub(super) fn format(samples: u32) -> PictureFormat {
    PictureFormat { samples, in_parts: false, is_encoded: true }
}

impl Canvas {
    pub(super) fn new(resources: &Resources, of: [u32; 2], quality: Quality) -> Result<Self, RenderError> {
        let limit = resources.factory.device.limits().max_texture_dimension_2d;
        let [width, height] = of;
        if width.max(height) > limit {
            return Err(RenderError::Size { width, height, limit });
        }
        let (size, part) = if quality.step > 1 { (Part::size(of), Part::halved(of)) } else { (of, Part::WHOLE) };
        let format = format(quality.samples);
        let make = || Targets::new(&resources.factory, format, size, wgpu::TextureUsages::TEXTURE_BINDING);
        let targets = granted(&resources.factory.device, make).map_err(|why| RenderError::refused(size, why))?;
        let aspect = wgpu::TextureAspect::DepthOnly;
        let depth = targets.attachments[0].depth.texture();
        let depth = depth.create_view(&wgpu::TextureViewDescriptor { aspect, ..Default::default() });
        Ok(Self { of, quality, part, size, format, depth, picture: view(&targets.picture), targets })
    }

    /// Whether it is for pictures of a size and quality.
    pub(super) fn is_for(&self, of: [u32; 2], quality: Quality) -> bool {
        self.of == of && self.quality == quality
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
