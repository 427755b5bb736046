//! The volumes of one depth map.

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use super::bound::ObjectStage;
use super::contours::{ContourBuffers, Contours, contour_shape};
use super::edges::{Detector, EdgeStages, threshold_bits};
use super::error::DepthMapError;
use super::options::{DepthMapMethod, DepthMapOptions};
use super::pipelines::DepthMapPipelines;
use super::texture::written_texture;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, check, check_bindings, guarded};
use crate::gpu::common::pipelines::{Pipeline, Pipelines};
use crate::gpu::common::requirements::Subject;
use crate::gpu::common::wanted::Wanted;
use crate::layout::{ContourShape, DepthMapShape};
use crate::shadow::DepthDirection;
use crate::stages::{DEPTH_CELLS, DEPTH_NEAR, DEPTH_NEAR_WALLS};

/// The largest count of cells: entries have 29 bits for the index.
pub(super) const MAX_CELLS: u64 = 1 << 29;

/// Cells of a strip across and down. Each of its rows has a word.
const STRIP: [u64; 2] = [8, 4];
/// Strips of a block.
const BLOCK: u64 = 64;

/// Shadow volumes of casters without a mesh, from the depth map of a light. It finds the edges of the map, and draws the
/// boundary between light and shadow into the stencil bits of [`DepthMapPipelines`]. It reads nothing back. The module has
/// an example.
///
/// docs/numerics/depth-maps.md has the method and its source.
///
/// Shadows are as precise as the map: a border can be off by the shadow of one texel. Outside the map nothing casts.
#[derive(Debug)]
pub struct DepthMapVolumes {
    pub(super) shared: Pipelines,
    /// Decides cells from samples alone, and counts them.
    pub(super) count: Option<ObjectStage>,
    /// Decides cells from marks of edges.
    pub(super) edges: Option<EdgeStages>,
    /// Scan the counts of cells, and list cells. Empty with contours.
    pub(super) stages: Vec<Pipeline>,
    pub(super) contours: Option<Contours>,
    /// Decides whether near caps are drawn. `None`: they always are.
    pub(super) near: Option<Pipeline>,
    pub(super) shape: DepthMapShape,
    /// Bytes of all buffers.
    pub(super) bytes: u64,
    pub(super) options: DepthMapOptions,
    pub(super) bits: u32,
    pub(super) eye: (wgpu::TextureFormat, DepthDirection),
    /// Bound instead of a texture of objects that is missing or not used.
    pub(super) no_objects: wgpu::TextureView,
    pub(super) buffers: CellBuffers,
    pub(super) encodes: Arc<AtomicU64>,
}

/// The buffers of cells. With contours they have the smallest size and nothing binds them.
#[derive(Debug)]
pub(super) struct CellBuffers<B = wgpu::Buffer> {
    pub(super) words: B,
    pub(super) cells: B,
    pub(super) draws: B,
}

/// All buffers of volumes.
struct Buffers<B> {
    cells: CellBuffers<B>,
    edges: Option<[B; 4]>,
    contours: Option<ContourBuffers<B>>,
}

impl<B> Buffers<B> {
    fn plan(plan: &Plan, make: &mut impl FnMut(Wanted<'static>) -> B) -> Self {
        let Plan { shape, detector, contours } = plan;
        let (listed, blocks) = if contours.is_some() { (0, 0) } else { (shape.capacity, shape.blocks) };
        let words = (u64::from(blocks) * (1 + BLOCK * (1 + STRIP[1]))).max(1);
        Self {
            cells: CellBuffers {
                words: make(Wanted::new("words of depth cells", 4 * words)),
                cells: make(Wanted::new("depth cells", 4 + 4 * u64::from(listed))),
                draws: make(Wanted::new("draws of depth cells", 16).indirect()),
            },
            edges: detector.as_ref().map(|detector| detector.buffers(make)),
            contours: contours.as_ref().map(|contours| ContourBuffers::plan(shape.size, contours, make)),
        }
    }
}

/// The maps of volumes: one, or the six of a cube.
pub(super) struct Maps<'a> {
    pub(super) size: [u32; 2],
    pub(super) faces: u32,
    /// Textures that the caller allocates beside the buffers.
    pub(super) textures: &'a [Allocation],
}

impl Maps<'_> {
    /// Cells of a map across and down. A single map has further cells around it, between its outermost samples and a border
    /// of far samples. Maps of a cube have no border.
    fn cells_along(&self) -> [u64; 2] {
        self.size.map(|side| if self.faces > 1 { u64::from(side).saturating_sub(1) } else { u64::from(side) + 1 })
    }

    /// The number of cells of all maps. Refuses sizes with no texels or too many cells.
    fn cells(&self) -> Result<u32, DepthMapError> {
        let count = self.cells_along().into_iter().fold(u64::from(self.faces), u64::saturating_mul);
        if self.size.contains(&0) || count > MAX_CELLS {
            return Err(DepthMapError::Size(self.size[0], self.size[1]));
        }
        Ok(count as u32)
    }

    /// The number of blocks of cells of all maps.
    fn blocks(&self) -> u32 {
        let [across, down] = self.cells_along();
        let strips = across.div_ceil(STRIP[0]) * down.div_ceil(STRIP[1]) * u64::from(self.faces);
        strips.div_ceil(BLOCK) as u32
    }
}

/// The parameters that all buffers and stages follow from.
struct Plan {
    shape: DepthMapShape,
    detector: Option<Detector>,
    contours: Option<ContourShape>,
}

impl Plan {
    fn new(
        pipelines: &DepthMapPipelines,
        maps: &Maps<'_>,
        options: &DepthMapOptions,
        limits: &DispatchLimits,
    ) -> Result<Self, DepthMapError> {
        let cells = maps.cells()?;
        options.check()?;
        let contours = contour_shape(pipelines, maps.size, options)?;
        let bits = pipelines.bits().len() as u32;
        let detector = Detector::new(options.method, bits, maps.faces, maps.size);
        // `None`: every edge is marked where `depth_cells_count` decides, and where draws decide because the list overflowed.
        let threshold = match options.method {
            DepthMapMethod::Differences { threshold, .. } | DepthMapMethod::Contours { threshold, .. } => {
                Some(threshold).filter(|_| detector.is_none())
            }
            _ => None,
        };
        let fitting = (limits.binding / 4 - 1).min(u64::from(u32::MAX)) as u32;
        let cell_capacity = options.capacity.unwrap_or(cells).min(cells).min(fitting);
        let shape = DepthMapShape {
            size: maps.size,
            cells,
            blocks: maps.blocks(),
            capacity: contours.as_ref().map_or(cell_capacity, |contours| contours.capacity),
            every_cell: u32::from(threshold.is_none()),
            threshold: threshold_bits(threshold.unwrap_or(0.0)),
            is_reversed: 0,
            faces: maps.faces,
            has_objects: 0,
            spread: u32::from(bits > 1),
            unused: 0,
        };
        Ok(Self { shape, detector, contours })
    }

    /// Bytes of all buffers. Refuses buffers above the limits of the device, and buffers and textures that together exceed
    /// `memory_limit`.
    fn checked_bytes(
        &self,
        limits: &DispatchLimits,
        textures: &[Allocation],
        memory_limit: Option<u64>,
    ) -> Result<u64, DepthMapError> {
        let mut allocations = Vec::new();
        Buffers::plan(self, &mut |Wanted { label, bytes, .. }| allocations.push(Allocation { label, bytes }));
        check_bindings(&allocations, limits.binding)?;
        let bytes = check(&allocations, limits.buffer, None)?;
        // Textures have limits of their own.
        check(&[&allocations[..], textures].concat(), u64::MAX, memory_limit)?;
        Ok(bytes)
    }
}

impl DepthMapVolumes {
    /// Makes buffers for maps of `size` texels, on the device of `pipelines`. Frames can be drawn by `pipelines`, or by
    /// others of the same device, depth format, direction of depth and number of bits.
    ///
    /// # Errors
    /// [`DepthMapError`] if the size or an option is refused, or the buffers do not fit the device.
    pub fn new(pipelines: &DepthMapPipelines, size: [u32; 2], options: DepthMapOptions) -> Result<Self, DepthMapError> {
        let maps = Maps { size, faces: 1, textures: &[] };
        pipelines.shared.construct(Subject::DepthMap, || Self::with(pipelines, &maps, options))
    }

    /// Makes buffers for one map, or for the six of a cube.
    pub(super) fn with(
        pipelines: &DepthMapPipelines,
        maps: &Maps<'_>,
        options: DepthMapOptions,
    ) -> Result<Self, DepthMapError> {
        let shared = &pipelines.shared;
        let device = shared.device();
        let limits = DispatchLimits::new(&device.limits());
        let plan = Plan::new(pipelines, maps, &options, &limits)?;
        let bytes = plan.checked_bytes(&limits, maps.textures, options.memory_limit)?;
        let Buffers { cells: buffers, edges: edge_buffers, contours: contour_buffers } =
            guarded(device, bytes, || Buffers::plan(&plan, &mut |wanted| wanted.make(device)))?;
        let Plan { shape, detector, contours } = plan;
        let contours = contours.zip(contour_buffers);
        let contours = contours.map(|(shape, buffers)| Contours::new(pipelines, shape, buffers)).transpose()?;
        let near = if contours.is_some() { &DEPTH_NEAR_WALLS } else { &DEPTH_NEAR };
        let edges = detector.zip(edge_buffers).map(|(detector, buffers)| EdgeStages::new(shared, detector, buffers));
        let spreads = [("SPREADS", f64::from(shape.spread))];
        let counts_cells = edges.is_none() && contours.is_none();
        let cell_stages = ["depth_cells_scan", "depth_cells_list"].into_iter().filter(|_| contours.is_none());
        Ok(Self {
            count: counts_cells.then(|| ObjectStage::new(shared, &DEPTH_CELLS, "depth_cells_count", &spreads)),
            edges,
            stages: cell_stages.map(|name| shared.compute(&DEPTH_CELLS, name, &[])).collect(),
            near: options.skip_near_caps.then(|| shared.compute(near, near.name, &[])),
            contours,
            shape,
            bytes,
            options,
            bits: pipelines.bits().len() as u32,
            eye: (pipelines.format().depth_stencil, pipelines.format().depth),
            no_objects: written_texture(device, "no objects", [1, 1], wgpu::TextureFormat::R32Uint)?,
            buffers,
            encodes: Arc::default(),
            shared: shared.clone(),
        })
    }

    /// Whether the method marks edges between objects.
    pub(super) fn uses_objects(&self) -> bool {
        self.options.method != DepthMapMethod::EveryCell
    }

    /// Cells, or walls and flaps, that the list has room for. If [`Self::cells`] begins with a larger count, every cell is
    /// drawn.
    pub fn capacity(&self) -> u32 {
        self.shape.capacity
    }

    /// The listed cells, on the GPU: their count, then an entry for each. They are in order of strips of eight cells across
    /// and four down, then of rows, then of columns. The lower 29 bits of an entry are the index of the cell. Bit 29 is set
    /// if the cell is split from its sample (1, 0) to (0, 1), and bits 30 and 31 if its first and its second triangle are
    /// drawn. If the count exceeds [`Self::capacity`], the list is incomplete, and every cell is drawn.
    ///
    /// With [`DepthMapMethod::Contours`] it lists walls and flaps: their count, three words of 0, then twelve words for
    /// each. These are four vertices of three words: x and y on the lattice, in 1/256 texel, and a distance. Sample (1, 1)
    /// of the lattice is texel (0, 0). A distance is the difference of device depth from the near plane, in units of 2⁻²⁹.
    /// It is 2³¹ − 1 where a wall goes on to infinity.
    pub fn cells(&self) -> &wgpu::Buffer {
        self.contours.as_ref().map_or(&self.buffers.cells, |contours| &contours.buffers.walls)
    }
}
