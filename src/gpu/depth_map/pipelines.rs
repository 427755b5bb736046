//! Render pipelines that turn a bit of the stencil round at each triangle of the boundary.

use std::ops::Range;
use std::sync::OnceLock;

use wgpu::{CompareFunction, StencilOperation};

use super::error::DepthMapError;
use crate::gpu::common::bindings::{FLOAT_TEXTURE, UINT_TEXTURE};
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::memory::any_error;
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::requirements::{Subject, check_sample_shading};
use crate::gpu::shadow::ShadowFormat;
use crate::gpu::shadow::errors::ShadowError;
use crate::gpu::shadow::format::Casters;
use crate::gpu::shadow::pipelines::{check, check_count_bits};
use crate::shadow::DepthDirection;
use crate::stages::{DEPTH_SURFACE, DEPTH_WALLS, Stage};

/// The pipelines that draw volumes from depth maps, for one [`ShadowFormat`] and one bit of the stencil, or some.
#[derive(Debug)]
pub struct DepthMapPipelines {
    shared: Pipelines,
    format: ShadowFormat,
    bits: Range<u32>,
    /// For each bit.
    pub(super) draws: Vec<BitPipelines>,
    /// Made with the first volumes that have walls, or for the first draw of others' volumes.
    walls: OnceLock<WallPipelines>,
}

/// The pipelines of a bit.
#[derive(Debug)]
pub(super) struct BitPipelines {
    pub(super) surface: wgpu::RenderPipeline,
    pub(super) near_cap: wgpu::RenderPipeline,
}

/// The pipelines of walls, in the first bit.
#[derive(Debug)]
pub(super) struct WallPipelines {
    pub(super) walls: wgpu::RenderPipeline,
    /// Draws every cell where the list of walls overflowed.
    pub(super) surface: wgpu::RenderPipeline,
    pub(super) near_cap: wgpu::RenderPipeline,
}

impl DepthMapPipelines {
    /// Makes the pipelines. They count by parity in bit `bit` of the stencil, and leave the other bits as they are. A draw
    /// turns the bit round at each pixel that is in shadow.
    ///
    /// This is for maps alone. **Where volumes of meshes count in the same stencil, take [`Self::beside_meshes`].** A
    /// format with all 8 [`ShadowFormat::count_bits`], the default, is taken here to have no counts beside, so that any bit will
    /// do. With fewer, a bit that they own is refused.
    ///
    /// `format.front_face` and `format.has_far_plane` do not matter. With several samples a pixel, the adapter must have
    /// [`wgpu::DownlevelFlags::MULTISAMPLED_SHADING`], because the near rectangle is looked up at each sample.
    ///
    /// # Errors
    /// [`DepthMapError`] if the device lacks what they need or cannot draw into the attachments, or there is no
    /// such bit.
    pub fn new(pipelines: impl Into<Pipelines>, format: &ShadowFormat, bit: u32) -> Result<Self, DepthMapError> {
        Self::antialiased(pipelines, format, bit..bit.saturating_add(1))
    }

    /// Makes pipelines that count by parity in each of `bits`, as [`Self::antialiased`] does, beside volumes of meshes that count
    /// in the same stencil. `format` is theirs, whose counts own the bits below: `count_bits` of 7 and bits from 7 to 8, for
    /// example. Neither then changes the bits of the other, and a place is dark where any bit is set.
    ///
    /// # Errors
    /// [`DepthMapError`], as for [`Self::antialiased`], or if counts own one of the bits. They own all 8 by default.
    pub fn beside_meshes(
        pipelines: impl Into<Pipelines>,
        format: &ShadowFormat,
        bits: Range<u32>,
    ) -> Result<Self, DepthMapError> {
        let count_bits = format.count_bits;
        if !bits.is_empty() && bits.end <= 8 && bits.start < count_bits {
            return Err(DepthMapError::Counted { bit: bits.start, count_bits });
        }
        Self::antialiased(pipelines, format, bits)
    }

    /// Makes pipelines that count by parity in each of `bits`. Each bit takes the boundary moved sideways by another part of a
    /// texel, so borders of shadows have as many levels of grey, and one more: [`Self::lit_share`] resolves them. The surface
    /// moves away from the light by up to as much again, and volumes are drawn as often. After section 8.3 of the paper.
    ///
    /// Where volumes of meshes count in the same stencil, take [`Self::beside_meshes`], as for [`Self::new`].
    ///
    /// # Errors
    /// [`DepthMapError`], as for [`Self::new`].
    pub fn antialiased(
        pipelines: impl Into<Pipelines>,
        format: &ShadowFormat,
        bits: Range<u32>,
    ) -> Result<Self, DepthMapError> {
        if bits.is_empty() || bits.end > 8 {
            return Err(DepthMapError::Bits(bits));
        }
        let pipelines = pipelines.into();
        let count_bits = format.count_bits;
        pipelines.clone().construct(Subject::DepthMap, || {
            check(pipelines.device(), format, false)?;
            if format.samples > 1 {
                check_sample_shading(pipelines.device(), Subject::DepthMap)?;
            }
            check_count_bits(count_bits, Casters::One)?;
            if count_bits < 8 && bits.start < count_bits {
                return Err(DepthMapError::Counted { bit: bits.start, count_bits });
            }
            let device = pipelines.device().clone();
            any_error(&device, || Self::with(pipelines, format, bits))
                .map_err(|message| ShadowError::Refused { message }.into())
        })
    }

    fn with(shared: Pipelines, format: &ShadowFormat, bits: Range<u32>) -> Self {
        let layout = layout(&shared);
        let cap = [NEAR_CAP, BEHIND_TRIANGLES];
        let of_bit = |bit| BitPipelines {
            surface: make(&shared, format, turned(bit), &layout, [SURFACE, NOTHING], nearer(format)),
            near_cap: make(&shared, format, turned(bit), &layout, cap, CompareFunction::Always),
        };
        let draws = bits.clone().map(of_bit).collect();
        Self { shared, format: format.clone(), bits, draws, walls: OnceLock::new() }
    }

    /// The pipelines of walls.
    pub(super) fn walls(&self) -> Result<&WallPipelines, DeviceError> {
        if let Some(made) = self.walls.get() {
            return Ok(made);
        }
        let made = any_error(self.shared.device(), || {
            let layout = wall_layout(&self.shared);
            let compare = nearer(&self.format);
            let make = |entry_points, compare| {
                make(&self.shared, &self.format, turned(self.bits.start), &layout, entry_points, compare)
            };
            WallPipelines {
                walls: make([WALLS, NOTHING], compare),
                surface: make([SURFACE, NOTHING], compare),
                near_cap: make([NEAR_CAP, BEHIND_CONTOURS], CompareFunction::Always),
            }
        });
        let made = made.map_err(|message| DeviceError::Refused { message })?;
        Ok(self.walls.get_or_init(|| made))
    }

    pub(super) fn shared(&self) -> &Pipelines {
        &self.shared
    }

    /// The bits of the stencil that the pipelines draw into.
    pub fn bits(&self) -> Range<u32> {
        self.bits.clone()
    }

    /// The share of the bits that say light, from 0 to 1, in the stencil of a pixel. A test of the stencil tells
    /// no shares, so light is to be added by a later pass that reads the stencil as a texture. In WGSL, of a texture of
    /// the stencil aspect and with `mask` for the bits: `1.0 - f32(countOneBits(textureLoad(stencil, pixel, 0).x & mask)) /
    /// f32(countOneBits(mask))`.
    pub fn lit_share(&self, stencil: u8) -> f32 {
        let dark = self.bits().filter(|bit| stencil >> bit & 1 == 1).count();
        1.0 - dark as f32 / self.bits.len() as f32
    }

    /// The attachments that the pipelines draw into.
    pub fn format(&self) -> &ShadowFormat {
        &self.format
    }
}

/// An entry point and its module.
type EntryPoint = (&'static Stage, &'static str);

const SURFACE: EntryPoint = (&DEPTH_SURFACE, "depth_surface");
const WALLS: EntryPoint = (&DEPTH_WALLS, "depth_walls");
const NOTHING: EntryPoint = (&DEPTH_SURFACE, "nothing");
const NEAR_CAP: EntryPoint = (&DEPTH_SURFACE, "depth_near_cap");
const BEHIND_TRIANGLES: EntryPoint = (&DEPTH_SURFACE, "depth_near_cap_fragment");
const BEHIND_CONTOURS: EntryPoint = (&DEPTH_WALLS, "depth_walls_near_cap_fragment");

/// The depth comparison that nearer fragments pass.
fn nearer(format: &ShadowFormat) -> CompareFunction {
    match format.depth {
        DepthDirection::Reversed => CompareFunction::Greater,
        DepthDirection::Standard => CompareFunction::Less,
    }
}

const fn uniform_or_storage(ty: wgpu::BufferBindingType) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

const UNIFORM: wgpu::BindingType = uniform_or_storage(wgpu::BufferBindingType::Uniform);
const STORAGE: wgpu::BindingType = uniform_or_storage(wgpu::BufferBindingType::Storage { read_only: true });
/// Map, texture, cells, view, objects.
const SURFACE_BINDINGS: [(u32, wgpu::BindingType); 5] =
    [(0, UNIFORM), (1, FLOAT_TEXTURE), (2, STORAGE), (3, STORAGE), (4, UINT_TEXTURE)];
/// Places, contours, counts, marks.
const WALL_BINDINGS: [(u32, wgpu::BindingType); 4] = [(5, STORAGE), (6, UNIFORM), (7, STORAGE), (9, STORAGE)];

fn entry((binding, ty): (u32, wgpu::BindingType)) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::VERTEX_FRAGMENT, ty, count: None }
}

fn face(pass_op: StencilOperation) -> wgpu::StencilFaceState {
    wgpu::StencilFaceState { pass_op, ..wgpu::StencilFaceState::IGNORE }
}

/// Turns a bit round.
fn turned(bit: u32) -> wgpu::StencilState {
    let face = face(StencilOperation::Invert);
    wgpu::StencilState { front: face, back: face, read_mask: 0xff, write_mask: 1 << bit }
}

/// The layout of the bind group of the draws.
pub(super) fn layout(pipelines: &Pipelines) -> wgpu::BindGroupLayout {
    pipelines.layout("depth surface", SURFACE_BINDINGS.map(entry).to_vec())
}

/// The layout of the bind group of the draws of walls.
pub(super) fn wall_layout(pipelines: &Pipelines) -> wgpu::BindGroupLayout {
    pipelines.layout("depth walls", SURFACE_BINDINGS.into_iter().chain(WALL_BINDINGS).map(entry).collect())
}

/// The bind group of the draws of walls.
pub(super) fn wall_group(pipelines: &Pipelines, resources: Vec<(u32, wgpu::BindingResource<'_>)>) -> wgpu::BindGroup {
    let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
    let entries: Vec<_> = resources.into_iter().map(entry).collect();
    pipelines.device().create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("depth walls"),
        layout: &wall_layout(pipelines),
        entries: &entries,
    })
}

/// The text of a stage that is drawn with as many samples a pixel. With one it is the middle of the pixel, and the text names no
/// sample: an adapter without `DownlevelFlags::MULTISAMPLED_SHADING` refuses a module that does, whatever the pipeline.
pub(crate) fn drawn_wgsl(stage: &Stage, samples: u32) -> String {
    let wgsl = stage.wgsl();
    if samples > 1 { wgsl } else { wgsl.replace("@interpolate(linear, sample)", "@interpolate(linear)") }
}

fn make(
    shared: &Pipelines,
    format: &ShadowFormat,
    stencil: wgpu::StencilState,
    layout: &wgpu::BindGroupLayout,
    [vertex, fragment]: [EntryPoint; 2],
    depth_compare: CompareFunction,
) -> wgpu::RenderPipeline {
    let device = shared.device();
    let [vertex_module, fragment_module] =
        [vertex, fragment].map(|(stage, _)| shared.module(stage.name, &drawn_wgsl(stage, format.samples)));
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(vertex.1),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    let unchanged = |color: Option<wgpu::TextureFormat>| {
        color.map(|format| wgpu::ColorTargetState { format, blend: None, write_mask: wgpu::ColorWrites::empty() })
    };
    let targets: Vec<_> = format.colors.iter().map(|&color| unchanged(color)).collect();
    let compilation_options = wgpu::PipelineCompilationOptions::default;
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(vertex.1),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &vertex_module,
            entry_point: Some(vertex.1),
            compilation_options: compilation_options(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: format.depth_stencil,
            depth_write_enabled: Some(false),
            depth_compare: Some(depth_compare),
            stencil,
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState { count: format.samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module: &fragment_module,
            entry_point: Some(fragment.1),
            compilation_options: compilation_options(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}
