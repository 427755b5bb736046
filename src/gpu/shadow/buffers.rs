//! The buffers of shadow volumes.

use wgpu::BufferUsages;

use super::sizes::{Room, VolumeSizes};
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, buffer, check, filled, guarded, padded};
use crate::gpu::common::uniforms::UniformTable;
use crate::layout::{PieceDraws, SeenLight, ShadowDraw, ShadowDraws, ShadowShape, ShadowStatistics};

/// The lists of a group for a batch of lights and a view.
#[derive(Debug)]
pub(crate) struct Lists {
    pub(crate) sides: wgpu::Buffer,
    pub(crate) caps: wgpu::Buffer,
    /// Bytes of the counts that each begins with.
    counts: [u64; 2],
}

/// The buffers that bound stencil counts.
#[derive(Debug)]
pub(crate) struct BoundBuffers {
    /// A [`StencilPencil`](crate::layout::StencilPencil) for each view and light.
    pub(crate) pencils: wgpu::Buffer,
    /// The sides that cross its half planes, for each batch of casters.
    pub(crate) crossings: wgpu::Buffer,
}

/// Statistics that say that lights may lie in planes of faces, and that no polygon is twisted.
const ANY_ZEROS: [u32; 5] = [1, 1, 1, 1, 0];

/// The buffers that stages and draws share.
#[derive(Debug)]
pub(crate) struct VolumeBuffers {
    pub(crate) sizes: VolumeSizes,
    /// Uniforms: a [`ShadowShape`] for each group and batch.
    pub(crate) shapes: wgpu::Buffer,
    /// Uniforms: a [`ShadowDraw`] for each batch of casters, view and light.
    pub(crate) draw_lights: wgpu::Buffer,
    /// A [`SeenLight`] for each view and light.
    pub(crate) seen: wgpu::Buffer,
    pub(crate) boxes: wgpu::Buffer,
    /// Choices, then measures.
    pub(crate) choices: wgpu::Buffer,
    /// The inputs of the lists for views.
    pub(crate) listed: wgpu::Buffer,
    /// For each view what its shadows may fall on.
    pub(crate) receivers: wgpu::Buffer,
    /// Statistics that say that lights may lie in planes of faces.
    pub(crate) any_zeros: wgpu::Buffer,
    pub(crate) statistics: wgpu::Buffer,
    /// For each group and batch one for each view.
    pub(crate) lists: Vec<Vec<Lists>>,
    /// For each group [`ShadowDraws`] for each view and light.
    pub(crate) draws: Vec<wgpu::Buffer>,
    /// [`PieceDraws`] for each light, of a caster with polygons.
    pub(crate) piece_draws: Option<wgpu::Buffer>,
    /// If the caller asks for a bound of counts.
    pub(crate) bound: Option<BoundBuffers>,
}

impl VolumeBuffers {
    /// Makes the buffers. `others` count for the memory limit, too.
    pub(crate) fn new(
        device: &wgpu::Device,
        sizes: VolumeSizes,
        others: &[Allocation],
        limits: &DispatchLimits,
    ) -> Result<Self, DeviceError> {
        let mut wanted = sizes.besides_lists();
        for room in &sizes.rooms {
            wanted.extend((0..sizes.views).flat_map(|_| room.lists()).map(|(label, bytes, _)| (label, bytes)));
        }
        if let Some(&(what, bytes)) = wanted.iter().find(|&&(_, bytes)| padded(bytes) > limits.binding) {
            return Err(DeviceError::BindingTooLarge { what, bytes, limit: limits.binding });
        }
        let allocation = |&(label, bytes): &(&'static str, u64)| Allocation { label, bytes: padded(bytes) };
        let own = wanted.iter().map(allocation);
        let allocations: Vec<_> = own.chain(others.iter().copied()).collect();
        // No buffer is larger than a binding, and the others are there or were checked.
        let bytes = check(&allocations, u64::MAX, sizes.settings.memory_limit)?;
        guarded(device, bytes, || Self::make(device, sizes))
    }

    fn make(device: &wgpu::Device, sizes: VolumeSizes) -> Self {
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let stored = |label, bytes| buffer(device, label, bytes, storage);
        let seen = sizes.seen() as u64;
        let [_, choices] = sizes.choice_bytes();
        let lists = |room: &Room| {
            let [(_, sides, side_counts), (_, caps, cap_counts)] = room.lists();
            let counts = [side_counts, cap_counts];
            let of_view = |_| Lists { sides: stored("sides", sides), caps: stored("cap faces", caps), counts };
            (0..sizes.views).map(of_view).collect()
        };
        let draws = |_| {
            let bytes = seen * size_of::<ShadowDraws>() as u64;
            buffer(device, "shadow draws", bytes, storage | BufferUsages::INDIRECT)
        };
        let [pencils, crossings] = sizes.bound_bytes();
        Self {
            shapes: shapes(&sizes).into_buffer(device, "shadow shapes"),
            draw_lights: draw_lights(&sizes).into_buffer(device, "shadow draw lights"),
            seen: stored("seen lights", seen * size_of::<SeenLight>() as u64),
            boxes: stored("caster boxes", sizes.box_bytes()),
            choices: stored("choices", choices),
            listed: stored("versions of lists", sizes.listed_bytes()),
            receivers: stored("receivers", sizes.receiver_bytes()),
            any_zeros: filled(device, "any zeros", bytemuck::cast_slice(&ANY_ZEROS), storage),
            statistics: stored("shadow statistics", size_of::<ShadowStatistics>() as u64),
            lists: sizes.rooms.iter().map(lists).collect(),
            draws: sizes.groups.iter().map(draws).collect(),
            piece_draws: sizes.settings.has_pieces.then(|| {
                let bytes = seen * size_of::<PieceDraws>() as u64;
                buffer(device, "piece draws", bytes, storage | BufferUsages::INDIRECT)
            }),
            bound: sizes.settings.bound_counts.then(|| BoundBuffers {
                pencils: stored("stencil pencils", pencils),
                crossings: stored("stencil crossings", crossings),
            }),
            sizes,
        }
    }

    /// Clears the statistics, draws, boxes and counts before the first stage. Lists of batches of lights from `batches` on
    /// are not used. The stage `relist` empties the lists of a scene.
    pub(crate) fn clear(&self, encoder: &mut wgpu::CommandEncoder, batches: usize, is_scene: bool) {
        let Self { sizes, boxes, choices, statistics, lists, draws, piece_draws, bound, .. } = self;
        let [choice_bytes, _] = sizes.choice_bytes();
        encoder.clear_buffer(statistics, 0, None);
        for draws in draws {
            encoder.clear_buffer(draws, 0, None);
        }
        if draws.is_empty() {
            return;
        }
        if let Some(piece_draws) = piece_draws {
            encoder.clear_buffer(piece_draws, 0, None);
        }
        encoder.clear_buffer(boxes, 0, None);
        if let Some(bound) = bound {
            encoder.clear_buffer(&bound.crossings, 0, None);
        }
        if is_scene {
            return;
        }
        encoder.clear_buffer(choices, 0, Some(choice_bytes));
        let all = sizes.batches().max(1);
        let used = lists.iter().enumerate().filter(|(part, _)| part % all < batches);
        for Lists { sides, caps, counts } in used.flat_map(|(_, lists)| lists) {
            encoder.clear_buffer(sides, 0, Some(counts[0]));
            encoder.clear_buffer(caps, 0, Some(counts[1]));
        }
    }

    /// The size of all buffers in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let Self {
            sizes: _,
            shapes,
            draw_lights,
            seen,
            boxes,
            choices,
            listed,
            receivers,
            any_zeros,
            statistics,
            lists,
            draws,
            piece_draws,
            bound,
        } = self;
        let bound = bound.iter().flat_map(|BoundBuffers { pencils, crossings }| [pencils, crossings]);
        let own = [shapes, draw_lights, seen, boxes, choices, listed, receivers, any_zeros, statistics];
        let lists = lists.iter().flatten().flat_map(|Lists { sides, caps, .. }| [sides, caps]);
        own.into_iter().chain(draws).chain(piece_draws).chain(bound).chain(lists).map(wgpu::Buffer::size).sum()
    }
}

/// The shapes of all groups and batches.
fn shapes(sizes: &VolumeSizes) -> UniformTable {
    let mut shapes = UniformTable::default();
    for part in 0..sizes.rooms.len() {
        shapes.push::<ShadowShape>(&sizes.shape(part));
    }
    shapes
}

fn draw_lights(sizes: &VolumeSizes) -> UniformTable {
    let mut draws = UniformTable::default();
    for count_batch in 0..sizes.settings.count_batches {
        for view in 0..sizes.views as u32 {
            for light in 0..sizes.lights as u32 {
                draws.push(&ShadowDraw { light, first_light: light / 32 * 32, view, count_batch });
            }
        }
    }
    draws
}
