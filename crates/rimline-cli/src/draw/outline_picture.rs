//! The picture's passes, in order: survey, contact shadow, paper and model, occlusion, lines.

use rimline::gpu::{Extraction, include_wgsl, results_bind_group_layout};
use rimline::wgpu;
use rimline_picture::{
    Bounds, LARGEST, MULTIPLY, Pass, PipelineFactory, READ_ONLY, UNIFORM, color_pass, depth_state, plain_texture,
    read_texture, view,
};
use wgpu::{
    BindGroup, BindGroupLayout, BindingResource, BindingType, BlendState, PrimitiveTopology, ShaderStages,
    TextureFormat, TextureUsages,
};

use super::frame::{Frame, Region};
use crate::device::{Gpu, GpuError};

/// The picture's format: sRGB, so that blending and resolving work on light.
const FORMAT: TextureFormat = TextureFormat::Rgba8UnormSrgb;
const SAMPLES: u32 = 4;

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

/// Faces, and a normal and a base colour, if there are any, for each of their corners.
type Drawn<'a> = (&'a [[u32; 3]], &'a [u32], Option<&'a [[u32; 3]]>);

impl<'a> Canvas<'a> {
    pub(super) fn new(factory: &'a PipelineFactory, (frame, bounds): (&'a Frame, &'a Bounds), size: [u32; 2]) -> Self {
        factory.set_frame(bytemuck::bytes_of(frame));
        let target = |label, format, samples, usage| view(&factory.target(label, size, format, samples, usage));
        let readable = TextureUsages::TEXTURE_BINDING;
        Self {
            colour: target("colour", FORMAT, SAMPLES, TextureUsages::empty()),
            depth: target("depth", TextureFormat::Depth32Float, SAMPLES, TextureUsages::empty()),
            survey: Survey::new(factory, size, frame.survey_scale),
            occlusion: target("occlusion", TextureFormat::R8Unorm, 1, readable),
            finished: factory.target("picture", size, FORMAT, 1, TextureUsages::COPY_SRC),
            factory,
            frame,
            bounds,
        }
    }

    /// Records the survey, paper, contact shadow and the shaded model: faces whose positions are finite, a folded normal and a
    /// packed base colour for each corner. Returns the buffer of faces.
    pub(super) fn model(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipelines: &ModelPipelines,
        positions: &wgpu::Buffer,
        (faces, normals, colors): Drawn<'_>,
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
        let region = self.frame.region_on_ground(self.bounds, SPREAD, CONTACT_SIZE);
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
        let survey_size = [self.finished.width(), self.finished.height()].map(|pixels| frame.survey_scale * pixels);
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

pub(super) const CONTACT_SIZE: u32 = 512;
/// How far all blurs together spread, in pixels: twelve samples on each side, and the neighbours that each is mixed with.
pub(super) const SPREAD: f64 = 12.0 * (1.6 + 0.7) + 2.0;
const CONTACT: TextureFormat = TextureFormat::R8Unorm;

pub(super) struct ContactShadow {
    /// The layout with which the ground reads the map, and each blur the map before.
    pub(super) layout: BindGroupLayout,
    below: wgpu::RenderPipeline,
    blur: wgpu::RenderPipeline,
}

impl ContactShadow {
    /// `geometry` is the layout of the model's group.
    pub(super) fn new(factory: &PipelineFactory, geometry: &BindGroupLayout) -> Self {
        let map = read_texture(wgpu::TextureViewDimension::D2, true);
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let layout = factory.layout(&[map, sampler, UNIFORM]);
        let (model, screen) = (include_str!("model.wgsl"), include_str!("screen.wgsl"));
        Self {
            // Whatever is nearest to the ground counts, in any order.
            below: factory.pipeline(&Pass { blend: Some(LARGEST), ..Pass::new("below", model, &[geometry], CONTACT) }),
            blur: factory.pipeline(&Pass::over("blur", screen, &[&layout], CONTACT)),
            layout,
        }
    }

    /// Records the map of so many corners, which is black but for a region, and returns the group that the ground reads
    /// it with.
    pub(super) fn record(
        &self,
        factory: &PipelineFactory,
        encoder: &mut wgpu::CommandEncoder,
        (geometry, region): (&BindGroup, Region),
        corners: u32,
    ) -> BindGroup {
        let [first, second] = ["contact map", "blurred contact map"].map(|label| {
            view(&factory.target(label, [CONTACT_SIZE; 2], CONTACT, 1, wgpu::TextureUsages::TEXTURE_BINDING))
        });
        let black = Some(wgpu::Color::BLACK);
        let mut pass = color_pass(encoder, "below", (&first, None), black, None);
        factory.draw(&mut pass, &self.below, &[geometry], corners);
        drop(pass);
        let sampler = factory.device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let group = |view, pitch: [f32; 2]| {
            let pitch = factory.uniform("pitch", bytemuck::bytes_of(&pitch));
            let map = BindingResource::TextureView(view);
            factory.group(&self.layout, &[map, BindingResource::Sampler(&sampler), pitch.as_entire_binding()])
        };
        for (pitch, across) in [(1.6, true), (1.6, false), (0.7, true), (0.7, false)] {
            let (source, target) = if across { (&first, &second) } else { (&second, &first) };
            let pitch = if across { [pitch, 0.0] } else { [0.0, pitch] };
            let mut pass = color_pass(encoder, "blur", (target, None), black, None);
            if region.keep(&mut pass) {
                factory.draw(&mut pass, &self.blur, &[&group(source, pitch)], 3);
            }
        }
        group(&first, [0.0; 2])
    }
}

const SURVEY: TextureFormat = TextureFormat::Rgba16Uint;

/// The nearest is drawn and written.
pub(super) fn nearest() -> wgpu::DepthStencilState {
    depth_state(TextureFormat::Depth32Float, true, wgpu::CompareFunction::Greater, wgpu::StencilFaceState::IGNORE)
}

pub(super) const SEEN: BindingType = BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Uint,
    view_dimension: wgpu::TextureViewDimension::D2,
    multisampled: false,
};

/// Pictures with more pixels than this, in which faces smaller than pixels are rare, have one texel of the survey a pixel.
const MOST_FINE: u64 = 1 << 23;

/// Texels of the survey along a pixel's side, for a picture of this size.
pub(super) fn survey_scale([width, height]: [u32; 2], most: u32) -> u32 {
    let is_small = u64::from(width) * u64::from(height) <= MOST_FINE && width.max(height) <= most / 2;
    if is_small { 2 } else { 1 }
}

pub(super) struct Survey {
    pub(super) seen: wgpu::TextureView,
    depth: wgpu::TextureView,
}

impl Survey {
    pub(super) fn new(factory: &PipelineFactory, size: [u32; 2], scale: u32) -> Self {
        let target =
            |label, format, usage| view(&factory.target(label, size.map(|pixels| scale * pixels), format, 1, usage));
        Self {
            seen: target("survey", SURVEY, TextureUsages::TEXTURE_BINDING),
            depth: target("survey depth", TextureFormat::Depth32Float, TextureUsages::empty()),
        }
    }

    pub(super) fn pipeline(factory: &PipelineFactory, geometry: &BindGroupLayout) -> wgpu::RenderPipeline {
        let source = include_str!("model.wgsl");
        factory.pipeline(&Pass { depth: Some(nearest()), ..Pass::new("survey", source, &[geometry], SURVEY) })
    }

    pub(super) fn record(
        &self,
        factory: &PipelineFactory,
        encoder: &mut wgpu::CommandEncoder,
        pipeline: &wgpu::RenderPipeline,
        geometry: &BindGroup,
        corners: u32,
    ) {
        let nothing = Some(wgpu::Color::TRANSPARENT);
        let mut pass = color_pass(encoder, "survey", (&self.seen, None), nothing, Some(&self.depth));
        factory.draw(&mut pass, pipeline, &[geometry], corners);
    }

    /// The layout of the survey, positions and drawn faces for `lines.wgsl`. Vertex shaders do not see them: what lists
    /// are read by there leaves no room for more storage buffers.
    pub(super) fn layout(factory: &PipelineFactory) -> BindGroupLayout {
        rimline_picture::layout(&factory.device, ShaderStages::FRAGMENT, &[SEEN, READ_ONLY, READ_ONLY])
    }

    pub(super) fn group(
        &self,
        factory: &PipelineFactory,
        layout: &BindGroupLayout,
        [positions, faces]: [&wgpu::Buffer; 2],
    ) -> BindGroup {
        let resources =
            [BindingResource::TextureView(&self.seen), positions.as_entire_binding(), faces.as_entire_binding()];
        factory.group(layout, &resources)
    }
}

/// Bits of floats, as OpenGL need not draw onto floats.
const VEIL: TextureFormat = TextureFormat::R32Uint;

/// The side of a square of the finest level, in texels of the survey; as in `veil.wgsl`, and `SQUARE_BITS` in `lines.wgsl`.
const SQUARE: u32 = 8;

pub(super) struct Veils {
    /// One texture that vertices and fragments see.
    pub(super) layout: BindGroupLayout,
    finest: wgpu::RenderPipeline,
    coarser: wgpu::RenderPipeline,
}

impl Veils {
    /// `survey` is the layout of the survey's group, as `lines.wgsl` reads it.
    pub(super) fn new(factory: &PipelineFactory, survey: &BindGroupLayout) -> Self {
        let layout = factory.layout(&[SEEN]);
        let pipeline = |name, group| factory.pipeline(&Pass::over(name, include_str!("veil.wgsl"), &[group], VEIL));
        let (finest, coarser) = (pipeline("veil", survey), pipeline("veil_level", &layout));
        Self { layout, finest, coarser }
    }

    /// Records the veils of a survey of this size. Returns the group that lines read the veils with.
    pub(super) fn record(
        &self,
        factory: &PipelineFactory,
        encoder: &mut wgpu::CommandEncoder,
        survey: &BindGroup,
        texels: [u32; 2],
    ) -> BindGroup {
        // Each level has half of the squares of the finer one, and none is left over.
        let size = texels.map(|texels| texels.div_ceil(SQUARE).next_power_of_two());
        let levels = size[0].max(size[1]).ilog2() + 1;
        let usage = TextureUsages::TEXTURE_BINDING | TextureUsages::RENDER_ATTACHMENT;
        let plain = plain_texture("veils", size, VEIL, usage);
        let texture = factory.device.create_texture(&wgpu::TextureDescriptor { mip_level_count: levels, ..plain });
        let level = |level| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                base_mip_level: level,
                mip_level_count: Some(1),
                ..Default::default()
            })
        };
        let group = |of: &wgpu::TextureView| factory.group(&self.layout, &[BindingResource::TextureView(of)]);
        let mut draw = |pipeline: &wgpu::RenderPipeline, target: u32, source: &BindGroup| {
            let nothing = Some(wgpu::Color::TRANSPARENT);
            let mut pass = color_pass(encoder, "veils", (&level(target), None), nothing, None);
            factory.draw(&mut pass, pipeline, &[source], 3);
        };
        draw(&self.finest, 0, survey);
        for target in 1..levels {
            draw(&self.coarser, target, &group(&level(target - 1)));
        }
        group(&view(&texture))
    }
}
