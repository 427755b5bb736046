//! Pipelines of the picture, for a number of samples a pixel.

use rimline::Counting;
use rimline::gpu::{
    OutlineFormat, OutlinePipeline, ShadowFormat, ShadowPipelines, include_wgsl, results_bind_group_layout,
};
use wgpu::{
    BlendComponent, BlendFactor, BlendOperation, BlendState, ColorWrites, CompareFunction, PrimitiveTopology,
    StencilOperation, TextureFormat,
};

use super::error::RenderError;
use super::frame::LampData;
use super::gpu::{Gpu, TEXTURE, UNIFORM, UNIFORM_AT_OFFSET};
use super::models::ModelLayouts;
use crate::state::options::Mode;

/// Linear light, before it is exposed.
pub(super) const LIGHT: TextureFormat = TextureFormat::Rgba16Float;
/// The picture, encoded as sRGB by its shader: egui takes textures so.
pub(super) const PICTURE: TextureFormat = TextureFormat::Rgba8Unorm;

const fn blend(src_factor: BlendFactor, dst_factor: BlendFactor) -> BlendState {
    let color = BlendComponent { src_factor, dst_factor, operation: BlendOperation::Add };
    BlendState { color, alpha: color }
}
const ADD: BlendState = blend(BlendFactor::One, BlendFactor::One);
const MULTIPLY: BlendState = blend(BlendFactor::Dst, BlendFactor::Zero);

/// Surfaces that a pass draws onto.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Onto {
    /// The nearest, which this pass finds.
    Nearest,
    /// The nearest again, where the stencil is still 0. It no longer is afterwards, so faces that coincide add light once.
    Lit,
    /// The nearest again, where the stencil is not 0. It is 0 afterwards.
    Shadowed,
    /// The nearest again, whatever the stencil.
    Again,
}

impl Onto {
    fn state(self, format: TextureFormat) -> wgpu::DepthStencilState {
        let (compare, stencil, pass_op) = match self {
            Self::Nearest => (CompareFunction::Greater, CompareFunction::Always, StencilOperation::Keep),
            Self::Lit => (CompareFunction::Equal, CompareFunction::Equal, StencilOperation::IncrementClamp),
            Self::Shadowed => (CompareFunction::Equal, CompareFunction::NotEqual, StencilOperation::Zero),
            Self::Again => (CompareFunction::Equal, CompareFunction::Always, StencilOperation::Keep),
        };
        let face = wgpu::StencilFaceState { compare: stencil, pass_op, ..wgpu::StencilFaceState::IGNORE };
        depth_state(format, self == Self::Nearest, compare, face)
    }
}

fn depth_state(
    format: TextureFormat,
    write: bool,
    compare: CompareFunction,
    face: wgpu::StencilFaceState,
) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format,
        depth_write_enabled: Some(write),
        depth_compare: Some(compare),
        stencil: wgpu::StencilState { front: face, back: face, read_mask: 0xff, write_mask: 0xff },
        bias: wgpu::DepthBiasState::default(),
    }
}

/// Layouts, uniforms and modules of all pipelines.
pub(super) struct Shared {
    pub(super) models: ModelLayouts,
    frame: wgpu::BindGroupLayout,
    lamps: wgpu::BindGroupLayout,
    pub(super) light: wgpu::BindGroupLayout,
    /// The layout of an extraction's results.
    pub(super) results: wgpu::BindGroupLayout,
    pub(super) frame_buffer: wgpu::Buffer,
    pub(super) frame_group: wgpu::BindGroup,
    pub(super) lamp_buffer: wgpu::Buffer,
    pub(super) lamp_group: wgpu::BindGroup,
}

impl Shared {
    /// With room for so many lights.
    pub(super) fn new(gpu: &Gpu, lamps: usize) -> Self {
        let both = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let frame = gpu.layout(both, &[UNIFORM]);
        let lamp = gpu.layout(both, &[UNIFORM_AT_OFFSET]);
        let frame_buffer = gpu.filled("frame", &[0; size_of::<super::frame::Frame>()], wgpu::BufferUsages::UNIFORM);
        let bytes = vec![0; LampData::STRIDE as usize * lamps];
        let lamp_buffer = gpu.filled("lamps", &bytes, wgpu::BufferUsages::UNIFORM);
        let one = wgpu::BufferBinding { buffer: &lamp_buffer, offset: 0, size: wgpu::BufferSize::new(LampData::BOUND) };
        Self {
            models: ModelLayouts::new(gpu),
            frame_group: gpu.group(&frame, &[frame_buffer.as_entire_binding()]),
            lamp_group: gpu.group(&lamp, &[wgpu::BindingResource::Buffer(one)]),
            frame,
            lamps: lamp,
            light: gpu.layout(wgpu::ShaderStages::FRAGMENT, &[TEXTURE]),
            results: results_bind_group_layout(&gpu.device, wgpu::ShaderStages::VERTEX),
            frame_buffer,
            lamp_buffer,
        }
    }
}

/// A pipeline without what they all have alike.
struct Pass<'a> {
    name: &'static str,
    vertex: &'static str,
    source: &'a str,
    groups: &'a [&'a wgpu::BindGroupLayout],
    topology: PrimitiveTopology,
    format: TextureFormat,
    samples: u32,
    blend: Option<BlendState>,
    write: ColorWrites,
    depth: Option<wgpu::DepthStencilState>,
}

impl Pass<'_> {
    fn pipeline(&self, gpu: &Gpu, shared: &Shared) -> wgpu::RenderPipeline {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(self.name),
            source: wgpu::ShaderSource::Wgsl(format!("{}\n{}", include_str!("scene.wgsl"), self.source).into()),
        });
        let groups: Vec<_> = [&shared.frame].into_iter().chain(self.groups.iter().copied()).map(Some).collect();
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(self.name),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.name),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(&format!("{}_vertex", self.vertex)),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState { topology: self.topology, ..Default::default() },
            depth_stencil: self.depth.clone(),
            multisample: wgpu::MultisampleState { count: self.samples, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(&format!("{}_fragment", self.name)),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(wgpu::ColorTargetState {
                    format: self.format,
                    blend: self.blend,
                    write_mask: self.write,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// Draws models and ground with fragment shaders of one name.
pub(super) struct Receivers {
    pub(super) surface: wgpu::RenderPipeline,
    pub(super) ground: wgpu::RenderPipeline,
}

/// All pipelines for a number of samples.
pub(super) struct Pipelines {
    pub(super) samples: u32,
    pub(super) backdrop: wgpu::RenderPipeline,
    pub(super) tone: wgpu::RenderPipeline,
    pub(super) ambient: Receivers,
    pub(super) lit: Receivers,
    /// Marks what turns its back on the light, then shades what is marked or in shadow.
    pub(super) shade: Option<(Mode, [Receivers; 2])>,
    pub(super) caps: wgpu::RenderPipeline,
    /// Sides of volumes and their lines.
    pub(super) volumes: [wgpu::RenderPipeline; 2],
    pub(super) outlines: OutlinePipeline,
    shadows: Vec<(Counting, ShadowPipelines)>,
}

impl Pipelines {
    pub(super) fn new(gpu: &Gpu, shared: &Shared, samples: u32) -> Result<Self, RenderError> {
        let format = gpu.depth_format();
        let cover = |name, groups: &[&wgpu::BindGroupLayout], to, depth, samples| {
            let (vertex, source, topology) = ("cover", include_str!("picture.wgsl"), PrimitiveTopology::TriangleList);
            let (blend, write) = (None, ColorWrites::ALL);
            Pass { name, vertex, source, groups, topology, format: to, samples, blend, write, depth }
                .pipeline(gpu, shared)
        };
        // Where nothing was drawn, depth is still 0.
        let behind = depth_state(format, false, CompareFunction::Equal, wgpu::StencilFaceState::IGNORE);
        let before = depth_state(format, false, CompareFunction::Greater, wgpu::StencilFaceState::IGNORE);
        let source = format!("{}\n{}", include_wgsl(2), include_str!("volumes.wgsl"));
        let volumes = |name, topology| {
            let pass = Pass {
                name,
                vertex: name,
                source: &source,
                groups: &[&shared.lamps, &shared.results],
                topology,
                format: LIGHT,
                samples,
                blend: Some(BlendState::ALPHA_BLENDING),
                write: ColorWrites::ALL,
                depth: Some(before.clone()),
            };
            pass.pipeline(gpu, shared)
        };
        let receivers = |name, onto, blend, write| receivers(gpu, shared, samples, (name, onto), (blend, write));
        let all = ColorWrites::ALL;
        let over = Some(BlendState::ALPHA_BLENDING);
        let outlines =
            OutlineFormat { color: PICTURE, depth_stencil: None, samples: 1, is_depth_multisampled: samples > 1 };
        Ok(Self {
            samples,
            backdrop: cover("backdrop", &[], LIGHT, Some(behind), samples),
            tone: cover("tone", &[&shared.light], PICTURE, None, 1),
            ambient: receivers("ambient", Onto::Nearest, None, all),
            lit: receivers("lit", Onto::Lit, Some(ADD), all),
            shade: None,
            caps: surface(gpu, shared, samples, ("caps", Onto::Again), (over, all)),
            volumes: [
                volumes("volumes", PrimitiveTopology::TriangleStrip),
                volumes("edges", PrimitiveTopology::LineStrip),
            ],
            outlines: OutlinePipeline::new(&gpu.pipelines, &outlines)?,
            shadows: Vec::new(),
        })
    }

    /// Makes what a counting method and a mode need, unless it is there.
    pub(super) fn prepare(
        &mut self,
        gpu: &Gpu,
        shared: &Shared,
        counting: Counting,
        mode: Mode,
    ) -> Result<(), RenderError> {
        if !self.shadows.iter().any(|(of, _)| *of == counting) {
            let format = ShadowFormat {
                depth_stencil: gpu.depth_format(),
                samples: self.samples,
                colors: vec![Some(LIGHT)],
                ..ShadowFormat::default()
            };
            self.shadows.push((counting, ShadowPipelines::new(&gpu.pipelines, &format, counting)?));
        }
        let shade = match mode {
            Mode::Additive => None,
            Mode::Ambient => Some(("ambient", None)),
            Mode::Black => Some(("black", None)),
            Mode::Composited => Some(("dim", Some(MULTIPLY))),
        };
        if self.shade.as_ref().map(|(mode, _)| *mode) != shade.map(|_| mode) {
            let receivers =
                |name, onto, blend, write| receivers(gpu, shared, self.samples, (name, onto), (blend, write));
            self.shade = shade.map(|(name, blend)| {
                let averted = receivers("averted", Onto::Lit, None, ColorWrites::empty());
                (mode, [averted, receivers(name, Onto::Shadowed, blend, ColorWrites::ALL)])
            });
        }
        Ok(())
    }

    /// The pipelines of volumes that were prepared.
    pub(super) fn shadows(&self, counting: Counting) -> Option<&ShadowPipelines> {
        self.shadows.iter().find(|(of, _)| *of == counting).map(|(_, pipelines)| pipelines)
    }
}

fn surface(
    gpu: &Gpu,
    shared: &Shared,
    samples: u32,
    (name, onto): (&'static str, Onto),
    (blend, write): (Option<BlendState>, ColorWrites),
) -> wgpu::RenderPipeline {
    let depth = Some(onto.state(gpu.depth_format()));
    let (source, topology) = (include_str!("surface.wgsl"), PrimitiveTopology::TriangleList);
    let groups = &[&shared.lamps, &shared.models.draw];
    Pass { name, vertex: "surface", source, groups, topology, format: LIGHT, samples, blend, write, depth }
        .pipeline(gpu, shared)
}

fn receivers(
    gpu: &Gpu,
    shared: &Shared,
    samples: u32,
    (name, onto): (&'static str, Onto),
    (blend, write): (Option<BlendState>, ColorWrites),
) -> Receivers {
    let depth = Some(onto.state(gpu.depth_format()));
    let (source, topology) = (include_str!("ground.wgsl"), PrimitiveTopology::TriangleList);
    let groups = &[&shared.lamps];
    let ground = Pass { name, vertex: "ground", source, groups, topology, format: LIGHT, samples, blend, write, depth };
    Receivers {
        surface: surface(gpu, shared, samples, (name, onto), (blend, write)),
        ground: ground.pipeline(gpu, shared),
    }
}
