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
    pub(super) draws: wgpu::Buffer,
    pub(super) statistics: wgpu::Buffer,
}

/// Lists of a light, as `casting.wgsl` has them: cap faces of both classes, and excluded faces.
const LISTS: u64 = 3;
/// The most entries of the list of excluded faces.
const EXCLUDED_CAPACITY: u64 = 1024;

/// Entries of all lists of a light, where lists of cap faces have room for `capacity`.
fn entries(capacity: u64) -> u64 {
    2 * capacity + capacity.min(EXCLUDED_CAPACITY)
}

/// The largest capacity of lists of cap faces with which all lists of a light fit into `entries`.
fn largest_capacity(entries: u64) -> u64 {
    if entries < LISTS * EXCLUDED_CAPACITY { entries / LISTS } else { (entries - EXCLUDED_CAPACITY) / 2 }
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
pub(super) fn fitting_capacity(extraction: &Shape, split: &DispatchLimits, memory_limit: Option<u64>) -> usize {
    let bound = largest_capacity(split.binding / (4 * extraction.batch_lights(0) as u64));
    let others: u64 = per_light(extraction.max_lights).iter().map(|&(_, bytes)| padded(bytes)).sum();
    let left = memory_limit.map_or(u64::MAX, |limit| limit.saturating_sub(others));
    let fitting = bound.min(largest_capacity(left / (4 * extraction.max_lights as u64)));
    usize::try_from(fitting).unwrap_or(usize::MAX)
}

impl Buffers {
    pub(super) fn new(
        source: &extraction::Shared,
        cap_capacity: usize,
        memory_limit: Option<u64>,
    ) -> Result<Self, MemoryError> {
        let (device, split, extraction) = (source.device(), &source.limits, &source.shape);
        let lights = extraction.max_lights as u64;
        let batches = extraction.batches();
        let list_bytes = |batch: usize| 4 * entries(cap_capacity as u64) * extraction.batch_lights(batch) as u64;
        let widest = list_bytes(0);
        if padded(widest) > split.binding {
            let what = "lists of cap faces";
            return Err(MemoryError::Binding { what, bytes: widest, limit: split.binding });
        }
        let wanted: Vec<Allocation> = (0..batches)
            .map(|batch| ("lists of cap faces", list_bytes(batch)))
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
