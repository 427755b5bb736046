//! The picture's passes, in order: survey, contact shadow, paper and model, occlusion, lines.

use rimline::gpu::{Extraction, include_wgsl, results_bind_group_layout};
use rimline::wgpu;
use rimline_picture::Bounds;
use wgpu::{BlendState, PrimitiveTopology, TextureFormat, TextureUsages};

use super::contact_shadow::{self, ContactShadow};
use super::frame::Frame;
use super::survey::{SEEN, Survey, Veils, nearest};
use crate::device::Gpu;
use crate::gpu_error::GpuError;
use rimline_picture::{MULTIPLY, Pass, PipelineFactory, READ_ONLY, color_pass, read_texture, view};

/// The picture's format: sRGB, so that blending and resolving work on light.
const FORMAT: TextureFormat = TextureFormat::Rgba8UnormSrgb;
const SAMPLES: u32 = 4;

/// The pipelines of the first passes: the survey, the contact shadow, the paper and the model.
pub(super) struct ModelPipelines {
    geometry: wgpu::BindGroupLayout,
    survey: wgpu::RenderPipeline,
    contact: ContactShadow,
    backdrop: wgpu::RenderPipeline,
    shadow: wgpu::RenderPipeline,
    surface: wgpu::RenderPipeline,
}

impl ModelPipelines {
    pub(super) fn new(factory: &PipelineFactory) -> Self {
        let geometry = factory.layout(&[READ_ONLY; 4]);
        let contact = ContactShadow::new(factory, &geometry);
        let source = include_str!("model.wgsl");
        // Paper and ground are behind the model, whatever is there.
        let behind = wgpu::DepthStencilState {
            depth_write_enabled: Some(false),
            depth_compare: Some(wgpu::CompareFunction::Always),
            ..nearest()
        };
        let picture = |pass, depth| factory.pipeline(&Pass { samples: SAMPLES, depth: Some(depth), ..pass });
        let map = [&contact.layout];
        let shadow = Pass {
            topology: PrimitiveTopology::TriangleStrip,
            blend: Some(MULTIPLY),
            ..Pass::new("shadow", source, &map, FORMAT)
        };
        Self {
            survey: Survey::pipeline(factory, &geometry),
            backdrop: picture(Pass::over("backdrop", source, &[], FORMAT), behind.clone()),
            shadow: picture(shadow, behind),
            surface: picture(Pass::new("surface", source, &[&geometry], FORMAT), nearest()),
            contact,
            geometry,
        }
    }
}

/// The pipelines of what goes over the model: occlusion and lines.
pub(super) struct LinePipelines {
    seen: wgpu::BindGroupLayout,
    occlusion: wgpu::RenderPipeline,
    darkening: wgpu::BindGroupLayout,
    darken: wgpu::RenderPipeline,
    survey: wgpu::BindGroupLayout,
    results: wgpu::BindGroupLayout,
    veils: Veils,
    lines: wgpu::RenderPipeline,
}

impl LinePipelines {
    pub(super) fn new(factory: &PipelineFactory) -> Self {
        let seen = factory.layout(&[SEEN]);
        let darkening = factory.layout(&[SEEN, read_texture(wgpu::TextureViewDimension::D2, true)]);
        let survey = Survey::layout(factory);
        let results = results_bind_group_layout(&factory.device, wgpu::ShaderStages::VERTEX);
        let veils = Veils::new(factory, &survey);
        let screen = include_str!("screen.wgsl");
        let occlusion = factory.pipeline(&Pass::over("occlusion", screen, &[&seen], TextureFormat::R8Unorm));
        let darken = factory.pipeline(&Pass {
            blend: Some(MULTIPLY),
            samples: SAMPLES,
            ..Pass::over("darken", screen, &[&darkening], FORMAT)
        });
        let lines = format!("{}\n{}", include_wgsl(2), include_str!("lines.wgsl"));
        let groups = [&survey, &results, &veils.layout];
        let lines = Pass {
            topology: PrimitiveTopology::TriangleStrip,
            blend: Some(BlendState::ALPHA_BLENDING),
            samples: SAMPLES,
            ..Pass::new("lines", &lines, &groups, FORMAT)
        };
        Self { occlusion, darken, lines: factory.pipeline(&lines), seen, darkening, survey, results, veils }
    }
}

/// Makes pipelines and groups of the picture. [`Canvas::new`] tells it the frame.
pub(super) fn factory(gpu: &Gpu) -> PipelineFactory {
    PipelineFactory::new((&gpu.device, &gpu.queue), include_str!("frame.wgsl"), &[0; size_of::<Frame>()])
}

/// The corners of the faces that are drawn.
pub(super) struct Corners<'a> {
    /// Their positions are finite.
    pub(super) faces: &'a [[u32; 3]],
    /// One a corner, folded.
    pub(super) normals: &'a [u32],
    /// Base colours, packed.
    pub(super) colors: Option<&'a [[u32; 3]]>,
}

/// The targets, and what reads them.
pub(super) struct Canvas<'a> {
    factory: &'a PipelineFactory,
    frame: &'a Frame,
    /// All that is drawn is within it.
    bounds: &'a Bounds,
    colour: wgpu::TextureView,
    depth: wgpu::TextureView,
    survey: Survey,
    occlusion: wgpu::TextureView,
    finished: wgpu::Texture,
}

impl<'a> Canvas<'a> {
    pub(super) fn new(factory: &'a PipelineFactory, (frame, bounds): (&'a Frame, &'a Bounds), size: [u32; 2]) -> Self {
        factory.set_frame(bytemuck::bytes_of(frame));
        let target = |label, format, samples, usage| view(&factory.target(label, size, format, samples, usage));
        let readable = TextureUsages::TEXTURE_BINDING;
        Self {
            colour: target("colour", FORMAT, SAMPLES, TextureUsages::empty()),
            depth: target("depth", TextureFormat::Depth32Float, SAMPLES, TextureUsages::empty()),
            survey: Survey::new(factory, size, frame.survey_scale()),
            occlusion: target("occlusion", TextureFormat::R8Unorm, 1, readable),
            finished: factory.target("picture", size, FORMAT, 1, TextureUsages::COPY_SRC),
            factory,
            frame,
            bounds,
        }
    }

    /// Records the survey, paper, contact shadow and the shaded model. Returns the buffer of faces.
    pub(super) fn model(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipelines: &ModelPipelines,
        positions: &wgpu::Buffer,
        Corners { faces, normals, colors }: Corners<'_>,
    ) -> wgpu::Buffer {
        let Self { factory, .. } = *self;
        let corners = 3 * faces.len() as u32;
        let faces = factory.buffer("drawn faces", bytemuck::cast_slice(faces));
        let normals = factory.buffer("normals", bytemuck::cast_slice(normals));
        let colors = factory.buffer("colors", bytemuck::cast_slice(colors.unwrap_or_default()));
        let resources = [positions, &faces, &normals, &colors].map(wgpu::Buffer::as_entire_binding);
        let geometry = factory.group(&pipelines.geometry, &resources);
        self.survey.record(factory, encoder, &pipelines.survey, &geometry, corners);
        let contact = &pipelines.contact;
        let sees_ground = self.frame.sees_ground();
        let region = self.frame.region_on_ground(self.bounds, contact_shadow::SPREAD, contact_shadow::SIZE);
        let shadow = sees_ground.then(|| contact.record(factory, encoder, (&geometry, region), corners));

        let white = Some(wgpu::Color::WHITE);
        let mut pass = color_pass(encoder, "model", (&self.colour, None), white, Some(&self.depth));
        factory.draw(&mut pass, &pipelines.backdrop, &[], 3);
        if let Some(group) = &shadow {
            factory.draw(&mut pass, &pipelines.shadow, &[group], 4);
        }
        factory.draw(&mut pass, &pipelines.surface, &[&geometry], corners);
        drop(pass);
        faces
    }

    /// Records how little light from all around comes to each pixel, which darkens the model, and the lines over it. The
    /// lists of `extraction` hold the silhouette for the eye, as light 0. Returns the finished picture's texture.
    pub(super) fn lines(
        self,
        encoder: &mut wgpu::CommandEncoder,
        pipelines: &LinePipelines,
        extraction: &Extraction,
        buffers: [&wgpu::Buffer; 2],
    ) -> Result<wgpu::Texture, GpuError> {
        let Self { factory, frame, .. } = self;
        let region = frame.region(self.bounds);
        let seen = wgpu::BindingResource::TextureView(&self.survey.seen);
        let group = factory.group(&pipelines.seen, std::slice::from_ref(&seen));
        let mut pass = color_pass(encoder, "occlusion", (&self.occlusion, None), Some(wgpu::Color::WHITE), None);
        if region.keep(&mut pass) {
            factory.draw(&mut pass, &pipelines.occlusion, &[&group], 3);
        }
        drop(pass);
        let occlusion = wgpu::BindingResource::TextureView(&self.occlusion);
        let darkening = factory.group(&pipelines.darkening, &[seen, occlusion]);
        let results = extraction.bind_group(&pipelines.results, 0)?;
        let survey = self.survey.group(factory, &pipelines.survey, buffers);
        let survey_size = [self.finished.width(), self.finished.height()].map(|pixels| frame.survey_scale() * pixels);
        let veils = pipelines.veils.record(factory, encoder, &survey, survey_size);
        let finished = view(&self.finished);
        let mut pass = color_pass(encoder, "lines", (&self.colour, Some(&finished)), None, None);
        if region.keep(&mut pass) {
            factory.draw(&mut pass, &pipelines.darken, &[&darkening], 3);
        }
        pass.set_scissor_rect(0, 0, self.finished.width(), self.finished.height());
        factory.bind(&mut pass, &pipelines.lines, &[&survey, &results, &veils]);
        // The draw is indirect: the CPU never learns how many lines the GPU found.
        extraction.draw(&mut pass, 0)?;
        drop(pass);
        Ok(self.finished)
    }
}
