//! Render pipelines that turn a bit of the stencil round at each triangle of the boundary, or count it.

use std::ops::Range;
use std::sync::OnceLock;

use wgpu::{CompareFunction, StencilOperation};

use super::volumes_errors::DepthMapPipelinesError;
use crate::gpu::common::bindings::{FLOAT_TEXTURE, UINT_TEXTURE};
use crate::gpu::common::memory::any_error;
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::requirements::{DeviceError, Subject, check_sample_shading};
use crate::gpu::shadow::format::{Casters, Count};
use crate::gpu::shadow::pipelines::{check, check_count_bits, stencil};
use crate::gpu::shadow::{ShadowFormat, ShadowFormatError};
use crate::shadow::DepthDirection;
use crate::stages::{DEPTH_SURFACE, DEPTH_WALLS, Stage};

/// The pipelines that draw volumes from depth maps, for one [`ShadowFormat`] and one bit of the stencil, or some, or the bits
/// that counts own.
#[derive(Debug)]
pub struct DepthMapPipelines {
    shared: Pipelines,
    format: ShadowFormat,
    bits: Range<u32>,
    /// The bits are a count, and no parities.
    is_counting: bool,
    /// For each bit, or for the count.
    pub(super) draws: Vec<BitPipelines>,
    /// Made with the first volumes that have walls, or for the first draw of others' volumes.
    walls: OnceLock<WallPipelines>,
}

/// The pipelines of a bit, or of a count.
#[derive(Debug)]
pub(super) struct BitPipelines {
    /// Where the surface shows its front to the light, and where it shows its back.
    pub(super) surface: [wgpu::RenderPipeline; 2],
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
    /// This is for maps alone, or beside a scene ([`DepthMapCasters`](crate::gpu::DepthMapCasters)), whose frame refuses a bit
    /// that the scene's counts own. **Where other volumes of meshes count in the same stencil, take [`Self::beside_meshes`].** A
    /// format with all 8 [`ShadowFormat::count_bits`], the default, is taken here to have no counts beside, so that any bit will
    /// do. With fewer, a bit that they own is refused.
    ///
    /// `format.front_face` and `format.has_far_plane` do not matter. With several samples a pixel, the adapter must have
    /// [`wgpu::DownlevelFlags::MULTISAMPLED_SHADING`], because the near rectangle is looked up at each sample.
    ///
    /// # Errors
    /// [`DepthMapPipelinesError`] if the device lacks what they need or cannot draw into the attachments, or there is no
    /// such bit.
    pub fn new(
        pipelines: impl Into<Pipelines>,
        format: &ShadowFormat,
        bit: u32,
    ) -> Result<Self, DepthMapPipelinesError> {
        if bit > 7 {
            return Err(DepthMapPipelinesError::Bit(bit));
        }
        Self::of_bits(pipelines.into(), format, bit..bit + 1, false)
    }

    /// Makes pipelines that count by parity in each of `bits`, as [`Self::antialiased`] does, beside volumes of meshes that count
    /// in the same stencil. `format` is theirs, whose counts own the bits below: `count_bits` of 7 and bits from 7 to 8, for
    /// example. Neither then changes the bits of the other, and a place is dark where any bit is set.
    ///
    /// # Errors
    /// [`DepthMapPipelinesError`], as for [`Self::antialiased`], or if counts own one of the bits. They own all 8 by default.
    pub fn beside_meshes(
        pipelines: impl Into<Pipelines>,
        format: &ShadowFormat,
        bits: Range<u32>,
    ) -> Result<Self, DepthMapPipelinesError> {
        let count_bits = format.count_bits;
        if !bits.is_empty() && bits.end <= 8 && bits.start < count_bits {
            return Err(DepthMapPipelinesError::Counted { bit: bits.start, count_bits });
        }
        Self::antialiased(pipelines, format, bits)
    }

    /// Makes pipelines that count the surface as a volume, in the bits that counts own ([`ShadowFormat::count_bits`]): up where a
    /// ray enters the shadow, down where it leaves it. So a map is one more caster among volumes of meshes, which takes no bit of
    /// its own, and several maps of a light may lie in each other. Each adds up to 1 to a count, which `bound_counts` of meshes does
    /// not know of: counts may wrap where a bound and the maps together exceed what the bits hold.
    ///
    /// Take [`DepthEdges::EveryCell`](crate::gpu::DepthEdges::EveryCell) with it, which is not the default. An edge that a
    /// detector misses turns a parity bit round along rays through the gap, and leaves the shadows of meshes alone. In a count it
    /// takes shadows of meshes away, too: 1 for a mesh and -1 for a shadow that was left and never entered are 0.
    /// Walls ([`DepthMapReconstruction::Contours`](crate::gpu::DepthMapReconstruction::Contours)) are not counted: a draw of them
    /// is refused.
    ///
    /// # Errors
    /// [`DepthMapPipelinesError`] if the device lacks what they need or cannot draw into the attachments.
    pub fn counting(pipelines: impl Into<Pipelines>, format: &ShadowFormat) -> Result<Self, DepthMapPipelinesError> {
        Self::of_bits(pipelines.into(), format, 0..format.count_bits, true)
    }

    /// Makes pipelines that count by parity in each of `bits`, for volumes with as many
    /// [`DepthMapOptions::bits`](crate::gpu::DepthMapOptions::bits). Each bit takes the boundary moved sideways by another part
    /// of a texel, so borders of shadows are grey: [`Self::lit_share`] resolves them.
    ///
    /// Where volumes of meshes count in the same stencil, take [`Self::beside_meshes`], as for [`Self::new`].
    ///
    /// # Errors
    /// [`DepthMapPipelinesError`], as for [`Self::new`].
    pub fn antialiased(
        pipelines: impl Into<Pipelines>,
        format: &ShadowFormat,
        bits: Range<u32>,
    ) -> Result<Self, DepthMapPipelinesError> {
        if bits.is_empty() || bits.end > 8 {
            return Err(DepthMapPipelinesError::Bits(bits));
        }
        Self::of_bits(pipelines.into(), format, bits, false)
    }

    fn of_bits(
        pipelines: Pipelines,
        format: &ShadowFormat,
        bits: Range<u32>,
        is_counting: bool,
    ) -> Result<Self, DepthMapPipelinesError> {
        let count_bits = format.count_bits;
        pipelines.clone().construct(Subject::DepthMap, || {
            check(pipelines.device(), format, false)?;
            if format.samples > 1 {
                check_sample_shading(pipelines.device(), Subject::DepthMap).map_err(ShadowFormatError::from)?;
            }
            check_count_bits(count_bits, Casters::One)?;
            if !is_counting && count_bits < 8 && bits.start < count_bits {
                return Err(DepthMapPipelinesError::Counted { bit: bits.start, count_bits });
            }
            let device = pipelines.device().clone();
            any_error(&device, || Self::with(pipelines, format, bits, is_counting))
                .map_err(|message| ShadowFormatError::Refused { message }.into())
        })
    }

    fn with(shared: Pipelines, format: &ShadowFormat, bits: Range<u32>, is_counting: bool) -> Self {
        let layout = layout(&shared);
        let surface = |stencil| make(&shared, format, stencil, &layout, [SURFACE, NOTHING], nearer(format));
        let cap = [NEAR_CAP, BEHIND_TRIANGLES];
        let near_cap = |stencil| make(&shared, format, stencil, &layout, cap, CompareFunction::Always);
        let draws = if is_counting {
            let mask = format.count_mask();
            let surface = [false, true].map(|turned| surface(stencil(Count::Visible, turned, mask)));
            let up = face(StencilOperation::IncrementWrap);
            let up = wgpu::StencilState { front: up, back: up, read_mask: 0xff, write_mask: mask };
            vec![BitPipelines { surface, near_cap: near_cap(up) }]
        } else {
            let of_bit = |bit| {
                let surface = surface(turned(bit));
                BitPipelines { surface: [surface.clone(), surface], near_cap: near_cap(turned(bit)) }
            };
            bits.clone().map(of_bit).collect()
        };
        Self { shared, format: format.clone(), bits, is_counting, draws, walls: OnceLock::new() }
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

    /// Whether the bits are a count.
    pub(super) fn is_counting(&self) -> bool {
        self.is_counting
    }

    /// The bits of the stencil that the pipelines draw into.
    pub fn bits(&self) -> Range<u32> {
        self.bits.clone()
    }

    /// The share of the bits that say light, from 0 to 1, in the stencil of a pixel; 0 or 1 for a count. A test of the stencil tells
    /// no shares, so light is to be added by a later pass that reads the stencil as a texture. In WGSL, of a texture of
    /// the stencil aspect and with `mask` for the bits: `1.0 - f32(countOneBits(textureLoad(stencil, pixel, 0).x & mask)) /
    /// f32(countOneBits(mask))`.
    pub fn lit_share(&self, stencil: u8) -> f32 {
        let dark = self.bits().filter(|bit| stencil >> bit & 1 == 1).count();
        if self.is_counting {
            return if dark == 0 { 1.0 } else { 0.0 };
        }
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

/// What passes the depth test where it is nearer.
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
