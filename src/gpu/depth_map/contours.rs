//! The stages that rebuild a map's boundary as walls over its contours.

use super::error::DepthMapError;
use super::options::{DepthMapMethod, DepthMapOptions};
use super::pipelines::DepthMapPipelines;
use super::stage::{BoundStage, ObjectStage, Workgroups};
use crate::gpu::common::dispatch_limits::{DispatchLimits, WORKGROUP};
use crate::gpu::common::memory::{Allocation, buffer, filled, guarded};
use crate::gpu::common::pipelines::{Pipeline, Pipelines};
use crate::gpu::common::uniforms::entry;
use crate::layout::{ContourShape, DepthMapShape, DepthMapView};
use crate::stages::{CONTOUR_MARKS, CONTOUR_PLACES, CONTOUR_TILES, CONTOUR_WALLS};

/// Cells along the side of a tile, and invocations that walk in it.
const TILE: u32 = 16;
const WALKERS: u64 = 64;
/// Samples that a word has marks for.
const WORD_SAMPLES: u32 = 16;
/// Words before the list of walls, and of a wall.
const HEAD_WORDS: u64 = 4;
const WALL_WORDS: u64 = 12;
/// The range of device depths, in the units of distances.
const RANGE: f64 = (1_u32 << 29) as f64;
/// A jump of as many thresholds is one, whatever is behind it.
const SURE: f64 = 16.0;
/// Units that a tolerance has at least, if it has as many: it and distances are moved down by what it has more.
const TOLERANCE_BITS: u32 = 3;
/// The largest share that the stages calculate with.
const MOST_SHARE: f64 = 4095.0;

/// Stages and buffers for the contours of a map.
#[derive(Debug)]
pub(super) struct Contours {
    mark: ObjectStage,
    /// Find tiles, list them, places, count, scan, list.
    stages: [Pipeline; 6],
    pub(super) shape: ContourShape,
    marks: wgpu::Buffer,
    places: wgpu::Buffer,
    counts: wgpu::Buffer,
    /// Workgroups of the stages that go over places, and of those that walk.
    workgroups: wgpu::Buffer,
    pub(super) walls: wgpu::Buffer,
    pub(super) draws: wgpu::Buffer,
}

/// A distance in units of the range of depths.
fn distance(depth: f64) -> i32 {
    (depth * RANGE).round().clamp(0.0, RANGE) as i32
}

/// Parameters and buffer sizes for the contours of maps of a size.
pub(super) struct ContourPlan {
    pub(super) shape: ContourShape,
    pub(super) allocations: [Allocation; 6],
}

impl ContourPlan {
    /// `None`: there are none. Options are refused that contours cannot be traced with.
    pub(super) fn new(
        pipelines: &DepthMapPipelines,
        size: [u32; 2],
        options: &DepthMapOptions,
    ) -> Result<Option<Self>, DepthMapError> {
        let DepthMapMethod::Contours { threshold, sideways, depth } = options.method else { return Ok(None) };
        let bits = pipelines.bits().len() as u32;
        if bits > 1 {
            return Err(DepthMapError::OneBit(bits));
        }
        let threshold = f64::from(threshold);
        let limits = DispatchLimits::new(&pipelines.shared().device().limits());
        let tiles = size.map(|texels| (texels + 1).div_ceil(TILE));
        let all = u64::from(tiles[0]) * u64::from(tiles[1]);
        let lattice = size.map(|texels| u64::from(texels) + 2);
        let words = (size[0] + 2).div_ceil(WORD_SAMPLES);
        // A wall for each fourth cell. Contours of pictures have far fewer.
        let cells = (lattice[0] - 1) * (lattice[1] - 1);
        let default = (cells / 4).max(1024);
        let fitting = (limits.binding / 4).saturating_sub(HEAD_WORDS) / WALL_WORDS;
        let capacity = options.capacity.map_or(default, u64::from).min(fitting) as u32;
        let tolerance = distance(f64::from(depth));
        let shift = tolerance.checked_ilog2().unwrap_or(0).saturating_sub(TOLERANCE_BITS);
        let shape = ContourShape {
            tiles: [tiles[0], all as u32],
            words,
            capacity,
            threshold: distance(threshold),
            sure: distance(threshold * SURE),
            sideways: (f64::from(sideways) * 256.0).round() as i32,
            tolerance: tolerance >> shift,
            shift,
            slope_bias: 0,
            share: 0,
            constant: 0,
        };
        let allocations = [
            Allocation { label: "marks of contours", bytes: 4 * u64::from(words) * lattice[1] },
            Allocation { label: "places of contours", bytes: 4 * lattice[0] * lattice[1] },
            Allocation { label: "counts of walls", bytes: 4 * (all * (2 + WALKERS) + 1) },
            Allocation { label: "walls", bytes: 4 * (HEAD_WORDS + WALL_WORDS * u64::from(capacity)) },
            Allocation { label: "draws of walls", bytes: 32 },
            Allocation { label: "workgroups of walls", bytes: 24 },
        ];
        Ok(Some(Self { shape, allocations }))
    }
}

impl Contours {
    /// Makes what is planned, which is checked before.
    pub(super) fn new(
        pipelines: &DepthMapPipelines,
        ContourPlan { shape, allocations }: ContourPlan,
    ) -> Result<Self, DepthMapError> {
        let shared = pipelines.shared();
        // Here rather than in a draw, which would wait for the compiler.
        pipelines.walls()?;
        let bytes = allocations.iter().map(|allocation| allocation.bytes).sum();
        let storage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let indirect = storage | wgpu::BufferUsages::INDIRECT;
        let usages = [storage, storage, storage, storage, indirect, indirect];
        let [marks, places, counts, walls, draws, workgroups] = guarded(shared.device(), bytes, || {
            [0, 1, 2, 3, 4, 5]
                .map(|at| buffer(shared.device(), allocations[at].label, allocations[at].bytes, usages[at]))
        })?;
        let most = shared.device().limits().max_compute_workgroups_per_dimension;
        let most = [("MOST_WORKGROUPS", f64::from(most))];
        let lists = |lists: bool| [("LISTS", f64::from(u8::from(lists)))];
        let stages = [
            shared.compute(&CONTOUR_TILES, "contour_tiles_find", &[]),
            shared.compute(&CONTOUR_TILES, "contour_tiles_list", &most),
            shared.compute(&CONTOUR_PLACES, "contour_places", &[]),
            shared.compute(&CONTOUR_WALLS, "contour_walls_take", &lists(false)),
            shared.compute(&CONTOUR_WALLS, "contour_walls_places", &[]),
            shared.compute(&CONTOUR_WALLS, "contour_walls_take", &lists(true)),
        ];
        Ok(Self {
            mark: ObjectStage::new(shared, &CONTOUR_MARKS, "contour_marks", &[]),
            stages,
            shape,
            marks,
            places,
            counts,
            workgroups,
            walls,
            draws,
        })
    }

    /// Marks, places and counts.
    #[cfg(feature = "reference")]
    pub(super) fn buffers(&self) -> [&wgpu::Buffer; 3] {
        [&self.marks, &self.places, &self.counts]
    }

    /// The stages with what they are bound to, and their workgroups.
    pub(super) fn bind(
        &self,
        shared: &Pipelines,
        map: &wgpu::Buffer,
        contour: &wgpu::Buffer,
        [texture, objects]: &[wgpu::BindingResource<'_>; 2],
        has_objects: bool,
    ) -> Vec<BoundStage> {
        let device = shared.device();
        let over = |items: u64| Workgroups::over(device, items.div_ceil(u64::from(WORKGROUP)) as u32);
        // Contours cross few of all tiles, and a workgroup costs a CPU more than a turn.
        let written = |at: u64| Workgroups::Written(self.workgroups.clone(), at);
        let alone = || Workgroups::Known([1, 1]);
        let shared_by_all = [
            ("depth_map", entry::<DepthMapShape>(map)),
            ("contour", entry::<ContourShape>(contour)),
            ("depth_texture", texture.clone()),
            ("marks", self.marks.as_entire_binding()),
        ];
        let counts = ("counts", self.counts.as_entire_binding());
        let places = ("places", self.places.as_entire_binding());
        let walls = [
            places.clone(),
            counts.clone(),
            ("walls", self.walls.as_entire_binding()),
            ("draws", self.draws.as_entire_binding()),
        ];
        let listing = [counts.clone(), ("workgroups", self.workgroups.as_entire_binding())];
        let own: [(&[_], Workgroups); 7] = [
            (&[("object_texture", objects.clone())], over(self.marks.size() / 4)),
            (&listing, over(u64::from(self.shape.tiles[1]))),
            (&listing, alone()),
            (&[counts, places], written(0)),
            (&walls, written(12)),
            (&walls, alone()),
            (&walls, written(12)),
        ];
        let stages = std::iter::once(self.mark.get(shared, has_objects)).chain(self.stages.iter().cloned());
        let bound = stages.zip(own).map(|(stage, (own, workgroups))| BoundStage {
            groups: vec![stage.bind(device, &[&shared_by_all, own].concat())],
            stage,
            workgroups,
        });
        bound.collect()
    }

    /// The uniform of an encode whose surfaces move as the view says.
    pub(super) fn uniform(&self, device: &wgpu::Device, view: &DepthMapView) -> wgpu::Buffer {
        let [slope_bias, share, constant, _] = view.bias.map(f64::from);
        let shape = ContourShape {
            slope_bias: (slope_bias * 256.0).round() as i32,
            share: (share * RANGE).round().min(MOST_SHARE) as i32,
            constant: (constant * RANGE).ceil().min(RANGE) as i32,
            ..self.shape
        };
        filled(device, "contours", bytemuck::bytes_of(&shape), wgpu::BufferUsages::UNIFORM)
    }

    /// Bound to draws besides what all draws have: places, the uniform, counts and marks.
    pub(super) fn of_draws<'a>(&'a self, contour: &'a wgpu::Buffer) -> [(u32, wgpu::BindingResource<'a>); 4] {
        [
            (5, self.places.as_entire_binding()),
            (6, contour.as_entire_binding()),
            (7, self.counts.as_entire_binding()),
            (9, self.marks.as_entire_binding()),
        ]
    }
}
