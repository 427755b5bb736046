//! Render pipelines that turn a bit of the stencil round at each triangle of the boundary.

use std::ops::Range;
use std::sync::OnceLock;

use wgpu::{CompareFunction, StencilOperation};

use super::error::DepthMapError;
use crate::gpu::common::bindings::{FLOAT_TEXTURE, READ, Resource, UINT_TEXTURE, UNIFORM, entries};
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::drawing::Drawn;
use crate::gpu::common::memory::any_error;
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::requirements::{Subject, check_sample_shading};
use crate::gpu::shadow::ShadowFormat;
use crate::gpu::shadow::errors::ShadowError;
use crate::gpu::shadow::format::Casters;
use crate::gpu::shadow::pipelines::{check, check_count_bits};
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
    walls: OnceLock<(wgpu::RenderPipeline, BitPipelines)>,
}

/// The pipelines of a bit.
#[derive(Debug)]
pub(super) struct BitPipelines {
    /// With walls it draws every cell where their list overflowed.
    pub(super) surface: wgpu::RenderPipeline,
    pub(super) near_cap: wgpu::RenderPipeline,
}

impl BitPipelines {
    fn new(
        shared: &Pipelines,
        format: &ShadowFormat,
        bit: u32,
        layout: &wgpu::BindGroupLayout,
        behind: EntryPoint,
    ) -> Self {
        let make = |entry_points, compare| make(shared, format, turned(bit), layout, entry_points, compare);
        Self {
            surface: make([SURFACE, NOTHING], format.nearer()),
            near_cap: make([NEAR_CAP, behind], CompareFunction::Always),
        }
    }
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
            check_count_bits(count_bits, Casters::Scene)?;
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
        let of_bit = |bit| BitPipelines::new(&shared, format, bit, &layout, BEHIND_TRIANGLES);
        let draws = bits.clone().map(of_bit).collect();
        Self { shared, format: format.clone(), bits, draws, walls: OnceLock::new() }
    }

    /// The pipelines of walls, and what is drawn beside them. They are in the first bit.
    pub(super) fn walls(&self) -> Result<&(wgpu::RenderPipeline, BitPipelines), DeviceError> {
        if let Some(made) = self.walls.get() {
            return Ok(made);
        }
        let Self { shared, format, bits, .. } = self;
        let made = any_error(shared.device(), || {
            let layout = wall_layout(shared);
            let walls = make(shared, format, turned(bits.start), &layout, [WALLS, NOTHING], format.nearer());
            (walls, BitPipelines::new(shared, format, bits.start, &layout, BEHIND_CONTOURS))
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

/// Map, texture, cells, view, objects.
const SURFACE_BINDINGS: [(u32, wgpu::BindingType); 5] =
    [(0, UNIFORM), (1, FLOAT_TEXTURE), (2, READ), (3, READ), (4, UINT_TEXTURE)];
/// Places, contours, counts, marks.
const WALL_BINDINGS: [(u32, wgpu::BindingType); 4] = [(5, READ), (6, UNIFORM), (7, READ), (9, READ)];

/// Turns a bit round.
fn turned(bit: u32) -> wgpu::StencilState {
    let face = wgpu::StencilFaceState { pass_op: StencilOperation::Invert, ..wgpu::StencilFaceState::IGNORE };
    wgpu::StencilState { front: face, back: face, read_mask: 0xff, write_mask: 1 << bit }
}

/// The layout of the bind group of the draws.
pub(super) fn layout(pipelines: &Pipelines) -> wgpu::BindGroupLayout {
    pipelines.layout("depth surface", entries(wgpu::ShaderStages::VERTEX_FRAGMENT, SURFACE_BINDINGS))
}

/// The layout of the bind group of the draws of walls.
pub(super) fn wall_layout(pipelines: &Pipelines) -> wgpu::BindGroupLayout {
    let all = SURFACE_BINDINGS.into_iter().chain(WALL_BINDINGS);
    pipelines.layout("depth walls", entries(wgpu::ShaderStages::VERTEX_FRAGMENT, all))
}

/// The bind group of the draws of walls.
pub(super) fn wall_group(pipelines: &Pipelines, resources: Vec<(u32, Resource<'_>)>) -> wgpu::BindGroup {
    let bound = resources.into_iter().map(|(binding, resource)| (binding, resource.bound));
    let entries: Vec<_> = bound.map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
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
    compare: CompareFunction,
) -> wgpu::RenderPipeline {
    let [vertex_module, fragment_module] =
        [vertex, fragment].map(|(stage, _)| shared.module(stage.name, &drawn_wgsl(stage, format.samples)));
    shared.draws(&Drawn {
        label: vertex.1,
        layouts: &[layout],
        vertex: (&vertex_module, vertex.1),
        fragment: Some((&fragment_module, fragment.1)),
        constants: &[],
        primitive: wgpu::PrimitiveState::default(),
        format: format.depth_stencil,
        writes_depth: false,
        compare,
        stencil,
        samples: format.samples,
        colors: &format.colors,
    })
}
