//! How large shadow volumes are: the room of their lists, and the shape that stages and draws read.

use super::format::Casters;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::memory::padded;
use crate::gpu::common::uniforms::UniformTable;
use crate::layout::{SceneCaster, SeenLight, ShadowDraw, ShadowDraws, ShadowShape, StencilPencil};
use crate::shadow::Counting;

/// Bytes before the lists of sides of a batch: two counts for each light.
const SIDE_COUNTS: u64 = 4 * 64;
/// Bytes before the lists of cap faces: four counts for each light.
const CAP_COUNTS: u64 = 4 * 128;
/// Bytes of the choices of a caster for a batch of lights.
const CHOICES: u64 = 32;
/// Bytes of its measures for a light.
const MEASURES: u64 = 8;
/// Bytes of the row of a pencil for a batch of casters.
const CROSSINGS: u64 = 4 * 1028;
/// Bytes that tell what the lists of a group, batch and view were made from: two words for each light.
const LISTED: u64 = 8 * 32;
/// Bytes of the box of a caster.
const BOX: u64 = 28;
/// Bytes of the uniform of a batch of casters, view and light.
const DRAW_LIGHT: u64 = UniformTable::stride::<ShadowDraw>() as u64;

/// The caller's settings of volumes.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "switches that do not depend on each other")]
pub(crate) struct VolumeSettings {
    pub(crate) counting: Counting,
    /// Averted faces alone cast, where they suffice.
    pub(crate) averted: bool,
    pub(crate) skip_unreached: bool,
    pub(crate) skip_unseen: bool,
    pub(crate) end_at_range: bool,
    /// Views may have receivers, behind which volumes end.
    pub(crate) has_receivers: bool,
    pub(crate) bound_counts: bool,
    /// Lists are kept for views that did not change.
    pub(crate) keeps: bool,
    /// Batches that casters are counted in.
    pub(crate) count_batches: u32,
    /// The low bits of the stencil that counts own.
    pub(crate) count_bits: u32,
    pub(crate) cap_capacity: Option<u32>,
    pub(crate) memory_limit: Option<u64>,
    /// The caster has polygons, of which pieces are drawn.
    pub(crate) has_pieces: bool,
}

impl VolumeSettings {
    /// The largest count that does not wrap.
    fn most_count(&self) -> u32 {
        let casters = if self.count_batches > 1 { Casters::Batches } else { Casters::Scene };
        casters.most_count(self.count_bits)
    }

    /// Whether `choose` keeps two measures for each caster, light and view.
    fn has_measures(&self) -> bool {
        self.end_at_range || self.has_receivers || self.counting.is_zp_plus_2005()
    }

    /// Bytes of the choices of all casters, and with their measures.
    pub(crate) fn choice_bytes(&self, casters: usize, lights: usize, views: usize) -> [u64; 2] {
        let choices = CHOICES * (casters * lights.div_ceil(32) * views) as u64;
        let measures = if self.has_measures() { MEASURES * (lights * views * casters) as u64 } else { 0 };
        [choices, choices + measures.next_multiple_of(16)]
    }
}

/// Casters whose lists are common: those of one page and one source of positions, or a single one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GroupSize {
    /// Slots of faces and edges.
    pub(crate) faces: u32,
    pub(crate) edges: u32,
    /// The first caster.
    pub(crate) first_caster: u32,
    /// Slots of the faces of casters that are not in the depth buffer.
    pub(crate) proxies: u32,
    /// Where their lights and the casters of their chunks begin in the table, if there are several casters.
    pub(crate) lights_at: u32,
    pub(crate) face_chunks_at: u32,
    pub(crate) edge_chunks_at: u32,
}

/// Entries of the lists of each light of a group and a batch of lights.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room {
    /// Lights of the batch.
    pub(crate) lights: u32,
    /// The word of what is kept of the extraction where the encodes are that made its lists. A single caster has none.
    pub(crate) lists_at: u32,
    /// Entries of the list of silhouettes.
    pub(crate) silhouettes: u32,
    /// Entries of both lists of sides together.
    pub(crate) sides: u32,
    /// Entries of both lists of near caps together.
    pub(crate) near: u32,
    /// Entries of both lists of other caps together.
    pub(crate) far: u32,
}

impl Room {
    /// Room for the sides of all silhouettes that one binding has room for, and for caps as the settings say. If they say
    /// nothing, near caps have room for sixteen times the root of the faces and `few`, other caps for all faces that may have
    /// one, and what a binding is short of is shared in proportion.
    pub(crate) fn new(
        settings: &VolumeSettings,
        group: &GroupSize,
        few: u32,
        silhouettes: u32,
        lights: u32,
        limits: &DispatchLimits,
    ) -> Self {
        let (faces, lights) = (group.faces.max(1), lights.max(1));
        let fitting = |head: u64| {
            u32::try_from(limits.binding.saturating_sub(head) / (4 * u64::from(lights))).unwrap_or(u32::MAX)
        };
        let near = match settings.counting {
            Counting::ZPass | Counting::ZFail => 1,
            Counting::Auto | Counting::ZpPlus => faces.min(few + 16 * faces.isqrt()),
            #[cfg(feature = "reference")]
            Counting::ZpPlus2005 => faces,
        };
        let far = if settings.counting.may_fail() || settings.end_at_range { faces } else { group.proxies.max(1) };
        let sides = silhouettes.min(fitting(SIDE_COUNTS));
        let mut room = Self { lights, lists_at: 0, silhouettes, sides, near, far };
        if let Some(capacity) = settings.cap_capacity {
            let asked = |default: u32| if default > 1 { capacity.clamp(1, faces) } else { 1 };
            (room.near, room.far) = (asked(near), asked(far));
        } else {
            room.share(fitting(CAP_COUNTS));
        }
        room
    }

    /// Shares so many entries between the lists of caps, in proportion.
    fn share(&mut self, entries: u32) {
        let wanted = u64::from(self.near) + u64::from(self.far);
        let share =
            |part: u32| u32::try_from(u64::from(part) * u64::from(entries) / wanted).unwrap_or(u32::MAX).clamp(1, part);
        (self.near, self.far) = (share(self.near), share(self.far));
    }

    fn side_bytes(self) -> u64 {
        SIDE_COUNTS + 4 * u64::from(self.sides) * u64::from(self.lights)
    }

    fn cap_entries(self) -> u64 {
        (u64::from(self.near) + u64::from(self.far)) * u64::from(self.lights)
    }

    /// The lists of sides and of cap faces: what they are, their bytes, and the bytes of their counts.
    pub(crate) fn lists(self) -> [(&'static str, u64, u64); 2] {
        [
            ("lists of sides", self.side_bytes(), SIDE_COUNTS),
            ("lists of cap faces", CAP_COUNTS + 4 * self.cap_entries(), CAP_COUNTS),
        ]
    }
}

/// All sizes of the volumes of some casters.
#[derive(Clone, Debug)]
pub(crate) struct VolumeSizes {
    pub(crate) settings: VolumeSettings,
    pub(crate) casters: usize,
    /// Numbers of lights that there is room for. Some may have no light.
    pub(crate) lights: usize,
    pub(crate) views: usize,
    /// Where choices begin in the table, in units of 16 bytes.
    pub(crate) choices_at: usize,
    pub(crate) groups: Vec<GroupSize>,
    /// For each group one for each batch of lights.
    pub(crate) rooms: Vec<Room>,
    /// Words for the receivers of each view.
    pub(crate) receivers: u64,
}

impl VolumeSizes {
    /// A single caster, which is alone in its table, for one view.
    pub(crate) fn of_one(settings: VolumeSettings, lights: usize, group: GroupSize, rooms: Vec<Room>) -> Self {
        let choices_at = size_of::<SceneCaster>() / 16;
        Self { settings, casters: 1, lights, views: 1, choices_at, groups: vec![group], rooms, receivers: 0 }
    }

    /// Batches of 32 lights.
    pub(crate) fn batches(&self) -> usize {
        self.lights.div_ceil(32)
    }

    /// Bytes of the choices of all casters, and with their measures.
    pub(crate) fn choice_bytes(&self) -> [u64; 2] {
        self.settings.choice_bytes(self.casters, self.lights, self.views)
    }

    /// Numbers up to that of the last light.
    pub(crate) fn used_lights(&self) -> usize {
        let last = self.batches().saturating_sub(1);
        32 * last + self.rooms.get(last).map_or(0, |room| room.lights as usize)
    }

    /// Whether some casters are not in the depth buffer.
    pub(crate) fn has_proxies(&self) -> bool {
        self.groups.iter().any(|group| group.proxies > 0)
    }

    /// Pairs of view and light.
    pub(crate) fn seen(&self) -> usize {
        self.views * self.lights
    }

    /// Pencils, and their rows for all batches of casters.
    pub(crate) fn bound_bytes(&self) -> [u64; 2] {
        let pencils = self.seen() as u64;
        [size_of::<StencilPencil>() as u64 * pencils, CROSSINGS * pencils * u64::from(self.settings.count_batches)]
    }

    /// Bytes that tell what the lists for views were made from.
    pub(crate) fn listed_bytes(&self) -> u64 {
        LISTED * (self.rooms.len() * self.views) as u64
    }

    /// Bytes for the receivers of all views. The receivers of the first view begin after a word.
    pub(crate) fn receiver_bytes(&self) -> u64 {
        4 * (1 + self.views as u64 * self.receivers)
    }

    /// Bytes of the boxes of all casters.
    pub(crate) fn box_bytes(&self) -> u64 {
        BOX * self.casters as u64
    }

    /// Buffers that do not depend on the room of lists: what they are, and their bytes.
    pub(crate) fn besides_lists(&self) -> Vec<(&'static str, u64)> {
        let seen = self.seen() as u64;
        let [_, choices] = self.choice_bytes();
        let mut wanted = vec![
            ("seen lights", seen * size_of::<SeenLight>() as u64),
            ("caster boxes", self.box_bytes()),
            ("choices", choices),
            ("versions of lists", self.listed_bytes()),
            ("receivers", self.receiver_bytes()),
            ("shadow shapes", self.rooms.len() as u64 * UniformTable::stride::<ShadowShape>() as u64),
            ("shadow draw lights", seen * u64::from(self.settings.count_batches) * DRAW_LIGHT),
        ];
        wanted.extend(self.groups.iter().map(|_| ("shadow draws", seen * size_of::<ShadowDraws>() as u64)));
        if self.settings.bound_counts {
            wanted.extend(["stencil pencils", "stencil crossings"].into_iter().zip(self.bound_bytes()));
        }
        wanted
    }

    /// Makes lists of caps as small as the memory limit demands, unless the caller says how large they are. `others` are
    /// bytes of anything else.
    pub(crate) fn fit_memory(&mut self, others: u64) {
        let Self { settings, views, .. } = *self;
        let (Some(limit), None) = (settings.memory_limit, settings.cap_capacity) else { return };
        let besides: u64 = self.besides_lists().iter().map(|&(_, bytes)| padded(bytes)).sum();
        let lists = self.rooms.iter().map(|room| room.side_bytes() + CAP_COUNTS).sum::<u64>() * views as u64;
        let left = limit.saturating_sub(others + besides + lists) / (4 * views as u64).max(1);
        let all: u64 = self.rooms.iter().map(|room| room.cap_entries()).sum();
        if left < all {
            for room in &mut self.rooms {
                let entries = u128::from(room.near + room.far) * u128::from(left) / u128::from(all);
                room.share(u32::try_from(entries).unwrap_or(u32::MAX));
            }
        }
    }

    /// The sizes and offsets that stages and draws of a group and batch read. `part` is its index in `rooms`.
    pub(crate) fn shape(&self, part: usize) -> ShadowShape {
        let group = self.groups.get(part / self.batches().max(1));
        let (Some(group), Some(room), settings) = (group, self.rooms.get(part), &self.settings) else {
            return bytemuck::Zeroable::zeroed();
        };
        let [choices, _] = self.choice_bytes();
        ShadowShape {
            casters: self.casters as u32,
            lights: self.lights as u32,
            batches: self.batches() as u32,
            faces: group.faces,
            edges: group.edges,
            capacity: room.silhouettes,
            side_capacity: room.sides,
            near_capacity: room.near,
            far_capacity: room.far,
            averted: u32::from(settings.averted),
            counting: settings.counting.code(),
            skip_unreached: u32::from(settings.skip_unreached),
            skip_unseen: u32::from(settings.skip_unseen),
            end_at_range: u32::from(settings.end_at_range),
            choices_at: self.choices_at as u32,
            measures_at: self.choices_at as u32 + (choices / 16) as u32,
            lights_at: group.lights_at,
            face_chunks_at: group.face_chunks_at,
            edge_chunks_at: group.edge_chunks_at,
            views: self.views as u32,
            count_batches: settings.count_batches,
            proxies: u32::from(group.proxies > 0),
            part: part as u32,
            first_caster: group.first_caster,
            lists_at: room.lists_at,
            keeps: u32::from(settings.keeps),
            needs_boxes: u32::from(settings.bound_counts),
            used_lights: self.used_lights() as u32,
            has_receivers: u32::from(settings.has_receivers),
            most_count: settings.most_count(),
        }
    }
}
