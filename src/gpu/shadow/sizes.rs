//! How large shadow volumes are: the room of their lists, and the shape that stages and draws read.

use super::format::Casters;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::scene::options::{Measuring, SceneOptions, StencilCounts};
use crate::layout::{ShadowShape, StencilPencil};
use crate::shadow::Counting;

/// Bytes before the lists of sides of a batch: two counts for each light.
const SIDE_COUNTS: u64 = 4 * 64;
/// Bytes before the lists of cap faces: four counts for each light.
const CAP_COUNTS: u64 = 4 * 128;
/// Bytes of the choices of a caster for a batch of lights.
const CHOICES: u64 = 32;
/// Bytes of the measures of a caster for a light.
const MEASURES: u64 = 8;
/// Bytes of the counts of crossings of a pencil's half planes, for a batch of casters.
const CROSSINGS: u64 = 4 * 1028;
/// Bytes of the versions that the lists of a group, batch and view were made from: two words for each light.
const LIST_VERSIONS: u64 = 8 * 32;
/// Bytes of the box of a caster.
const BOX: u64 = 28;

/// Whether `counting_methods` writes two measures for each caster, light and view. `has_receivers`: views may have receivers, behind
/// which volumes end.
fn has_measures(options: &SceneOptions, has_receivers: bool) -> bool {
    options.end_at_range || has_receivers || options.counting.is_zp_plus_2005()
}

/// Bytes of the choices of all casters, and with their measures.
pub(crate) fn choice_bytes(
    options: &SceneOptions,
    has_receivers: bool,
    [casters, lights, views]: [usize; 3],
) -> [u64; 2] {
    let choices = CHOICES * (casters * lights.div_ceil(32) * views) as u64;
    let measures = if has_measures(options, has_receivers) { MEASURES * (lights * views * casters) as u64 } else { 0 };
    [choices, choices + measures.next_multiple_of(16)]
}

/// Casters whose lists are common: those of one page and one source of positions.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GroupSize {
    /// Slots of faces and edges.
    pub(crate) faces: u32,
    pub(crate) edges: u32,
    /// Boundary edges, whose sides are drawn once. Sides of other edges may be drawn twice.
    pub(crate) boundaries: u32,
    /// The first caster.
    pub(crate) first_caster: u32,
    /// Slots of the faces of casters that are not in the depth buffer.
    pub(crate) proxies: u32,
    /// Offsets in the table of their lights and of the casters of their chunks.
    pub(crate) lights_offset: u32,
    pub(crate) face_chunks_offset: u32,
    pub(crate) edge_chunks_offset: u32,
}

/// The capacity of the lists of each light, for a group and a batch of lights, in entries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room {
    /// Lights of the batch.
    pub(crate) lights: u32,
    /// The offset in the cached versions, in words, of the encodes that made its lists.
    pub(crate) lists_offset: u32,
    /// Entries of the list of silhouettes.
    pub(crate) silhouettes: u32,
    /// Entries of both lists of sides together.
    pub(crate) sides: u32,
    /// Entries of both lists of near caps together.
    pub(crate) near: u32,
    /// Entries of both lists of other caps together.
    pub(crate) far: u32,
    /// Pieces of twisted polygons. 0: the casters have triangles only.
    pub(crate) pieces: u32,
}

impl Room {
    /// Sides have room for those of all listed silhouettes, as far as one binding has: two an edge where every face casts,
    /// but one for a boundary. Capacities of caps are those of the options. By default near caps have room for `few_caps` and
    /// sixteen times the square root of the faces, other caps for all faces that may have one; both shrink in proportion if
    /// they do not fit one binding.
    pub(crate) fn new(
        options: &SceneOptions,
        group: &GroupSize,
        few_caps: u32,
        silhouettes: u32,
        lights: u32,
        limits: &DispatchLimits,
    ) -> Self {
        let (faces, lights) = (group.faces.max(1), lights.max(1));
        let fitting = |head: u64| {
            u32::try_from(limits.binding.saturating_sub(head) / (4 * u64::from(lights))).unwrap_or(u32::MAX)
        };
        let near = match options.counting {
            Counting::ZPass | Counting::ZFail => 1,
            Counting::Auto | Counting::ZpPlus => faces.min(few_caps + 16 * faces.isqrt()),
            Counting::ZpPlus2005 => faces,
        };
        let far = if options.counting.may_fail() || options.end_at_range { faces } else { group.proxies.max(1) };
        let two_sided = silhouettes.min(group.edges.saturating_sub(group.boundaries));
        let sides = silhouettes.saturating_add(two_sided).min(fitting(SIDE_COUNTS));
        let mut room = Self { lights, lists_offset: 0, silhouettes, sides, near, far, pieces: 0 };
        if let Some(capacity) = options.capacities.caps {
            let given = |default: u32| if default > 1 { capacity.clamp(1, faces) } else { 1 };
            (room.near, room.far) = (given(near), given(far));
        } else {
            room.share(fitting(CAP_COUNTS));
        }
        room
    }

    /// Divides `entries` between the lists of caps, in proportion.
    fn share(&mut self, entries: u32) {
        let wanted = u64::from(self.near) + u64::from(self.far);
        let share =
            |part: u32| u32::try_from(u64::from(part) * u64::from(entries) / wanted).unwrap_or(u32::MAX).clamp(1, part);
        (self.near, self.far) = (share(self.near), share(self.far));
    }

    fn cap_entries(self) -> u64 {
        (u64::from(self.near) + u64::from(self.far)) * u64::from(self.lights)
    }

    /// The lists of sides and of cap faces: their bytes, and those of their counts.
    pub(crate) fn lists(self) -> [(u64, u64); 2] {
        let sides = 4 * u64::from(self.sides) * u64::from(self.lights);
        [(SIDE_COUNTS + sides, SIDE_COUNTS), (CAP_COUNTS + 4 * self.cap_entries(), CAP_COUNTS)]
    }
}

/// All sizes of the volumes of some casters.
#[derive(Clone, Debug)]
pub(crate) struct VolumeSizes {
    pub(crate) options: SceneOptions,
    pub(crate) casters: usize,
    /// Light indices that there is room for. Some may be unused.
    pub(crate) lights: usize,
    pub(crate) views: usize,
    /// The offset of choices in the table, in units of 16 bytes.
    pub(crate) choices_offset: usize,
    pub(crate) groups: Vec<GroupSize>,
    /// For each group one for each batch of lights.
    pub(crate) rooms: Vec<Room>,
    /// Words for the receivers of each view.
    pub(crate) receivers: u64,
}

impl VolumeSizes {
    /// Batches of 32 lights.
    pub(crate) fn batches(&self) -> usize {
        self.lights.div_ceil(32)
    }

    /// Bytes of the choices of all casters, and with their measures.
    pub(crate) fn choice_bytes(&self) -> [u64; 2] {
        choice_bytes(&self.options, self.receivers > 0, [self.casters, self.lights, self.views])
    }

    /// The index of the last light, plus 1.
    pub(crate) fn used_lights(&self) -> usize {
        let last = self.batches().saturating_sub(1);
        32 * last + self.rooms.get(last).map_or(0, |room| room.lights as usize)
    }

    /// Whether a group has polygons, and so may have pieces of twisted ones.
    pub(crate) fn group_has_pieces(&self, group: usize) -> bool {
        self.rooms.get(group * self.batches()).is_some_and(|room| room.pieces > 0)
    }

    /// Whether any group has polygons.
    pub(crate) fn has_pieces(&self) -> bool {
        self.rooms.iter().any(|room| room.pieces > 0)
    }

    /// Pairs of view and light.
    pub(crate) fn view_lights(&self) -> usize {
        self.views * self.lights
    }

    /// Pencils, and their rows for all batches of casters.
    pub(crate) fn bound_bytes(&self) -> [u64; 2] {
        let pencils = self.view_lights() as u64;
        [
            size_of::<StencilPencil>() as u64 * pencils,
            CROSSINGS * pencils * u64::from(self.options.stencil.count_batches),
        ]
    }

    /// Bytes of the versions that the lists for views were made from.
    pub(crate) fn list_version_bytes(&self) -> u64 {
        LIST_VERSIONS * (self.rooms.len() * self.views) as u64
    }

    /// Bytes for the receivers of all views. The receivers of the first view begin after a word.
    pub(crate) fn receiver_bytes(&self) -> u64 {
        4 * (1 + self.views as u64 * self.receivers)
    }

    /// Bytes of the boxes of all casters.
    pub(crate) fn box_bytes(&self) -> u64 {
        BOX * self.casters as u64
    }

    /// Shrinks lists of caps to fit the memory limit, unless the caller gives their capacity. `all` is the size of
    /// everything in bytes.
    pub(crate) fn fit_memory(&mut self, all: u64) {
        let (Some(limit), None) = (self.options.memory_limit, self.options.capacities.caps) else { return };
        let entries: u64 = self.rooms.iter().map(|room| room.cap_entries()).sum();
        let bytes = 4 * self.views as u64;
        let left = limit.saturating_sub(all - bytes * entries) / bytes.max(1);
        if left < entries {
            for room in &mut self.rooms {
                let share = u128::from(room.near + room.far) * u128::from(left) / u128::from(entries);
                room.share(u32::try_from(share).unwrap_or(u32::MAX));
            }
        }
    }

    /// The sizes and offsets that stages and draws of a group and batch read. `part` is its index in `rooms`.
    pub(crate) fn shape(&self, part: usize) -> ShadowShape {
        let group = self.groups.get(part / self.batches().max(1));
        let (Some(group), Some(room)) = (group, self.rooms.get(part)) else { return bytemuck::Zeroable::zeroed() };
        let [choices, _] = self.choice_bytes();
        let SceneOptions { counting, end_at_range, stencil, measuring, .. } = self.options;
        let StencilCounts { count_bits, count_batches, bound_counts } = stencil;
        let is_on = |skipped: Measuring| u32::from(!measuring.has(skipped));
        let casters = if count_batches > 1 { Casters::Batches } else { Casters::Scene };
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
            allow_back_facing: is_on(Measuring::EVERY_FACE),
            counting: counting.code(),
            cull_by_range: is_on(Measuring::CULLED_BY_RANGE),
            cull_by_view: is_on(Measuring::CULLED_BY_VIEW),
            end_at_range: u32::from(end_at_range),
            choices_offset: self.choices_offset as u32,
            measures_offset: self.choices_offset as u32 + (choices / 16) as u32,
            lights_offset: group.lights_offset,
            face_chunks_offset: group.face_chunks_offset,
            edge_chunks_offset: group.edge_chunks_offset,
            views: self.views as u32,
            count_batches,
            proxies: u32::from(group.proxies > 0),
            group_and_batch: part as u32,
            first_caster: group.first_caster,
            lists_offset: room.lists_offset,
            uses_cache: is_on(Measuring::CACHED_BITS) & is_on(Measuring::CACHED_LISTS),
            needs_boxes: u32::from(bound_counts),
            used_lights: self.used_lights() as u32,
            has_receivers: u32::from(self.receivers > 0),
            largest_count: casters.largest_count(count_bits),
            piece_capacity: room.pieces,
        }
    }
}
