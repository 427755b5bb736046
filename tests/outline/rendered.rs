//! A picture of outlines: the model's depth, then its lines, read back.

use rimline::gpu::{
    Extractor, ExtractorOptions, ListOptions, Outline, OutlineError, OutlineFormat, OutlineInputs, OutlinePipeline,
    OutlineSource, OutlineStyle, PositionBuffer,
};
use rimline::{Light, ShadowCamera};
use rimline_testkit::cases::Case;
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::passes;
use rimline_testkit::textures::texels;

/// Pixels along a side of the picture.
pub(crate) const SIDE: u32 = 256;

/// Textures that are drawn into and read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Attachments {
    pub(crate) depth: wgpu::TextureFormat,
    /// Samples of the depth that is read.
    pub(crate) depth_samples: u32,
    /// Whether that depth is attached, read-only, while it is read. Otherwise there is no depth attachment.
    pub(crate) is_attached: bool,
    /// The bias that its rounding needs.
    pub(crate) bias: f32,
}

impl Attachments {
    pub(crate) const ALL: [Self; 4] = [
        Self { depth: wgpu::TextureFormat::Depth32Float, depth_samples: 1, is_attached: true, bias: 1e-6 },
        Self { depth: wgpu::TextureFormat::Depth24Plus, depth_samples: 4, is_attached: false, bias: 1e-6 },
        Self { depth: wgpu::TextureFormat::Depth32Float, depth_samples: 4, is_attached: true, bias: 1e-6 },
        Self { depth: wgpu::TextureFormat::Depth16Unorm, depth_samples: 1, is_attached: false, bias: 4e-5 },
    ];

    fn format(self) -> OutlineFormat {
        OutlineFormat {
            color: wgpu::TextureFormat::Rgba8Unorm,
            depth_stencil: self.is_attached.then_some(self.depth),
            samples: if self.is_attached { self.depth_samples } else { 1 },
            is_depth_multisampled: self.depth_samples > 1,
        }
    }
}

/// The camera and the faces of a picture, and what it is drawn into.
pub(crate) struct Picture<'a> {
    pub(crate) camera: &'a ShadowCamera,
    /// Three corners a face, in world space.
    pub(crate) corners: Vec<[f32; 3]>,
    pub(crate) attachments: Attachments,
}

pub(crate) struct Inputs<'a> {
    pub(crate) case: &'a Case,
    pub(crate) camera: &'a ShadowCamera,
    pub(crate) light: Light,
    pub(crate) style: OutlineStyle,
    pub(crate) marks: Option<&'a [u32]>,
    pub(crate) capacity: Option<u32>,
    pub(crate) attachments: Attachments,
}

/// A texture of the picture's size.
fn texture(gpu: &Gpu, format: wgpu::TextureFormat, sample_count: u32) -> wgpu::Texture {
    let plain = passes::texture([SIDE; 2], format);
    let is_copied = sample_count == 1 && !format.has_depth_aspect();
    let copied = if is_copied { wgpu::TextureUsages::COPY_SRC } else { wgpu::TextureUsages::empty() };
    gpu.device.create_texture(&wgpu::TextureDescriptor { sample_count, usage: plain.usage | copied, ..plain })
}

/// The corners of the faces of a mesh.
pub(crate) fn corners((_, positions, mesh): &Case) -> Vec<[f32; 3]> {
    mesh.faces().iter().flatten().map(|&v| positions[v as usize]).collect()
}

/// The picture of an extraction's outline: see [`Picture::ink`].
pub(crate) fn render(gpu: &Gpu, inputs: &Inputs<'_>) -> Result<Vec<u8>, String> {
    let Inputs { case, camera, light, style, marks, capacity, attachments } = *inputs;
    let (_, positions, mesh) = case;
    // With 33 others before it the light is in the second batch.
    let others = if attachments.is_attached { 33 } else { 0 };
    let mut lights = vec![Light::point([3.0, 4.0, 5.0]); others];
    lights.push(light);
    let lists = Some(ListOptions { capacity, ..ListOptions::default() });
    let options = ExtractorOptions { max_lights: lights.len(), lists, ..ExtractorOptions::default() };
    let mut extractor = Extractor::new(&gpu.pipelines, mesh, options).map_err(text)?;
    let vertices = gpu.storage(positions);
    let marks = marks.map(|marks| gpu.storage(marks));
    Picture { camera, corners: corners(case), attachments }.ink(gpu, |encoder, outlines, depth| {
        let positions = PositionBuffer { buffer: &vertices, offset: 0, stride: 12 };
        let extraction = extractor.encode(encoder, positions, &lights).map_err(text)?;
        let of = OutlineSource::Extraction(&extraction, others);
        let marked = marks.as_ref();
        outlines.prepare(&OutlineInputs { of, camera, depth, style, marked }).map_err(text)
    })
}

impl Picture<'_> {
    /// The ink of each pixel, 0 to 255: black lines on white. `outline` is given the depth of the faces.
    pub(crate) fn ink(
        &self,
        gpu: &Gpu,
        outline: impl FnOnce(&mut wgpu::CommandEncoder, &OutlinePipeline, &wgpu::TextureView) -> Result<Outline, String>,
    ) -> Result<Vec<u8>, String> {
        let Self { camera, corners, attachments } = self;
        let Attachments { depth: format, depth_samples, is_attached, .. } = *attachments;
        let of_pass = attachments.format();
        let outlines =
            gpu.kept(&format!("{of_pass:?}"), || OutlinePipeline::new(&gpu.pipelines, &of_pass).map_err(text))?;

        let target = texture(gpu, of_pass.color, 1);
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        let depth_view = view(&texture(gpu, format, depth_samples));
        let sampled = (of_pass.samples > 1).then(|| view(&texture(gpu, of_pass.color, of_pass.samples)));

        gpu.submit(|encoder| {
            let outline = outline(encoder, &outlines, &depth_view)?;
            passes::draw_surfaces(gpu, encoder, &depth_view, camera, corners)?;
            let target_view = view(&target);
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("outlines"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: sampled.as_ref().unwrap_or(&target_view),
                    depth_slice: None,
                    resolve_target: sampled.as_ref().map(|_| &target_view),
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::WHITE),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                depth_stencil_attachment: is_attached.then_some(wgpu::RenderPassDepthStencilAttachment {
                    view: &depth_view,
                    depth_ops: None,
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            outline.draw(&mut pass).map_err(text)?;
            Ok(())
        })?;
        Ok(texels(gpu, &target, 0)?.iter().step_by(4).map(|red| 255 - red).collect())
    }
}

/// Draws an outline into small colours of the default format.
pub(crate) fn draw_small(gpu: &Gpu, outline: &Outline) -> Result<Result<(), OutlineError>, String> {
    let target = gpu.device.create_texture(&passes::texture([8; 2], OutlineFormat::default().color));
    let view = &target.create_view(&wgpu::TextureViewDescriptor::default());
    let (depth_slice, resolve_target, ops) = (None, None, wgpu::Operations::default());
    let attachment = wgpu::RenderPassColorAttachment { view, depth_slice, resolve_target, ops };
    let color_attachments = &[Some(attachment)];
    let pass = wgpu::RenderPassDescriptor { color_attachments, ..Default::default() };
    gpu.submit(|encoder| Ok(outline.draw(&mut encoder.begin_render_pass(&pass))))
}
