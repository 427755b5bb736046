//! The buffers of shadow volumes and their sizes.

use wgpu::BufferUsages;

use super::options::ShadowOptions;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, MemoryError, buffer, check, guarded, padded};
use crate::gpu::common::uniforms::UniformTable;
use crate::gpu::extract::buffers::Shape;
use crate::gpu::extract::extraction;
use crate::layout::{SceneCaster, SeenLight, ShadowDraw, ShadowDraws, ShadowShape, ShadowStatistics, StencilPencil};

/// The buffers that the stages and draws share. A `Vec` has one buffer for each batch of lights.
#[derive(Debug)]
pub(super) struct Buffers {
    pub(super) shape: wgpu::Buffer,
    /// A [`ShadowDraw`] for each light.
    pub(super) draw_lights: wgpu::Buffer,
    /// A [`SeenLight`] for each light.
    pub(super) seen: wgpu::Buffer,
    /// The caster, then a copy of `choices`.
    pub(super) table: wgpu::Buffer,
    pub(super) faces: wgpu::Buffer,
    pub(super) boxes: wgpu::Buffer,
    /// Choices, then measures.
    pub(super) choices: wgpu::Buffer,
    pub(super) caps: Vec<wgpu::Buffer>,
    pub(super) sides: Vec<wgpu::Buffer>,
    pub(super) draws: wgpu::Buffer,
    pub(super) statistics: wgpu::Buffer,
    /// Only if the caller asks for a bound of counts.
    pub(super) bound: Option<BoundBuffers>,
}

/// What bounds stencil counts.
#[derive(Debug)]
pub(crate) struct BoundBuffers {
    /// A [`StencilPencil`] for each light.
    pub(crate) pencils: wgpu::Buffer,
    /// The sides that cross its half planes.
    pub(crate) crossings: wgpu::Buffer,
}

impl BoundBuffers {
    /// Words of the row of a pencil.
    const ROW: u64 = 1028;

    /// What is wanted for so many lights, over all views, whose casters are counted in so many batches.
    pub(crate) fn wanted(lights: u64, count_batches: u64) -> [(&'static str, u64); 2] {
        [
            ("stencil pencils", size_of::<StencilPencil>() as u64 * lights),
            ("stencil crossings", 4 * Self::ROW * lights * count_batches),
        ]
    }

    pub(crate) fn new(device: &wgpu::Device, lights: u64, count_batches: u64) -> Self {
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let [pencils, crossings] =
            Self::wanted(lights, count_batches).map(|(label, bytes)| buffer(device, label, bytes, storage));
        Self { pencils, crossings }
    }
}

/// Entries of the lists of each light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Capacities {
    /// Of both lists of sides together.
    pub(super) sides: u32,
    /// Of both lists of near caps together.
    pub(super) near: u32,
    /// Of both lists of other caps together.
    pub(super) far: u32,
}

/// Bytes before the lists of sides of a batch: two counts for each light.
pub(crate) const SIDE_COUNTS: u64 = 4 * 64;
/// Bytes before the lists of cap faces: four counts for each light.
pub(crate) const CAP_COUNTS: u64 = 4 * 128;
/// Bytes of the choices of a caster for a batch of lights.
pub(crate) const CHOICES: u64 = 32;
/// Bytes of its measures for a light.
pub(crate) const MEASURES: u64 = 8;

/// The largest number of entries for which one binding has room, behind `head` bytes of counts.
pub(super) fn fitting(lights: usize, head: u64, split: &DispatchLimits) -> u32 {
    u32::try_from(split.binding.saturating_sub(head) / (4 * lights as u64)).unwrap_or(u32::MAX)
}

fn side_bytes(capacities: Capacities, lights: usize) -> u64 {
    SIDE_COUNTS + 4 * u64::from(capacities.sides) * lights as u64
}

fn cap_bytes(capacities: Capacities, lights: usize) -> u64 {
    CAP_COUNTS + 4 * (u64::from(capacities.near) + u64::from(capacities.far)) * lights as u64
}

fn choice_bytes(shape: &Shape) -> u64 {
    CHOICES * shape.batches() as u64 + MEASURES * shape.max_lights as u64
}

/// The buffers whose size the number of lights determines, and the lists of sides.
fn besides_caps(shape: &Shape, capacities: Capacities) -> Vec<(&'static str, u64)> {
    let lights = shape.max_lights as u64;
    let mut wanted = vec![
        ("seen lights", lights * size_of::<SeenLight>() as u64),
        ("choices", choice_bytes(shape)),
        ("shadow table", size_of::<SceneCaster>() as u64 + choice_bytes(shape)),
        ("shadow draws", lights * size_of::<ShadowDraws>() as u64),
        ("shadow draw lights", lights * UniformTable::stride::<ShadowDraw>() as u64),
    ];
    wanted.extend(
        (0..shape.batches()).map(|batch| ("lists of sides", side_bytes(capacities, shape.batch_lights(batch)))),
    );
    wanted
}

/// The largest number of entries of a light's lists of cap faces for which one binding and the memory limit have room.
pub(super) fn fitting_caps(
    shape: &Shape,
    split: &DispatchLimits,
    capacities: Capacities,
    memory_limit: Option<u64>,
) -> u32 {
    let bound = fitting(shape.batch_lights(0), CAP_COUNTS, split);
    let others: u64 = besides_caps(shape, capacities).iter().map(|&(_, bytes)| padded(bytes)).sum();
    let counts = CAP_COUNTS * shape.batches() as u64;
    let left = memory_limit.map_or(u64::MAX, |limit| limit.saturating_sub(others + counts));
    bound.min(u32::try_from(left / (4 * shape.max_lights as u64)).unwrap_or(u32::MAX))
}

impl Buffers {
    pub(super) fn new(
        source: &extraction::Shared,
        capacities: Capacities,
        options: ShadowOptions,
    ) -> Result<Self, MemoryError> {
        let (device, split, shape) = (source.device(), &source.limits, &source.shape);
        let lights = shape.max_lights as u64;
        let per_batch = |bytes: fn(Capacities, usize) -> u64| {
            (0..shape.batches()).map(move |batch| bytes(capacities, shape.batch_lights(batch)))
        };
        for (what, bytes) in [("lists of cap faces", cap_bytes as fn(_, _) -> _), ("lists of sides", side_bytes)] {
            let widest = bytes(capacities, shape.batch_lights(0));
            if padded(widest) > split.binding {
                return Err(MemoryError::Binding { what, bytes: widest, limit: split.binding });
            }
        }
        let caps = per_batch(cap_bytes).map(|bytes| ("lists of cap faces", bytes));
        let bound = BoundBuffers::wanted(lights, 1).into_iter().filter(|_| options.bound_counts);
        let wanted: Vec<Allocation> = caps
            .chain(besides_caps(shape, capacities))
            .chain(bound)
            .map(|(label, bytes)| Allocation { label, bytes: padded(bytes) })
            .collect();
        let bytes = check(&wanted, split.buffer, options.memory_limit)?;
        let mut draw_lights = UniformTable::default();
        for light in 0..shape.max_lights as u32 {
            draw_lights.push(&ShadowDraw { light, first_light: light / 32 * 32, view: 0, count_batch: 0 });
        }
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let stored = |label, bytes| buffer(device, label, bytes, storage);
        guarded(device, bytes, || Self {
            shape: buffer(
                device,
                "shadow shape",
                size_of::<ShadowShape>() as u64,
                BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            ),
            draw_lights: draw_lights.into_buffer(device, "shadow draw lights"),
            seen: stored("seen lights", lights * size_of::<SeenLight>() as u64),
            table: stored("shadow table", size_of::<SceneCaster>() as u64 + choice_bytes(shape)),
            faces: source.buffers.faces.clone(),
            boxes: stored("caster boxes", 28),
            choices: stored("choices", choice_bytes(shape)),
            caps: per_batch(cap_bytes).map(|bytes| stored("cap faces", bytes)).collect(),
            sides: per_batch(side_bytes).map(|bytes| stored("sides", bytes)).collect(),
            draws: buffer(
                device,
                "shadow draws",
                lights * size_of::<ShadowDraws>() as u64,
                storage | BufferUsages::INDIRECT,
            ),
            statistics: stored("shadow statistics", size_of::<ShadowStatistics>() as u64),
            bound: options.bound_counts.then(|| BoundBuffers::new(device, lights, 1)),
        })
    }
}
