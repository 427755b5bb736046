//! The buffers of a scene with masks, lists, the cache and work lists. A new layout reuses those that fit.

use super::layout::Group;
use super::options::SceneOptions;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, check, guarded, padded};
use crate::gpu::common::wanted::{Account, Wanted};
use crate::gpu::extract::buffers::{RECORD_HEAD, default_capacity};
use crate::gpu::extract::polygon_buffers::{HEAD_WORDS, PolygonShape};
use crate::layout::{DrawArguments, LightBatch, SceneStatistics};

/// Bytes before the entries of lists: a count for each of 32 lights, the word `CACHED_ZEROS` (`wgsl/common/casters.wgsl`),
/// and padding, because bindings begin at multiples of 256.
pub(crate) const LISTS_HEAD: u64 = 256;

/// The buffers of a group of casters for a batch of lights.
#[derive(Clone, Debug)]
pub(crate) struct GroupBuffers<B = wgpu::Buffer> {
    /// Facing masks, one `u32` a face slot. For polygons, twisted masks follow.
    pub(crate) facing: B,
    /// Excluded masks, one `u32` a face slot.
    pub(crate) excluded: B,
    /// A `FacingRecord`: statistics, and the undecided faces.
    pub(crate) record: B,
    /// For each light of the batch the number of its silhouette edges, then, from [`LISTS_HEAD`] on, the lists.
    pub(crate) lists: B,
    /// A [`DrawArguments`] for each light of the batch.
    pub(crate) draws: B,
    /// For a caster of polygons.
    pub(crate) polygons: Option<PolygonBuffers<B>>,
}

/// The buffers of the polygons of a group for a batch of lights.
#[derive(Clone, Debug)]
pub(crate) struct PolygonBuffers<B = wgpu::Buffer> {
    /// A [`LightBatch`].
    pub(crate) lights: B,
    /// Undecided polygons.
    pub(crate) undecided: B,
    /// The arguments of dispatches over them.
    pub(crate) arguments: B,
    /// Pieces of twisted polygons.
    pub(crate) pieces: B,
}

/// The bytes of the buffers of a group and batch, and the capacities of their lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct GroupSizes {
    pub(crate) masks: u64,
    pub(crate) record: u64,
    pub(crate) lists: u64,
    /// Entries that the list of each light has room for.
    pub(crate) capacity: u32,
    /// For a caster of polygons.
    pub(crate) polygons: Option<PolygonShape>,
    /// Bits of the batch up to the last light.
    pub(crate) lights: u32,
}

impl GroupSizes {
    /// The sizes for a batch with `lights` bits.
    pub(crate) fn new(group: &Group, lights: u32, options: &SceneOptions, limits: &DispatchLimits) -> Self {
        let slots = u64::from(group.face_slots());
        let undecided = match options.capacities.undecided {
            _ if group.polygons.is_some() => 1,
            Some(capacity) => u64::from(capacity.max(1)),
            None => (slots / 4).max(4096),
        };
        let undecided = undecided.min(slots).min((limits.binding - RECORD_HEAD) / 4).max(1);
        let fitting = (limits.binding - LISTS_HEAD) / 4 / u64::from(lights.max(1));
        let capacity = options
            .capacities
            .lists
            .map_or_else(|| default_capacity(group.counts, group.smooth, lights as usize) as u64, u64::from);
        let capacity = capacity.min(fitting).min(u64::from(group.edge_slots())).max(1);
        let pieces = options.capacities.pieces.map(|pieces| pieces.max(1));
        Self {
            masks: 4 * slots,
            record: RECORD_HEAD + 4 * undecided,
            lists: LISTS_HEAD + 4 * capacity * u64::from(lights.max(1)),
            capacity: capacity as u32,
            polygons: group.polygons.map(|counts| PolygonShape::new(&counts, lights as usize, pieces, limits.binding)),
            lights,
        }
    }

    /// Bytes of facing masks. Polygons have twisted masks behind them.
    pub(crate) fn facing(&self) -> u64 {
        if self.polygons.is_some() { 2 * self.masks } else { self.masks }
    }

    /// Bytes of the lists of pieces, 0 without polygons.
    pub(crate) fn pieces(&self) -> u64 {
        self.polygons.map_or(0, |polygons| polygons.piece_bytes(self.lights as usize))
    }
}

/// The buffers of all groups and batches, and the shared ones.
#[derive(Clone, Debug)]
pub(crate) struct Buffers<B = wgpu::Buffer> {
    /// One for each group and batch, batch after batch in each group.
    pub(crate) groups: Vec<GroupBuffers<B>>,
    pub(crate) batches: usize,
    /// The relevant lights of each batch and caster.
    pub(crate) relevant_lights: B,
    /// The active lights of each batch and caster.
    pub(crate) active_lights: B,
    /// The versions that masks and lists were computed from, see `wgsl/scene/table.wgsl`. A new buffer comes with new masks
    /// and lists.
    pub(crate) cache: B,
    /// For each group and batch [`WORK_WORDS`] words, then the lists of chunks, then a state for each deforming caster.
    pub(crate) work: B,
    /// [`SceneStatistics`].
    pub(crate) statistics: B,
    /// The size of all these buffers in bytes.
    pub(crate) bytes: u64,
}

/// The counts that decide the sizes of buffers.
#[derive(Default)]
pub(crate) struct Sizes {
    /// One for each group and batch, batch after batch in each group.
    pub(crate) groups: Vec<GroupSizes>,
    pub(crate) batches: usize,
    /// Pairs of batch and caster.
    pub(crate) pairs: u64,
    /// Words of the cache, and of work lists.
    pub(crate) cache: u64,
    pub(crate) work: u64,
    /// Bytes of the rest of the scene.
    pub(crate) others: u64,
    pub(crate) memory_limit: Option<u64>,
}

/// Whether an old buffer is large enough, and not far too large.
fn fits(old: &wgpu::Buffer, bytes: u64) -> bool {
    old.size() >= padded(bytes) && old.size() <= 4 * padded(bytes).max(1 << 16)
}

impl Buffers {
    /// Makes buffers, or reuses those of `old`.
    pub(crate) fn new(
        device: &wgpu::Device,
        old: Option<&Self>,
        sizes: &Sizes,
        limits: &DispatchLimits,
    ) -> Result<Self, DeviceError> {
        let with_headroom = Self::make(device, old, sizes, limits, limits.binding);
        with_headroom.or_else(|_| Self::make(device, old, sizes, limits, 0))
    }

    /// A buffer that replaces one that became too small gets a quarter more, up to `headroom` bytes. A scene that grows
    /// caster by caster then makes new buffers only now and then.
    fn make(
        device: &wgpu::Device,
        old: Option<&Self>,
        sizes: &Sizes,
        limits: &DispatchLimits,
        headroom: u64,
    ) -> Result<Self, DeviceError> {
        // With a new cache, all buffers are new. The old sizes then still tell how much may be needed soon.
        let reuses = old.is_some_and(|old| fits(&old.cache, 4 * sizes.cache));
        let sized = |wanted: Wanted<'static>, old: Option<&wgpu::Buffer>| {
            let bytes = match old {
                Some(old) if fits(old, wanted.bytes) => old.size(),
                Some(old) if old.size() < wanted.bytes => {
                    padded(wanted.bytes + wanted.bytes / 4).min(headroom).max(padded(wanted.bytes))
                }
                _ => padded(wanted.bytes),
            };
            wanted.sized(bytes)
        };
        let mut account = Account::default();
        Buffers::<()>::plan(old, sizes, |wanted, old| account.note(&sized(wanted, old)));
        account.check_whole(limits.binding)?;
        let bytes = check(&account.all, limits.buffer, None)?;
        account.all.push(Allocation { label: "pages and table", bytes: sizes.others });
        let all = check(&account.all, u64::MAX, sizes.memory_limit)?;
        let take = |wanted: Wanted<'static>, old: Option<&wgpu::Buffer>| match old {
            Some(old) if reuses && fits(old, wanted.bytes) => old.clone(),
            _ => sized(wanted, old).make(device),
        };
        guarded(device, all, || Self { bytes, ..Self::plan(old, sizes, take) })
    }
}

impl<B> Buffers<B> {
    /// Calls `make` for each buffer, with the old one.
    fn plan(
        old: Option<&Buffers>,
        sizes: &Sizes,
        mut make: impl FnMut(Wanted<'static>, Option<&wgpu::Buffer>) -> B,
    ) -> Self {
        let batches = sizes.batches;
        let cache = Wanted::new("versions of casters", 4 * sizes.cache).whole_if(true);
        let cache = make(cache, old.map(|old| &old.cache));
        let work = Wanted::new("lists of chunks", 4 * sizes.work).whole_if(true);
        let work = make(work, old.map(|old| &old.work));
        let draws = Wanted::new("draw arguments", 32 * size_of::<DrawArguments>() as u64).indirect();
        let mut of_part = |sizes: &GroupSizes, old: Option<&GroupBuffers>| GroupBuffers {
            facing: make(Wanted::new("facing masks", sizes.facing()).whole_if(true), old.map(|old| &old.facing)),
            excluded: make(Wanted::new("excluded masks", sizes.masks), old.map(|old| &old.excluded)),
            record: make(Wanted::new("undecided faces", sizes.record), old.map(|old| &old.record)),
            lists: make(Wanted::new("edge lists", sizes.lists), old.map(|old| &old.lists)),
            draws: make(draws, old.map(|old| &old.draws)),
            polygons: sizes.polygons.map(|polygons| {
                let old = old.and_then(|old| old.polygons.as_ref());
                let undecided = Wanted::new("undecided boundaries", polygons.undecided_bytes()).whole_if(true);
                let arguments = Wanted::new("boundary dispatch", 4 * HEAD_WORDS).indirect();
                PolygonBuffers {
                    lights: make(Wanted::uniform("light batch", size_of::<LightBatch>()), old.map(|old| &old.lights)),
                    undecided: make(undecided, old.map(|old| &old.undecided)),
                    arguments: make(arguments, old.map(|old| &old.arguments)),
                    pieces: make(Wanted::new("pieces", sizes.pieces()), old.map(|old| &old.pieces)),
                }
            }),
        };
        let groups = sizes.groups.iter().enumerate().map(|(number, sizes)| {
            let (group, batch) = (number / batches, number % batches);
            let old = old.filter(|old| batch < old.batches);
            of_part(sizes, old.and_then(|old| old.groups.get(group * old.batches + batch)))
        });
        let groups = groups.collect();
        let statistics = size_of::<SceneStatistics>() as u64;
        Self {
            groups,
            batches,
            relevant_lights: make(Wanted::new("relevant lights", 4 * sizes.pairs), old.map(|old| &old.relevant_lights)),
            active_lights: make(Wanted::new("active lights", 4 * sizes.pairs), old.map(|old| &old.active_lights)),
            cache,
            work,
            statistics: make(Wanted::new("scene statistics", statistics), old.map(|old| &old.statistics)),
            bytes: 0,
        }
    }
}

/// Words of a group and batch before the lists: the numbers of listed face chunks and edge chunks, the lights with dirty
/// lists, and the lights with cached bits.
pub(crate) const WORK_WORDS: u64 = 4;

/// Words of the cache for each chunk of faces and batch: the lights for which all faces of its cluster have the same bit,
/// and these bits.
pub(crate) const CLUSTER_WORDS: u32 = 2;
