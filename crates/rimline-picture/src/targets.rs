//! Textures that a picture or a mask is drawn into.

use wgpu::{TextureFormat, TextureUsages};

use crate::bindings::{depth_format, read_texture};
use crate::factory::{PipelineFactory, color_pass, plain_texture, view};
use crate::frame::{PARTS, Part};

/// The colour target of a pass.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its format.
    pub format: TextureFormat,
    /// Samples a pixel.
    pub samples: u32,
}

/// How a picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureFormat {
    /// Samples a pixel: 1 or 4; 1 with [`Self::in_parts`].
    pub samples: u32,
    /// Whether [`PARTS`] parts are drawn one after the other, whose pixels take turns.
    pub in_parts: bool,
    /// Whether the picture is of format `Rgba8Unorm` and encoded as sRGB by its shader. Else the format is `Rgba8UnormSrgb`.
    /// Not with [`Self::in_parts`], whose shader does not encode.
    pub is_encoded: bool,
}

impl PictureFormat {
    /// The target of linear light.
    pub fn light(self) -> Target {
        Target { format: TextureFormat::Rgba16Float, samples: self.samples }
    }

    /// The format of the picture.
    pub fn picture(self) -> TextureFormat {
        if self.is_encoded { TextureFormat::Rgba8Unorm } else { TextureFormat::Rgba8UnormSrgb }
    }

    /// The layout of the light that the picture is made of.
    pub(crate) fn light_layout(self, factory: &PipelineFactory) -> wgpu::BindGroupLayout {
        let dimension =
            if self.in_parts { wgpu::TextureViewDimension::D2Array } else { wgpu::TextureViewDimension::D2 };
        factory.layout(&[read_texture(dimension, false)])
    }
}

/// Colour and depth of a pass.
#[derive(Debug)]
pub struct Attachments {
    /// The colour.
    pub color: wgpu::TextureView,
    /// The mean of the samples, where they are several.
    pub resolved: Option<wgpu::TextureView>,
    /// Depth and stencil.
    pub depth: wgpu::TextureView,
}

impl Attachments {
    /// A pass that counts shadow volumes in the stencil, from 0 on, against the depth that is there.
    pub fn count_pass<'e>(&self, encoder: &'e mut wgpu::CommandEncoder) -> wgpu::RenderPass<'e> {
        let store = wgpu::StoreOp::Store;
        // Software drivers would read and write colours that no volume changes.
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("volumes"),
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Load, store }),
                stencil_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0), store }),
            }),
            ..Default::default()
        })
    }

    /// A pass that goes on with what is there, or clears everything.
    pub fn pass<'e>(
        &self,
        encoder: &'e mut wgpu::CommandEncoder,
        label: &str,
        clear: Option<wgpu::Color>,
    ) -> wgpu::RenderPass<'e> {
        color_pass(encoder, label, (&self.color, None), clear, Some(&self.depth))
    }

    /// A last pass, after which the samples are resolved.
    pub(crate) fn last_pass<'e>(&self, encoder: &'e mut wgpu::CommandEncoder) -> wgpu::RenderPass<'e> {
        color_pass(encoder, "resolve", (&self.color, self.resolved.as_ref()), None, Some(&self.depth))
    }
}

/// The targets of a picture.
#[derive(Debug)]
pub struct Targets {
    /// The attachments of the whole picture, or of each part. Parts share depth and stencil, so all passes of one part
    /// must come before those of the next.
    pub attachments: Vec<Attachments>,
    /// Binds the light that the picture is made of.
    pub(crate) light: wgpu::BindGroup,
    /// The finished picture.
    pub picture: wgpu::Texture,
}

impl Targets {
    /// For pictures of this size. `depth` has further usages of the depth.
    pub fn new(factory: &PipelineFactory, format: PictureFormat, size: [u32; 2], depth: TextureUsages) -> Self {
        let (attachments, light) =
            if format.in_parts { parts(factory, format, size, depth) } else { whole(factory, format, size, depth) };
        let usage = TextureUsages::COPY_SRC | TextureUsages::TEXTURE_BINDING;
        Self {
            light: factory.group(&format.light_layout(factory), &[wgpu::BindingResource::TextureView(&light)]),
            picture: factory.target("picture", size, format.picture(), 1, usage),
            attachments,
        }
    }
}

/// The attachments of a whole picture, and its light.
fn whole(
    factory: &PipelineFactory,
    format: PictureFormat,
    size: [u32; 2],
    depth: TextureUsages,
) -> (Vec<Attachments>, wgpu::TextureView) {
    let Target { format, samples } = format.light();
    let light = |samples, usage| view(&factory.target("light", size, format, samples, usage));
    let read = TextureUsages::TEXTURE_BINDING;
    let (color, resolved) = if samples > 1 {
        // With wgpu 30, OpenGL has no multisampled textures that shaders read, only targets.
        (light(samples, TextureUsages::empty()), Some(light(1, read)))
    } else {
        (light(1, read), None)
    };
    let depth = view(&factory.target("depth", size, depth_format(&factory.device), samples, depth));
    let light = resolved.as_ref().unwrap_or(&color).clone();
    (vec![Attachments { color, resolved, depth }], light)
}

/// The attachments of a picture's parts, and the layers of their light.
fn parts(
    factory: &PipelineFactory,
    format: PictureFormat,
    size: [u32; 2],
    depth: TextureUsages,
) -> (Vec<Attachments>, wgpu::TextureView) {
    let size = Part::size(size);
    let depth = view(&factory.target("depth", size, depth_format(&factory.device), 1, depth));
    let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::RENDER_ATTACHMENT;
    let plain = plain_texture("light", size, format.light().format, usage);
    let size = wgpu::Extent3d { depth_or_array_layers: PARTS as u32, ..plain.size };
    let layers = factory.device.create_texture(&wgpu::TextureDescriptor { size, ..plain });
    let attachments = (0..PARTS as u32).map(|layer| {
        let color = layers.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: layer,
            array_layer_count: Some(1),
            ..Default::default()
        });
        Attachments { color, resolved: None, depth: depth.clone() }
    });
    (attachments.collect(), view(&layers))
}
