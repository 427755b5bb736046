//! The picture's passes, in order: survey, contact shadow, paper and model, occlusion, lines.

use rimline::gpu::{Extraction, include_wgsl, results_bind_group_layout};
use rimline::wgpu;
use rimline_picture::{
    Bounds, LARGEST, MULTIPLY, PipelineDescriptor, PipelineFactory, READ_ONLY, UNIFORM, color_pass, depth_state,
    plain_texture, read_texture, view,
};
use wgpu::{
    BindGroup, BindGroupLayout, BindingResource, BindingType, BlendState, Color, PrimitiveTopology, RenderPipeline,
    ShaderStages, TextureFormat, TextureUsages, TextureView, TextureViewDimension,
};

use super::frame::Frame;
use crate::device::{Gpu, GpuError};

/// The picture's format: sRGB, so that blending and resolving work on light.
const FORMAT: TextureFormat = TextureFormat::Rgba8UnormSrgb;
const SAMPLES: u32 = 4;
const DEPTH: TextureFormat = TextureFormat::Depth32Float;

const SURVEY: TextureFormat = TextureFormat::Rgba16Uint;
/// Pictures with more pixels than this, in which faces smaller than pixels are rare, have one texel of the survey a pixel.
const MOST_FINE: u64 = 1 << 23;

const CONTACT: TextureFormat = TextureFormat::R8Unorm;
const CONTACT_SIZE: u32 = 512;
/// How far all blurs together spread, in pixels: twelve samples on each side, and the neighbours that each is mixed with.
const SPREAD: f32 = 12.0 * (1.6 + 0.7) + 2.0;

/// Bits of floats, as OpenGL need not draw onto floats.
const VEIL: TextureFormat = TextureFormat::R32Uint;
/// The side of a square of the finest level, in texels of the survey; as in `veil.wgsl`, and `SQUARE_BITS` in `lines.wgsl`.
const SQUARE: u32 = 8;

/// The survey, or a level of the veils.
const SEEN: BindingType = BindingType::Texture {
    sample_type: wgpu::TextureSampleType::Uint,
    view_dimension: TextureViewDimension::D2,
    multisampled: false,
};

pub(super) struct ModelPipelines {
    /// Positions, faces, normals and colours.
    geometry: BindGroupLayout,
    /// The contact map, as the ground and each blur read it.
    map: BindGroupLayout,
    survey: RenderPipeline,
    below: RenderPipeline,
    blur: RenderPipeline,
    backdrop: RenderPipeline,
    shadow: RenderPipeline,
    surface: RenderPipeline,
}

impl ModelPipelines {
    pub(super) fn new(factory: &PipelineFactory) -> Self {
        let geometry = factory.layout(&[READ_ONLY; 4]);
        let sampler = BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let map = factory.layout(&[read_texture(TextureViewDimension::D2, true), sampler, UNIFORM]);
        let (model, screen) = (include_str!("model.wgsl"), include_str!("screen.wgsl"));
        let (of_model, of_map) = ([&geometry], [&map]);
        // Paper and ground are always behind the model.
        let behind = wgpu::DepthStencilState {
            depth_write_enabled: Some(false),
            depth_compare: Some(wgpu::CompareFunction::Always),
            ..nearest()
        };
        let picture = |of, depth| factory.pipeline(&PipelineDescriptor { samples: SAMPLES, depth: Some(depth), ..of });
        let shadow = PipelineDescriptor {
            topology: PrimitiveTopology::TriangleStrip,
            blend: Some(MULTIPLY),
            ..PipelineDescriptor::new("shadow", model, &of_map, FORMAT)
        };
        Self {
            survey: factory.pipeline(&PipelineDescriptor {
                depth: Some(nearest()),
                ..PipelineDescriptor::new("survey", model, &of_model, SURVEY)
            }),
            // The nearest to the ground counts, in any order.
            below: factory.pipeline(&PipelineDescriptor {
                blend: Some(LARGEST),
                ..PipelineDescriptor::new("below", model, &of_model, CONTACT)
            }),
            blur: factory.pipeline(&PipelineDescriptor::over("blur", screen, &of_map, CONTACT)),
            backdrop: picture(PipelineDescriptor::over("backdrop", model, &[], FORMAT), behind.clone()),
            shadow: picture(shadow, behind),
            surface: picture(PipelineDescriptor::new("surface", model, &of_model, FORMAT), nearest()),
            geometry,
            map,
        }
    }
}

/// The nearest is drawn and written.
fn nearest() -> wgpu::DepthStencilState {
    depth_state(DEPTH, true, wgpu::CompareFunction::Greater, wgpu::StencilFaceState::IGNORE)
}

pub(super) struct LinePipelines {
    seen: BindGroupLayout,
    darkening: BindGroupLayout,
    /// The survey, positions and drawn faces for `lines.wgsl`.
    survey: BindGroupLayout,
    results: BindGroupLayout,
    occlusion: RenderPipeline,
    darken: RenderPipeline,
    veil: RenderPipeline,
    coarser_veil: RenderPipeline,
    lines: RenderPipeline,
}

impl LinePipelines {
    pub(super) fn new(factory: &PipelineFactory) -> Self {
        let seen = factory.layout(&[SEEN]);
        let darkening = factory.layout(&[SEEN, read_texture(TextureViewDimension::D2, true)]);
        // Vertex shaders do not see it: the lists that they read leave no room for more storage buffers.
        let survey = rimline_picture::layout(&factory.device, ShaderStages::FRAGMENT, &[SEEN, READ_ONLY, READ_ONLY]);
        let results = results_bind_group_layout(&factory.device, ShaderStages::VERTEX);
        let (screen, veil) = (include_str!("screen.wgsl"), include_str!("veil.wgsl"));
        let darken = factory.pipeline(&PipelineDescriptor {
            blend: Some(MULTIPLY),
            samples: SAMPLES,
            ..PipelineDescriptor::over("darken", screen, &[&darkening], FORMAT)
        });
        let lines = format!("{}\n{}", include_wgsl(2), include_str!("lines.wgsl"));
        let groups = [&survey, &results, &seen];
        let lines = PipelineDescriptor {
            topology: PrimitiveTopology::TriangleStrip,
            blend: Some(BlendState::ALPHA_BLENDING),
            samples: SAMPLES,
            ..PipelineDescriptor::new("lines", &lines, &groups, FORMAT)
        };
        Self {
            occlusion: factory.pipeline(&PipelineDescriptor::over(
                "occlusion",
                screen,
                &[&seen],
                TextureFormat::R8Unorm,
            )),
            veil: factory.pipeline(&PipelineDescriptor::over("veil", veil, &[&survey], VEIL)),
            coarser_veil: factory.pipeline(&PipelineDescriptor::over("veil_level", veil, &[&seen], VEIL)),
            lines: factory.pipeline(&lines),
            darken,
            seen,
            darkening,
            survey,
            results,
        }
    }
}

/// Makes pipelines and groups of the picture. [`Canvas::new`] tells it the frame.
pub(super) fn factory(gpu: &Gpu) -> PipelineFactory {
    PipelineFactory::new((&gpu.device, &gpu.queue), include_str!("frame.wgsl"), &[0; size_of::<Frame>()])
}

/// Texels of the survey along a pixel's side, for a picture of this size.
pub(super) fn survey_scale([width, height]: [u32; 2], most: u32) -> u32 {
    let is_small = u64::from(width) * u64::from(height) <= MOST_FINE && width.max(height) <= most / 2;
    if is_small { 2 } else { 1 }
}

pub(super) struct Canvas<'a> {
    factory: &'a PipelineFactory,
    frame: &'a Frame,
    /// All that is drawn is within it.
    bounds: &'a Bounds,
    colour: TextureView,
    depth: TextureView,
    survey: TextureView,
    survey_depth: TextureView,
    occlusion: TextureView,
    finished: wgpu::Texture,
}

/// Faces, and a normal and a base colour, if there are any, for each of their corners.
type Drawn<'a> = (&'a [[u32; 3]], &'a [u32], Option<&'a [[u32; 3]]>);

impl<'a> Canvas<'a> {
    pub(super) fn new(factory: &'a PipelineFactory, (frame, bounds): (&'a Frame, &'a Bounds), size: [u32; 2]) -> Self {
        factory.set_frame(bytemuck::bytes_of(frame));
        let target = |label, size, format, samples, usage| view(&factory.target(label, size, format, samples, usage));
        let (unread, read) = (TextureUsages::empty(), TextureUsages::TEXTURE_BINDING);
        let survey_size = size.map(|pixels| frame.survey_scale * pixels);
        Self {
            colour: target("colour", size, FORMAT, SAMPLES, unread),
            depth: target("depth", size, DEPTH, SAMPLES, unread),
            survey: target("survey", survey_size, SURVEY, 1, read),
            survey_depth: target("survey depth", survey_size, DEPTH, 1, unread),
            occlusion: target("occlusion", size, TextureFormat::R8Unorm, 1, read),
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
        let factory = self.factory;
        let corners = 3 * faces.len() as u32;
        let faces = factory.buffer("drawn faces", bytemuck::cast_slice(faces));
        let normals = factory.buffer("normals", bytemuck::cast_slice(normals));
        let colors = factory.buffer("colors", bytemuck::cast_slice(colors.unwrap_or_default()));
        let resources = [positions, &faces, &normals, &colors].map(wgpu::Buffer::as_entire_binding);
        let geometry = factory.group(&pipelines.geometry, &resources);
        let survey = (&self.survey, None);
        let mut pass = color_pass(encoder, "survey", survey, Some(Color::TRANSPARENT), Some(&self.survey_depth));
        factory.draw(&mut pass, &pipelines.survey, &[&geometry], corners);
        drop(pass);
        let sees_ground = self.frame.sees_ground();
        let shadow = sees_ground.then(|| self.contact_shadow(encoder, pipelines, &geometry, corners));

        let mut pass = color_pass(encoder, "model", (&self.colour, None), Some(Color::WHITE), Some(&self.depth));
        factory.draw(&mut pass, &pipelines.backdrop, &[], 3);
        if let Some(group) = &shadow {
            factory.draw(&mut pass, &pipelines.shadow, &[group], 4);
        }
        factory.draw(&mut pass, &pipelines.surface, &[&geometry], corners);
        drop(pass);
        faces
    }

    /// Records the contact map of so many corners, and returns the group that the ground reads it with.
    fn contact_shadow(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pipelines: &ModelPipelines,
        geometry: &BindGroup,
        corners: u32,
    ) -> BindGroup {
        let factory = self.factory;
        let [first, second] = ["contact map", "blurred contact map"]
            .map(|label| view(&factory.target(label, [CONTACT_SIZE; 2], CONTACT, 1, TextureUsages::TEXTURE_BINDING)));
        let black = Some(Color::BLACK);
        let mut pass = color_pass(encoder, "below", (&first, None), black, None);
        factory.draw(&mut pass, &pipelines.below, &[geometry], corners);
        drop(pass);
        let sampler = factory.device.create_sampler(&wgpu::SamplerDescriptor {
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let group = |view, pitch: [f32; 2]| {
            let pitch = factory.uniform("pitch", bytemuck::bytes_of(&pitch));
            let map = BindingResource::TextureView(view);
            factory.group(&pipelines.map, &[map, BindingResource::Sampler(&sampler), pitch.as_entire_binding()])
        };
        // With room for rounding.
        let [width, height] = self.frame.contact_part(self.bounds, SPREAD + 3.0, CONTACT_SIZE);
        for (pitch, across) in [(1.6, true), (1.6, false), (0.7, true), (0.7, false)] {
            let (source, target) = if across { (&first, &second) } else { (&second, &first) };
            let pitch = if across { [pitch, 0.0] } else { [0.0, pitch] };
            let mut pass = color_pass(encoder, "blur", (target, None), black, None);
            pass.set_scissor_rect((CONTACT_SIZE - width) / 2, (CONTACT_SIZE - height) / 2, width, height);
            factory.draw(&mut pass, &pipelines.blur, &[&group(source, pitch)], 3);
        }
        group(&first, [0.0; 2])
    }

    /// Records how little light from all around comes to each pixel, which darkens the model, and the lines over it. The
    /// lists of `extraction` hold the silhouette for the eye, as light 0. Returns the finished picture's texture.
    pub(super) fn lines(
        self,
        encoder: &mut wgpu::CommandEncoder,
        pipelines: &LinePipelines,
        extraction: &Extraction,
        [positions, faces]: [&wgpu::Buffer; 2],
    ) -> Result<wgpu::Texture, GpuError> {
        let factory = self.factory;
        let seen = BindingResource::TextureView(&self.survey);
        let group = factory.group(&pipelines.seen, std::slice::from_ref(&seen));
        let mut pass = color_pass(encoder, "occlusion", (&self.occlusion, None), Some(Color::WHITE), None);
        factory.draw(&mut pass, &pipelines.occlusion, &[&group], 3);
        drop(pass);
        let occlusion = BindingResource::TextureView(&self.occlusion);
        let darkening = factory.group(&pipelines.darkening, &[seen.clone(), occlusion]);
        let results = extraction.bind_group(&pipelines.results, 0)?;
        let survey = [seen, positions.as_entire_binding(), faces.as_entire_binding()];
        let survey = factory.group(&pipelines.survey, &survey);
        let veils = self.veils(encoder, pipelines, &survey);
        let finished = view(&self.finished);
        let mut pass = color_pass(encoder, "lines", (&self.colour, Some(&finished)), None, None);
        factory.draw(&mut pass, &pipelines.darken, &[&darkening], 3);
        factory.bind(&mut pass, &pipelines.lines, &[&survey, &results, &veils]);
        // The draw is indirect: the CPU never learns how many lines the GPU found.
        extraction.draw(&mut pass, 0)?;
        drop(pass);
        Ok(self.finished)
    }

    /// Records the veils of the survey. Returns the group that lines read the veils with.
    fn veils(&self, encoder: &mut wgpu::CommandEncoder, pipelines: &LinePipelines, survey: &BindGroup) -> BindGroup {
        let factory = self.factory;
        let texels = self.survey.texture();
        // Each level has half of the squares of the finer one, and none is left over.
        let size = [texels.width(), texels.height()].map(|texels| texels.div_ceil(SQUARE).next_power_of_two());
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
        let group = |of: &TextureView| factory.group(&pipelines.seen, &[BindingResource::TextureView(of)]);
        let mut draw = |pipeline: &RenderPipeline, target: u32, source: &BindGroup| {
            let mut pass = color_pass(encoder, "veils", (&level(target), None), Some(Color::TRANSPARENT), None);
            factory.draw(&mut pass, pipeline, &[source], 3);
        };
        draw(&pipelines.veil, 0, survey);
        for target in 1..levels {
            draw(&pipelines.coarser_veil, target, &group(&level(target - 1)));
        }
        group(&view(&texture))
    }
}
