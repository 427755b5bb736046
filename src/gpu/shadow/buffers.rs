//! The buffers of shadow volumes and their sizes.

use wgpu::BufferUsages;

use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, MemoryError, buffer, check, guarded, padded};
use crate::gpu::common::uniforms::UniformTable;
use crate::gpu::extract::buffers::Shape;
use crate::gpu::extract::extraction;
use crate::layout::{ShadowDraw, ShadowDraws, ShadowLight, ShadowShape, ShadowStatistics, ShadowView};

/// The buffers that the stages and draws share.
#[derive(Debug)]
pub(super) struct Buffers {
    pub(super) shape: wgpu::Buffer,
    pub(super) view: wgpu::Buffer,
    pub(super) draw_lights: wgpu::Buffer,
    pub(super) faces: wgpu::Buffer,
    pub(super) bounds: wgpu::Buffer,
    pub(super) lights: wgpu::Buffer,
    pub(super) cap_dispatches: wgpu::Buffer,
    pub(super) cap_counts: wgpu::Buffer,
    /// One for each batch of lights.
    pub(super) cap_lists: Vec<wgpu::Buffer>,
    /// One for each batch of lights.
    pub(super) sides: Vec<wgpu::Buffer>,
    pub(super) draws: wgpu::Buffer,
    pub(super) statistics: wgpu::Buffer,
}

/// Lists of cap faces of a light.
const LISTS: u64 = 2;
/// Bytes before the lists of sides of a batch: two counts for each light.
pub(super) const SIDE_COUNTS: u64 = 4 * 64;

/// The largest number of entries of a list of sides for which one binding has room, beside the counts.
pub(super) fn fitting_sides(lights: usize, split: &DispatchLimits) -> u64 {
    split.binding.saturating_sub(SIDE_COUNTS) / (4 * lights as u64)
}

/// The buffers besides the lists of cap faces.
fn per_light(lights: usize) -> [(&'static str, u64); 3] {
    let lights = lights as u64;
    [
        ("shadow lights", lights * size_of::<ShadowLight>() as u64),
        ("shadow draws", lights * size_of::<ShadowDraws>() as u64),
        ("shadow draw lights", lights * UniformTable::stride::<ShadowDraw>() as u64),
    ]
}

/// The largest number of entries of a list of cap faces for which one binding and the memory limit have room.
pub(super) fn fitting_capacity(
    extraction: &Shape,
    split: &DispatchLimits,
    side_capacity: u32,
    memory_limit: Option<u64>,
) -> usize {
    let bound = split.binding / (4 * LISTS * extraction.batch_lights(0) as u64);
    let sides = (0..extraction.batches()).map(|batch| side_bytes(extraction, side_capacity, batch));
    let others: u64 = per_light(extraction.max_lights).iter().map(|&(_, bytes)| bytes).chain(sides).map(padded).sum();
    let left = memory_limit.map_or(u64::MAX, |limit| limit.saturating_sub(others));
    let fitting = bound.min(left / (4 * LISTS * extraction.max_lights as u64));
    usize::try_from(fitting).unwrap_or(usize::MAX)
}

/// The lists of sides of a batch, and their counts.
fn side_bytes(extraction: &Shape, side_capacity: u32, batch: usize) -> u64 {
    SIDE_COUNTS + 4 * u64::from(side_capacity) * extraction.batch_lights(batch) as u64
}

impl Buffers {
    pub(super) fn new(
        source: &extraction::Shared,
        cap_capacity: usize,
        side_capacity: u32,
        memory_limit: Option<u64>,
    ) -> Result<Self, MemoryError> {
        let (device, split, extraction) = (source.device(), &source.limits, &source.shape);
        let lights = extraction.max_lights as u64;
        let batches = extraction.batches();
        let list_bytes = |batch: usize| 4 * LISTS * cap_capacity as u64 * extraction.batch_lights(batch) as u64;
        let widest = list_bytes(0);
        if padded(widest) > split.binding {
            let what = "lists of cap faces";
            return Err(MemoryError::Binding { what, bytes: widest, limit: split.binding });
        }
        let wanted: Vec<Allocation> = (0..batches)
            .map(|batch| ("lists of cap faces", list_bytes(batch)))
            .chain((0..batches).map(|batch| ("lists of sides", side_bytes(extraction, side_capacity, batch))))
            .chain(per_light(extraction.max_lights))
            .map(|(label, bytes)| Allocation { label, bytes: padded(bytes) })
            .collect();
        let bytes = check(&wanted, split.buffer, memory_limit)?;
        let mut draw_lights = UniformTable::default();
        for light in 0..extraction.max_lights as u32 {
            draw_lights.push(&ShadowDraw { light, first_light: light / 32 * 32, reserved_0: 0, reserved_1: 0 });
        }
        let uniform = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        guarded(device, bytes, || Self {
            shape: buffer(device, "shadow shape", size_of::<ShadowShape>() as u64, uniform),
            view: buffer(device, "shadow view", size_of::<ShadowView>() as u64, uniform | BufferUsages::STORAGE),
            draw_lights: draw_lights.into_buffer(device, "shadow draw lights"),
            faces: source.buffers.faces.clone(),
            bounds: buffer(device, "caster bounds", 28, storage),
            lights: buffer(device, "shadow lights", lights * size_of::<ShadowLight>() as u64, storage),
            cap_dispatches: buffer(device, "cap dispatches", 12 * batches as u64, storage | BufferUsages::INDIRECT),
            cap_counts: buffer(device, "cap counts", 4 * LISTS * lights, storage),
            cap_lists: (0..batches).map(|batch| buffer(device, "cap faces", list_bytes(batch), storage)).collect(),
            sides: (0..batches)
                .map(|batch| buffer(device, "sides", side_bytes(extraction, side_capacity, batch), storage))
                .collect(),
            draws: buffer(
                device,
                "shadow draws",
                lights * size_of::<ShadowDraws>() as u64,
                storage | BufferUsages::INDIRECT,
            ),
            statistics: buffer(device, "shadow statistics", size_of::<ShadowStatistics>() as u64, storage),
        })
    }
}
