//! Render pipelines that invert a bit of the stencil at each triangle of the boundary.

use std::ops::Range;
use std::sync::OnceLock;

use wgpu::{CompareFunction, StencilOperation};

use super::error::DepthMapError;
use crate::gpu::common::bindings::{READ, UINT_TEXTURE, UNIFORM, entries, float_texture};
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::drawing::{Drawn, depth_stencil, unchanged};
use crate::gpu::common::memory::any_error;
use crate::gpu::common::pipelines::Pipelines;
use crate::gpu::common::requirements::{Subject, check_sample_shading};
use crate::gpu::shadow::ShadowFormat;
use crate::gpu::shadow::errors::ShadowError;
use crate::gpu::shadow::format::Casters;
use crate::gpu::shadow::pipelines::{check, check_count_bits};
use crate::stages::{DEPTH_SURFACE, DEPTH_WALLS, Stage};

/// The pipelines that draw volumes from depth maps, for one [`ShadowFormat`] and one or several bits of the stencil.
#[derive(Debug)]
pub struct DepthMapPipelines {
    pub(super) shared: Pipelines,
    format: ShadowFormat,
    bits: Range<u32>,
    /// One for each bit.
    pub(super) draws: Vec<BitPipelines>,
    /// Made with the first volumes that have walls, or for the first draw of such volumes.
    walls: OnceLock<(wgpu::RenderPipeline, BitPipelines)>,
}

/// The pipelines of a bit.
#[derive(Debug)]
pub(super) struct BitPipelines {
    /// With walls it draws every cell if their list overflowed.
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
        let make = |entry_points, compare| make(shared, format, inverted(bit), layout, entry_points, compare);
        Self {
            surface: make([SURFACE, NOTHING], format.depth.nearer()),
            near_cap: make([NEAR_CAP, behind], CompareFunction::Always),
        }
    }
}

impl DepthMapPipelines {
    /// Makes pipelines that count by parity in bit `bit` of the stencil, and do not change the other bits. A draw inverts
    /// the bit at each pixel that is in shadow.
    ///
    /// It is for maps alone. **Where volumes of meshes count in the same stencil, use [`Self::beside_meshes`].** If `format`
    /// has 8 [`ShadowFormat::count_bits`], the default, nothing else may count in the stencil, and any bit is allowed. With
    /// fewer, bits of counts are refused.
    ///
    /// `format.front_face` and `format.has_far_plane` are ignored. With several samples a pixel, the adapter must have
    /// [`wgpu::DownlevelFlags::MULTISAMPLED_SHADING`], because the near cap reads the map at each sample.
    ///
    /// # Errors
    /// [`DepthMapError`] if the device lacks what they need or cannot draw into the attachments, or there is no
    /// such bit.
    pub fn new(pipelines: impl Into<Pipelines>, format: &ShadowFormat, bit: u32) -> Result<Self, DepthMapError> {
        Self::antialiased(pipelines, format, bit..bit.saturating_add(1))
    }

    /// Makes pipelines like [`Self::antialiased`], for a stencil in which volumes of meshes count, too. `format` is that of
    /// the volumes of meshes, whose counts have the bits below `bits`: for example `count_bits` of 7, and bits from 7 to 8.
    /// A pixel is in shadow if any bit of the stencil is set.
    ///
    /// # Errors
    /// [`DepthMapError`], as for [`Self::antialiased`], or if counts have one of the bits. They have all 8 by default.
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

    /// Makes pipelines that count by parity in each of `bits`. For each bit the boundary is moved sideways by another part
    /// of a texel (section 8.3 of the paper). So borders of shadows have a level of grey more than there are bits. Volumes are
    /// drawn once for each bit, and the slope bias is up to twice as large.
    ///
    /// The share of light at a pixel is the share of bits that are 0. A stencil test cannot tell shares, so add light in a
    /// later pass that reads the stencil as a texture. In WGSL, with a texture of the stencil aspect and `mask` for the bits:
    /// `1.0 - f32(countOneBits(textureLoad(stencil, pixel, 0).x & mask)) / f32(countOneBits(mask))`.
    ///
    /// Where volumes of meshes count in the same stencil, use [`Self::beside_meshes`].
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
        let layout = surface_layout(&shared);
        let pipelines_of_bit = |bit| BitPipelines::new(&shared, format, bit, &layout, BEHIND_TRIANGLES);
        let draws = bits.clone().map(pipelines_of_bit).collect();
        Self { shared, format: format.clone(), bits, draws, walls: OnceLock::new() }
    }

    /// The pipelines of walls, and those drawn beside them, for the first bit.
    pub(super) fn walls(&self) -> Result<&(wgpu::RenderPipeline, BitPipelines), DeviceError> {
        if let Some(made) = self.walls.get() {
            return Ok(made);
        }
        let Self { shared, format, bits, .. } = self;
        let made = any_error(shared.device(), || {
            let layout = wall_layout(shared);
            let walls = make(shared, format, inverted(bits.start), &layout, [WALLS, NOTHING], format.depth.nearer());
            (walls, BitPipelines::new(shared, format, bits.start, &layout, BEHIND_CONTOURS))
        });
        let made = made.map_err(|message| DeviceError::Refused { message })?;
        Ok(self.walls.get_or_init(|| made))
    }

    /// The bits of the stencil that the pipelines draw into.
    pub fn bits(&self) -> Range<u32> {
        self.bits.clone()
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
    [(0, UNIFORM), (1, float_texture(false)), (2, READ), (3, READ), (4, UINT_TEXTURE)];
/// Crossings, contours, counts, marks.
const WALL_BINDINGS: [(u32, wgpu::BindingType); 4] = [(5, READ), (6, UNIFORM), (7, READ), (8, READ)];

/// A stencil state that inverts a bit.
fn inverted(bit: u32) -> wgpu::StencilState {
    let face = wgpu::StencilFaceState { pass_op: StencilOperation::Invert, ..wgpu::StencilFaceState::IGNORE };
    wgpu::StencilState { front: face, back: face, read_mask: 0xff, write_mask: 1 << bit }
}

/// The layout of the bind group of the draws.
pub(super) fn surface_layout(pipelines: &Pipelines) -> wgpu::BindGroupLayout {
    pipelines.layout("depth surface", entries(wgpu::ShaderStages::VERTEX_FRAGMENT, SURFACE_BINDINGS))
}

/// The layout of the bind group of the draws of walls.
pub(super) fn wall_layout(pipelines: &Pipelines) -> wgpu::BindGroupLayout {
    let all = SURFACE_BINDINGS.into_iter().chain(WALL_BINDINGS);
    pipelines.layout("depth walls", entries(wgpu::ShaderStages::VERTEX_FRAGMENT, all))
}

/// The text of a stage for draws with `samples` a pixel. With one sample it does not name samples, because an adapter
/// without `DownlevelFlags::MULTISAMPLED_SHADING` refuses every module that does.
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
        depth_stencil: Some(depth_stencil(format.depth_stencil, false, compare, stencil)),
        samples: format.samples,
        targets: &unchanged(&format.colors),
    })
}
