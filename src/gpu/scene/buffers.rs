//! The buffers of a scene beside its pages. They are kept while they are large enough.

use super::layout::Group;
use super::options::SceneOptions;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::{Allocation, buffer, check, guarded, padded};
use crate::gpu::extract::buffers::RECORD_HEAD;
use crate::layout::{CHUNK, DrawArguments, FACE_ENTRY, SceneStatistics};
use crate::method::Predicate;

/// Bytes before the entries of lists: a count for each of 32 lights, and as much again, since bindings begin at multiples of
/// 256.
pub(crate) const LISTS_HEAD: u64 = 256;

/// The buffers of a group of casters for a batch of lights.
#[derive(Clone, Debug)]
pub(crate) struct GroupBuffers {
    /// One `u32` a face slot: the lights that the face faces.
    pub(crate) facing: wgpu::Buffer,
    /// One `u32` a face slot: the lights for which the face is excluded.
    pub(crate) excluded: wgpu::Buffer,
    /// A `FacingRecord`: statistics, and the undecided faces.
    pub(crate) record: wgpu::Buffer,
    /// For each light of the batch the number of its silhouette edges, then the lists.
    pub(crate) lists: wgpu::Buffer,
    /// A [`DrawArguments`] for each light of the batch.
    pub(crate) draws: wgpu::Buffer,
}

/// The bytes of each buffer of a group, and what they have room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct GroupSizes {
    pub(crate) masks: u64,
    pub(crate) record: u64,
    pub(crate) lists: u64,
    /// Entries that the list of each light has room for.
    pub(crate) capacity: u32,
}

const DRAWS_LABEL: &str = "draw arguments";
const STATISTICS: u64 = size_of::<SceneStatistics>() as u64;
const DRAWS: u64 = 32 * size_of::<DrawArguments>() as u64;

impl GroupSizes {
    /// The sizes for a batch with `lights` bits.
    pub(crate) fn new(group: &Group, lights: u32, options: &SceneOptions, limits: &DispatchLimits) -> Self {
        let slots = u64::from(group.face_slots());
        let is_exact = options.predicate() == Predicate::Exact;
        let undecided = match options.undecided_capacity {
            _ if !is_exact => 1,
            Some(capacity) => u64::from(capacity.max(1)),
            None => (slots / 4).max(4096),
        };
        let undecided = undecided.min(slots).min((limits.binding - RECORD_HEAD) / 4).max(1);
        let fitting = (limits.binding - LISTS_HEAD) / 4 / u64::from(lights.max(1));
        let capacity = options.list_capacity.map_or_else(|| default_capacity(group, lights), u64::from);
        let capacity = capacity.min(fitting).min(u64::from(group.edge_slots())).max(1);
        Self {
            masks: 4 * slots,
            record: RECORD_HEAD + 4 * undecided,
            lists: LISTS_HEAD + 4 * capacity * u64::from(lights.max(1)),
            capacity: capacity as u32,
        }
    }
}

/// All boundary and inconsistent edges have room. Consistent edges share lists of 16 bytes for each edge in total, and
/// each light has room for the silhouettes of smooth casters.
fn default_capacity(group: &Group, lights: u32) -> u64 {
    let counts = group.counts;
    let shared = 4 * counts.consistent / lights.max(1) as usize;
    let consistent = group.smooth.max(shared).max(1024).min(counts.consistent);
    (counts.boundary + counts.inconsistent + consistent) as u64
}

/// The buffers of all groups and batches, and those that they share.
#[derive(Clone, Debug)]
pub(crate) struct Buffers {
    /// For each group and batch.
    pub(crate) groups: Vec<Vec<GroupBuffers>>,
    /// For each batch and caster the lights that matter.
    pub(crate) lit: wgpu::Buffer,
    /// For each batch and caster those of them whose bits are computed.
    pub(crate) taken: wgpu::Buffer,
    /// The inputs of the bits in the masks: `wgsl/scene/table.wgsl`. It goes with the masks and lists: a new one comes with
    /// new masks and lists.
    pub(crate) kept: wgpu::Buffer,
    /// For each group and batch four words, then the lists of chunks.
    pub(crate) work: wgpu::Buffer,
    /// [`SceneStatistics`].
    pub(crate) statistics: wgpu::Buffer,
}

/// The needs that decide the sizes of buffers.
#[derive(Clone, Copy)]
pub(crate) struct Wanted<'a> {
    /// The sizes of each group and batch.
    pub(crate) groups: &'a [Vec<GroupSizes>],
    /// Words for the lights of casters.
    pub(crate) lit: u64,
    pub(crate) batches: usize,
    /// Face chunks of all groups.
    pub(crate) face_chunks: u64,
    /// Words of work lists.
    pub(crate) work: u64,
    /// Bytes of the rest of the scene.
    pub(crate) others: u64,
    pub(crate) memory_limit: Option<u64>,
}

impl Wanted<'_> {
    /// Words of what is kept.
    fn kept_words(&self) -> u64 {
        let (batches, groups) = (self.batches as u64, self.groups.len() as u64);
        4 + 32 * batches + 2 * self.lit + batches * (32 * groups + CLUSTER_WORDS as u64 * self.face_chunks)
    }
}

/// Makes buffers, or takes old ones that are large enough.
struct Maker<'a> {
    device: &'a wgpu::Device,
    /// Whether old buffers are taken. If not, they only tell what may be needed soon.
    takes_old: bool,
    wanted: Vec<Allocation>,
    /// The largest size that a buffer may take beyond its need, when it replaces one that became too small: a scene that
    /// grows caster by caster does not make its buffers anew in each frame.
    headroom: u64,
}

impl Maker<'_> {
    fn fits(old: &wgpu::Buffer, bytes: u64) -> bool {
        // Give back a buffer that is far too large.
        old.size() >= padded(bytes) && old.size() <= 4 * padded(bytes).max(1 << 16)
    }

    /// The size of the buffer that is kept or made.
    fn size(&self, bytes: u64, old: Option<&wgpu::Buffer>) -> u64 {
        match old {
            Some(old) if Self::fits(old, bytes) => old.size(),
            Some(old) if old.size() < bytes => padded(bytes + bytes / 4).min(self.headroom).max(padded(bytes)),
            _ => padded(bytes),
        }
    }

    fn want(&mut self, label: &'static str, bytes: u64, old: Option<&wgpu::Buffer>) {
        let bytes = self.size(bytes, old);
        self.wanted.push(Allocation { label, bytes });
    }

    fn take(&self, label: &'static str, bytes: u64, old: Option<&wgpu::Buffer>) -> wgpu::Buffer {
        if let Some(old) = old.filter(|old| self.takes_old && Self::fits(old, bytes)) {
            return old.clone();
        }
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        // wgpu makes objects of its own for each indirect buffer.
        let indirect = if label == DRAWS_LABEL { wgpu::BufferUsages::INDIRECT } else { usage };
        buffer(self.device, label, self.size(bytes, old), usage | indirect)
    }
}

impl Buffers {
    /// Makes what is wanted, or takes `old` where it is large enough.
    pub(crate) fn new(
        device: &wgpu::Device,
        old: Option<&Self>,
        wanted: &Wanted<'_>,
        limits: &DispatchLimits,
    ) -> Result<Self, DeviceError> {
        let kept = 4 * wanted.kept_words();
        for (what, bytes) in [("versions of casters", kept), ("lists of chunks", 4 * wanted.work)] {
            if bytes > limits.binding {
                return Err(DeviceError::BindingTooLarge { what, bytes, limit: limits.binding });
            }
        }
        let with_headroom = Self::make(device, old, wanted, limits, limits.binding);
        with_headroom.or_else(|_| Self::make(device, old, wanted, limits, 0))
    }

    fn make(
        device: &wgpu::Device,
        old: Option<&Self>,
        wanted: &Wanted<'_>,
        limits: &DispatchLimits,
        headroom: u64,
    ) -> Result<Self, DeviceError> {
        let Wanted { groups, lit, work, others, memory_limit, .. } = *wanted;
        let kept = 4 * wanted.kept_words();
        let takes_old = old.is_some_and(|old| Maker::fits(&old.kept, kept));
        let mut maker = Maker { device, takes_old, wanted: Vec::new(), headroom };
        let of_group = |group: usize, batch: usize| old?.groups.get(group)?.get(batch);
        for (group, batches) in groups.iter().enumerate() {
            for (batch, sizes) in batches.iter().enumerate() {
                let old = of_group(group, batch);
                maker.want("facing masks", sizes.masks, old.map(|old| &old.facing));
                maker.want("excluded masks", sizes.masks, old.map(|old| &old.excluded));
                maker.want("undecided faces", sizes.record, old.map(|old| &old.record));
                maker.want("edge lists", sizes.lists, old.map(|old| &old.lists));
                maker.want(DRAWS_LABEL, DRAWS, old.map(|old| &old.draws));
            }
        }
        maker.want("lights of casters", 4 * lit, old.map(|old| &old.lit));
        maker.want("taken lights of casters", 4 * lit, old.map(|old| &old.taken));
        maker.want("versions of casters", kept, old.map(|old| &old.kept));
        maker.want("lists of chunks", 4 * work, old.map(|old| &old.work));
        maker.want("scene statistics", STATISTICS, old.map(|old| &old.statistics));
        maker.wanted.push(Allocation { label: "pages and table", bytes: others });
        let own = maker.wanted.len() - 1;
        check(maker.wanted.get(..own).unwrap_or_default(), limits.buffer, None)?;
        let bytes = check(&maker.wanted, u64::MAX, memory_limit)?;
        guarded(device, bytes, || Self {
            groups: groups
                .iter()
                .enumerate()
                .map(|(group, batches)| {
                    let sizes = batches.iter().enumerate();
                    sizes.map(|(batch, sizes)| maker.group(sizes, of_group(group, batch))).collect()
                })
                .collect(),
            lit: maker.take("lights of casters", 4 * lit, old.map(|old| &old.lit)),
            taken: maker.take("taken lights of casters", 4 * lit, old.map(|old| &old.taken)),
            kept: maker.take("versions of casters", kept, old.map(|old| &old.kept)),
            work: maker.take("lists of chunks", 4 * work, old.map(|old| &old.work)),
            statistics: maker.take("scene statistics", STATISTICS, old.map(|old| &old.statistics)),
        })
    }

    /// The size of all buffers in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let of_group = |group: &GroupBuffers| {
            let GroupBuffers { facing, excluded, record, lists, draws } = group;
            [facing, excluded, record, lists, draws].map(wgpu::Buffer::size).iter().sum::<u64>()
        };
        let Self { groups, lit, taken, kept, work, statistics } = self;
        let shared = [lit, taken, kept, work, statistics].map(wgpu::Buffer::size);
        groups.iter().flatten().map(of_group).chain(shared).sum::<u64>()
    }
}

impl Maker<'_> {
    fn group(&self, sizes: &GroupSizes, old: Option<&GroupBuffers>) -> GroupBuffers {
        GroupBuffers {
            facing: self.take("facing masks", sizes.masks, old.map(|old| &old.facing)),
            excluded: self.take("excluded masks", sizes.masks, old.map(|old| &old.excluded)),
            record: self.take("undecided faces", sizes.record, old.map(|old| &old.record)),
            lists: self.take("edge lists", sizes.lists, old.map(|old| &old.lists)),
            draws: self.take(DRAWS_LABEL, DRAWS, old.map(|old| &old.draws)),
        }
    }
}

/// The words of the work lists where a group and batch have their parts: four words, and the two lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WorkPlace {
    pub(crate) count: u64,
    pub(crate) faces: u64,
    pub(crate) edges: u64,
}

/// Words of a group and batch before the lists: the numbers of face chunks and edge chunks, the lights whose lists are made
/// anew, and those of which bits are kept.
pub(crate) const WORK_WORDS: u64 = 4;

/// Words that are kept for each chunk of faces and batch: the lights for which all faces of its cluster have one bit, and
/// these bits.
pub(crate) const CLUSTER_WORDS: usize = 2;

/// The places of all groups and batches, and the number of words. Counts come first, so that they are cleared together.
pub(crate) fn work_places(groups: &[Group], batches: usize) -> (Vec<Vec<WorkPlace>>, u64) {
    let mut next = WORK_WORDS * (groups.len() * batches) as u64;
    let mut count = 0;
    let mut place = |group: &Group| {
        let faces = next;
        let edges = faces + u64::from(FACE_ENTRY * (group.face_slots() / CHUNK));
        next = edges + u64::from(group.edge_slots() / CHUNK);
        count += WORK_WORDS;
        WorkPlace { count: count - WORK_WORDS, faces, edges }
    };
    let places = groups.iter().map(|group| (0..batches).map(|_| place(group)).collect()).collect();
    (places, next)
}
