//! The stages that rebuild a map's boundary as walls over its contours.

use super::bound::{Bound, ObjectStage};
use super::edges::lattice;
use super::error::DepthMapError;
use super::options::{DepthMapMethod, DepthMapOptions};
use super::pipelines::DepthMapPipelines;
use crate::gpu::common::bindings::{Resource, whole};
use crate::gpu::common::dispatch_limits::{DispatchLimits, WORKGROUP};
use crate::gpu::common::memory::filled;
use crate::gpu::common::pass::{Step, Workgroups};
use crate::gpu::common::pipelines::{Pipeline, Pipelines, switch};
use crate::gpu::common::wanted::Wanted;
use crate::layout::{ContourShape, DepthMapView};
use crate::stages::{CONTOUR_CROSSINGS, CONTOUR_MARKS, CONTOUR_TILES, CONTOUR_WALLS};

/// Cells along the side of a tile, and invocations that trace contours in it.
const TILE: u32 = 16;
const WALKERS: u64 = 64;
/// Samples whose marks one word has.
const WORD_SAMPLES: u32 = 16;
/// Words before the list of walls, and of a wall.
const HEAD_WORDS: u64 = 4;
const WALL_WORDS: u64 = 12;
/// The range of device depths, in units of distances.
const RANGE: f64 = (1_u32 << 29) as f64;
/// A difference above this many thresholds is a jump, even beside large slopes.
const CERTAIN_THRESHOLDS: f64 = 16.0;
/// Bits of a tolerance, less one, after the shift. Tolerances of fewer bits are not shifted.
const TOLERANCE_BITS: u32 = 3;
/// The largest `noise_share` of the stages.
const MAX_NOISE_SHARE: f64 = 4095.0;

/// Stages and buffers for the contours of a map.
#[derive(Debug)]
pub(super) struct Contours {
    mark: ObjectStage,
    /// In order: find tiles, list them, find crossings, count walls, scan the counts, list walls.
    stages: [Pipeline; 6],
    shape: ContourShape,
    pub(super) buffers: ContourBuffers,
}

/// The buffers of contours.
#[derive(Debug)]
pub(super) struct ContourBuffers<B = wgpu::Buffer> {
    marks: B,
    crossings: B,
    counts: B,
    pub(super) walls: B,
    pub(super) draws: B,
    /// Workgroups of the stage that finds crossings, and of those that walk along contours.
    workgroups: B,
}

impl<B> ContourBuffers<B> {
    /// The buffers for maps of `size` texels.
    pub(super) fn plan(size: [u32; 2], shape: &ContourShape, make: &mut impl FnMut(Wanted<'static>) -> B) -> Self {
        let [across, down] = lattice(size, 1).map(u64::from);
        let tiles = u64::from(shape.tiles[1]);
        let walls = HEAD_WORDS + WALL_WORDS * u64::from(shape.capacity);
        Self {
            marks: make(Wanted::new("marks of contours", 4 * u64::from(shape.words) * down)),
            crossings: make(Wanted::new("crossings of contours", 4 * across * down)),
            counts: make(Wanted::new("counts of walls", 4 * (tiles * (2 + WALKERS) + 1))),
            walls: make(Wanted::new("walls", 4 * walls)),
            draws: make(Wanted::new("draws of walls", 32).indirect()),
            workgroups: make(Wanted::new("workgroups of walls", 24).indirect()),
        }
    }
}

/// A distance in units of the range of depths.
fn distance(depth: f64) -> i32 {
    (depth * RANGE).round().clamp(0.0, RANGE) as i32
}

/// The parameters of contours for maps of `size` texels. `None`: the method has no contours. Refuses pipelines of several
/// bits.
pub(super) fn contour_shape(
    pipelines: &DepthMapPipelines,
    size: [u32; 2],
    options: &DepthMapOptions,
) -> Result<Option<ContourShape>, DepthMapError> {
    let DepthMapMethod::Contours { threshold, sideways, depth } = options.method else { return Ok(None) };
    let bits = pipelines.bits().len() as u32;
    if bits > 1 {
        return Err(DepthMapError::OneBit(bits));
    }
    let threshold = f64::from(threshold);
    let limits = DispatchLimits::new(&pipelines.shared.device().limits());
    let tiles = size.map(|texels| (texels + 1).div_ceil(TILE));
    let tile_count = u64::from(tiles[0]) * u64::from(tiles[1]);
    let words = (size[0] + 2).div_ceil(WORD_SAMPLES);
    // A wall for each fourth cell: far more than pictures have.
    let cells = (u64::from(size[0]) + 1) * (u64::from(size[1]) + 1);
    let default = (cells / 4).max(1024);
    let fitting = (limits.binding / 4).saturating_sub(HEAD_WORDS) / WALL_WORDS;
    let capacity = options.capacity.map_or(default, u64::from).min(fitting) as u32;
    let tolerance = distance(f64::from(depth));
    let shift = tolerance.checked_ilog2().unwrap_or(0).saturating_sub(TOLERANCE_BITS);
    Ok(Some(ContourShape {
        tiles: [tiles[0], tile_count as u32],
        words,
        capacity,
        threshold: distance(threshold),
        certain_threshold: distance(threshold * CERTAIN_THRESHOLDS),
        sideways: (f64::from(sideways) * 256.0).round() as i32,
        tolerance: tolerance >> shift,
        shift,
        slope_bias: 0,
        noise_share: 0,
        noise_constant: 0,
    }))
}

impl Contours {
    /// Makes the stages for these buffers.
    pub(super) fn new(
        pipelines: &DepthMapPipelines,
        shape: ContourShape,
        buffers: ContourBuffers,
    ) -> Result<Self, DepthMapError> {
        let shared = &pipelines.shared;
        // Compiles them here, so that no draw waits for the compiler.
        pipelines.walls()?;
        let max_workgroups = shared.device().limits().max_compute_workgroups_per_dimension;
        let limits = [("MAX_WORKGROUPS", f64::from(max_workgroups))];
        let lists = |lists: bool| [("LISTS", switch(lists))];
        let stages = [
            shared.compute(&CONTOUR_TILES, "contour_tiles_find", &[]),
            shared.compute(&CONTOUR_TILES, "contour_tiles_list", &limits),
            shared.compute(&CONTOUR_CROSSINGS, "contour_crossings", &[]),
            shared.compute(&CONTOUR_WALLS, "contour_walls_trace", &lists(false)),
            shared.compute(&CONTOUR_WALLS, "contour_walls_scan", &[]),
            shared.compute(&CONTOUR_WALLS, "contour_walls_trace", &lists(true)),
        ];
        Ok(Self { mark: ObjectStage::new(shared, &CONTOUR_MARKS, "contour_marks", &[]), stages, shape, buffers })
    }

    /// The stages, bound.
    pub(super) fn steps(&self, shared: &Pipelines, bound: &Bound<'_>) -> Vec<Step> {
        let device = shared.device();
        let over = |items: u64| Workgroups::over(device, items.div_ceil(u64::from(WORKGROUP)) as u32);
        // Contours cross few tiles, and on a CPU a workgroup costs more than an iteration of a loop.
        let indirect = |offset: u64| Workgroups::Written(self.buffers.workgroups.clone(), offset);
        let one = || Workgroups::Known([1, 1]);
        let workgroups = [
            over(self.buffers.marks.size() / 4),
            over(u64::from(self.shape.tiles[1])),
            one(),
            indirect(0),
            indirect(12),
            one(),
            indirect(12),
        ];
        let stages = [self.mark.get(shared, bound.has_objects())].into_iter().chain(self.stages.iter().cloned());
        let get = |name: &str| self.get(name).or_else(|| bound.get(name));
        stages
            .zip(workgroups)
            .map(|(stage, workgroups)| stage.pass([stage.dispatch(device, workgroups, get)]))
            .collect()
    }

    fn get(&self, name: &str) -> Option<Resource<'_>> {
        let ContourBuffers { marks, crossings, counts, walls, draws, workgroups } = &self.buffers;
        Some(whole(match name {
            "marks" => marks,
            "crossings" => crossings,
            "counts" => counts,
            "walls" => walls,
            "draws" => draws,
            "workgroups" => workgroups,
            _ => return None,
        }))
    }

    /// The uniform of an encode, with the bias of `view`.
    pub(super) fn uniform(&self, device: &wgpu::Device, view: &DepthMapView) -> wgpu::Buffer {
        let [slope_bias, share, constant, _] = view.bias.map(f64::from);
        let shape = ContourShape {
            slope_bias: (slope_bias * 256.0).round() as i32,
            noise_share: (share * RANGE).round().min(MAX_NOISE_SHARE) as i32,
            noise_constant: (constant * RANGE).ceil().min(RANGE) as i32,
            ..self.shape
        };
        filled(device, "contours", bytemuck::bytes_of(&shape), wgpu::BufferUsages::UNIFORM)
    }

    /// Further bindings of draws: crossings, the uniform, counts and marks.
    pub(super) fn draw_bindings<'a>(&'a self, contour: &'a wgpu::Buffer) -> [Resource<'a>; 4] {
        let ContourBuffers { marks, crossings, counts, .. } = &self.buffers;
        [crossings, contour, counts, marks].map(whole)
    }
}
