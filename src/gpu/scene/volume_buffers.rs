//! The buffers of the shadow volumes of a scene.

use wgpu::BufferUsages;

use super::structure::Structure;
use super::table::choice_bytes;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, MemoryError, buffer, check, filled, guarded, padded};
use crate::gpu::shadow::buffers::{BoundBuffers, CAP_COUNTS, SIDE_COUNTS};
use crate::layout::{SeenLight, ShadowDraws, ShadowStatistics};
use crate::shadow::Counting;

use super::options::SceneOptions;

/// The lists of a group for a batch of lights and a view.
#[derive(Debug)]
pub(crate) struct Lists {
    pub(crate) sides: wgpu::Buffer,
    pub(crate) caps: wgpu::Buffer,
}

/// Entries of the lists of each light of a group and batch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room {
    pub(crate) lights: u32,
    pub(crate) sides: u32,
    pub(crate) near: u32,
    pub(crate) far: u32,
}

impl Room {
    /// Room for the sides of all silhouettes, and for caps as the options say.
    pub(crate) fn new(
        structure: &Structure,
        part: usize,
        options: &SceneOptions,
        limits: &DispatchLimits,
    ) -> Option<Self> {
        let part = structure.parts.get(part)?;
        let faces = structure.layout.groups.get(part.group)?.face_slots().max(1);
        let lights = part.lights.max(1);
        let fitting = |head: u64| ((limits.binding - head) / 4 / u64::from(lights)) as u32;
        let is_far = options.counting.may_fail() || options.end_at_range;
        let is_near = matches!(options.counting, Counting::Auto | Counting::ZpPlus);
        let some = faces.min(4096 + 16 * faces.isqrt());
        let asked = |is_there: bool, default: u32| {
            if is_there { options.cap_capacity.unwrap_or(default).clamp(1, faces) } else { 1 }
        };
        let caps = fitting(CAP_COUNTS);
        let near = asked(is_near, some).min(caps / 2).max(1);
        let far = asked(is_far, faces).min(caps - near).max(1);
        Some(Self { lights, sides: part.sizes.capacity.min(fitting(SIDE_COUNTS)), near, far })
    }

    pub(crate) fn side_bytes(self) -> u64 {
        SIDE_COUNTS + 4 * u64::from(self.sides) * u64::from(self.lights)
    }

    pub(crate) fn cap_bytes(self) -> u64 {
        CAP_COUNTS + 4 * (u64::from(self.near) + u64::from(self.far)) * u64::from(self.lights)
    }
}

/// The buffers.
#[derive(Debug)]
pub(crate) struct VolumeBuffers {
    /// For each view and light.
    pub(crate) seen: wgpu::Buffer,
    pub(crate) boxes: wgpu::Buffer,
    pub(crate) choices: wgpu::Buffer,
    /// Statistics that say that lights may lie in planes of faces.
    pub(crate) any_zeros: wgpu::Buffer,
    pub(crate) statistics: wgpu::Buffer,
    /// For each group and batch one for each view.
    pub(crate) lists: Vec<Vec<Lists>>,
    /// For each group, with draws for each view and light.
    pub(crate) draws: Vec<wgpu::Buffer>,
    /// For each view and light, if the caller asks for a bound of counts.
    pub(crate) bound: Option<BoundBuffers>,
}

impl VolumeBuffers {
    /// Buffers for `views` views. `others` are the bytes of the rest of the scene.
    pub(crate) fn new(
        device: &wgpu::Device,
        structure: &Structure,
        rooms: &[Room],
        views: usize,
        others: u64,
        options: &SceneOptions,
        limits: &DispatchLimits,
    ) -> Result<Self, MemoryError> {
        let casters = structure.layout.order.len();
        let lights = 32 * structure.batches;
        let [_, choices] = choice_bytes(casters, structure.batches, views, options.end_at_range);
        let seen = (views * lights * size_of::<SeenLight>()) as u64;
        let boxes = 28 * casters as u64;
        let draws = (views * lights * size_of::<ShadowDraws>()) as u64;
        let mut wanted = vec![("seen lights", seen), ("caster boxes", boxes), ("choices", choices)];
        wanted.extend(structure.layout.groups.iter().map(|_| ("shadow draws", draws)));
        let (rows, count_batches) = ((views * lights) as u64, u64::from(options.count_batches.max(1)));
        wanted.extend(BoundBuffers::wanted(rows, count_batches).into_iter().filter(|_| options.bound_counts));
        for room in rooms {
            for _ in 0..views {
                wanted.extend([("lists of sides", room.side_bytes()), ("lists of cap faces", room.cap_bytes())]);
            }
        }
        if let Some(&(what, bytes)) = wanted.iter().find(|&&(_, bytes)| padded(bytes) > limits.binding) {
            return Err(MemoryError::Binding { what, bytes, limit: limits.binding });
        }
        let allocation = |&(label, bytes): &(&'static str, u64)| Allocation { label, bytes: padded(bytes) };
        let mut allocations: Vec<_> = wanted.iter().map(allocation).collect();
        allocations.push(Allocation { label: "the scene without volumes", bytes: others });
        let bytes = check(&allocations, u64::MAX, options.memory_limit)?;
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        let stored = |label, bytes| buffer(device, label, bytes, storage);
        guarded(device, bytes, || Self {
            seen: stored("seen lights", seen),
            boxes: stored("caster boxes", boxes),
            choices: stored("choices", choices),
            any_zeros: filled(device, "any zeros", bytemuck::cast_slice(&[1_u32; 4]), storage),
            statistics: stored("shadow statistics", size_of::<ShadowStatistics>() as u64),
            lists: rooms
                .iter()
                .map(|room| {
                    let lists = |_| Lists {
                        sides: stored("sides", room.side_bytes()),
                        caps: stored("cap faces", room.cap_bytes()),
                    };
                    (0..views).map(lists).collect()
                })
                .collect(),
            draws: structure
                .layout
                .groups
                .iter()
                .map(|_| buffer(device, "shadow draws", draws, storage | BufferUsages::INDIRECT))
                .collect(),
            bound: options.bound_counts.then(|| BoundBuffers::new(device, rows, count_batches)),
        })
    }

    /// The size of all buffers in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let Self { seen, boxes, choices, any_zeros, statistics, lists, draws, bound } = self;
        let bound = bound.iter().flat_map(|BoundBuffers { pencils, crossings }| [pencils, crossings]);
        let own = [seen, boxes, choices, any_zeros, statistics].into_iter().chain(draws).chain(bound);
        let lists = lists.iter().flatten().flat_map(|Lists { sides, caps }| [sides, caps]);
        own.chain(lists).map(wgpu::Buffer::size).sum()
    }
}
