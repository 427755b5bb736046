//! How large shadow volumes are: the room of their lists, and the shape that stages and draws read.

use super::format::Casters;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::scene::options::{Measuring, SceneOptions, StencilCounts};
use crate::layout::ShadowShape;
use crate::shadow::Counting;

/// Bytes before the lists of sides of a batch: two counts for each light.
const SIDE_COUNTS: u64 = 4 * 64;
/// Bytes before the lists of cap faces: four counts for each light.
const CAP_COUNTS: u64 = 4 * 128;
/// Bytes of the choices of a caster for a batch of lights.
const CHOICES: u64 = 32;
/// Bytes of the measures of a caster for a light.
const MEASURES: u64 = 8;
/// Room for near caps in each group, in addition to sixteen times the root of the faces.
const FEW_CAPS: u32 = 4096;

/// Bytes of the choices of all casters, and with their measures, which `counting_methods` writes for each caster, light
/// and view if it ends volumes or has ZP+ as published. `has_receivers`: views may have receivers, behind which volumes
/// end.
pub(crate) fn choice_bytes(
    options: &SceneOptions,
    has_receivers: bool,
    [casters, lights, views]: [usize; 3],
) -> [u64; 2] {
    let choices = CHOICES * (casters * lights.div_ceil(32) * views) as u64;
    let has_measures = options.end_at_range || has_receivers || options.counting.is_zp_plus_2005();
    let measures = if has_measures { MEASURES * (lights * views * casters) as u64 } else { 0 };
    [choices, choices + measures.next_multiple_of(16)]
}

/// A group of casters and a batch of lights: slots, offsets, and the room of the lists of each light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartSizes {
    /// [`VolumeSizes::shape`] adds what all parts have in common.
    pub(crate) shape: ShadowShape,
    /// Bits of the batch up to the last light.
    pub(crate) lights: u32,
}

impl PartSizes {
    /// `shape` has the slots and offsets of the group, and the capacity of silhouettes. `boundaries` are boundary edges, whose
    /// sides are drawn once. `proxies` are the slots of faces of casters that are not in the depth buffer.
    ///
    /// Sides have room for those of all listed silhouettes, as far as one binding has: two an edge where every face casts,
    /// but one for a boundary. Capacities of caps are those of the options, but 1 where the counting method has no such caps.
    /// By default near caps have room for [`FEW_CAPS`] and sixteen times the square root of the faces (all for ZP+ as
    /// published), other caps for all faces that may have one; both shrink in proportion if they do not fit one binding.
    pub(crate) fn new(
        options: &SceneOptions,
        shape: ShadowShape,
        lights: u32,
        [boundaries, proxies]: [u32; 2],
        limits: &DispatchLimits,
    ) -> Self {
        let (faces, lights) = (shape.faces.max(1), lights.max(1));
        let fitting = |head: u64| {
            u32::try_from(limits.binding.saturating_sub(head) / (4 * u64::from(lights))).unwrap_or(u32::MAX)
        };
        let near = match options.counting {
            Counting::ZPass | Counting::ZFail => 1,
            Counting::Auto | Counting::ZpPlus => faces.min(FEW_CAPS + 16 * faces.isqrt()),
            Counting::ZpPlus2005 => faces,
        };
        let far = if options.counting.may_fail() || options.end_at_range { faces } else { proxies.max(1) };
        let two_sided = shape.capacity.min(shape.edges.saturating_sub(boundaries));
        let shape = ShadowShape {
            side_capacity: shape.capacity.saturating_add(two_sided).min(fitting(SIDE_COUNTS)),
            near_capacity: near,
            far_capacity: far,
            proxies: u32::from(proxies > 0),
            ..shape
        };
        let mut part = Self { shape, lights };
        if let Some(capacity) = options.capacities.caps {
            let given = |default: u32| if default > 1 { capacity.clamp(1, faces) } else { 1 };
            (part.shape.near_capacity, part.shape.far_capacity) = (given(near), given(far));
        } else {
            part.share(fitting(CAP_COUNTS));
        }
        part
    }

    /// Divides `entries` between the lists of caps, in proportion.
    fn share(&mut self, entries: u32) {
        let ShadowShape { near_capacity: near, far_capacity: far, .. } = &mut self.shape;
        let wanted = u64::from(*near) + u64::from(*far);
        let share =
            |part: u32| u32::try_from(u64::from(part) * u64::from(entries) / wanted).unwrap_or(u32::MAX).clamp(1, part);
        (*near, *far) = (share(*near), share(*far));
    }

    fn cap_entries(self) -> u64 {
        (u64::from(self.shape.near_capacity) + u64::from(self.shape.far_capacity)) * u64::from(self.lights)
    }

    /// The bytes of the lists of sides and of cap faces, with their counts.
    pub(crate) fn lists(self) -> [u64; 2] {
        let sides = 4 * u64::from(self.shape.side_capacity) * u64::from(self.lights);
        [SIDE_COUNTS + sides, CAP_COUNTS + 4 * self.cap_entries()]
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
    /// For each group one for each batch of lights.
    pub(crate) parts: Vec<PartSizes>,
    /// Words for the receivers of each view.
    pub(crate) receivers: u64,
}

impl VolumeSizes {
    /// Batches of 32 lights.
    pub(crate) fn batches(&self) -> usize {
        self.lights.div_ceil(32)
    }

    /// The part of each group for the first batch of lights.
    pub(crate) fn groups(&self) -> impl ExactSizeIterator<Item = &PartSizes> {
        self.parts.iter().step_by(self.batches().max(1))
    }

    /// Bytes of the choices of all casters, and with their measures.
    pub(crate) fn choice_bytes(&self) -> [u64; 2] {
        choice_bytes(&self.options, self.receivers > 0, [self.casters, self.lights, self.views])
    }

    /// The index of the last light, plus 1.
    pub(crate) fn used_lights(&self) -> usize {
        let last = self.batches().saturating_sub(1);
        32 * last + self.parts.get(last).map_or(0, |part| part.lights as usize)
    }

    /// Pairs of view and light.
    pub(crate) fn view_lights(&self) -> usize {
        self.views * self.lights
    }

    /// Shrinks lists of caps to fit the memory limit, unless the caller gives their capacity. `all` is the size of
    /// everything in bytes.
    pub(crate) fn fit_memory(&mut self, all: u64) {
        let (Some(limit), None) = (self.options.memory_limit, self.options.capacities.caps) else { return };
        let entries: u64 = self.parts.iter().map(|part| part.cap_entries()).sum();
        let bytes = 4 * self.views as u64;
        let left = limit.saturating_sub(all - bytes * entries) / bytes.max(1);
        if left < entries {
            for part in &mut self.parts {
                let ShadowShape { near_capacity, far_capacity, .. } = part.shape;
                let share = u128::from(near_capacity + far_capacity) * u128::from(left) / u128::from(entries);
                part.share(u32::try_from(share).unwrap_or(u32::MAX));
            }
        }
    }

    /// The sizes and offsets that stages and draws of a group and batch read. `part` is its index in `parts`.
    pub(crate) fn shape(&self, part: usize) -> ShadowShape {
        let Some(sizes) = self.parts.get(part) else { return bytemuck::Zeroable::zeroed() };
        let [choices, _] = self.choice_bytes();
        let SceneOptions { counting, end_at_range, stencil, measuring, .. } = self.options;
        let StencilCounts { count_bits, count_batches, bound_counts } = stencil;
        let is_on = |skipped: Measuring| u32::from(!measuring.has(skipped));
        let casters = if count_batches > 1 { Casters::Batches } else { Casters::Scene };
        ShadowShape {
            casters: self.casters as u32,
            lights: self.lights as u32,
            batches: self.batches() as u32,
            allow_back_facing: is_on(Measuring::EVERY_FACE),
            counting: counting.code(),
            cull_by_range: is_on(Measuring::CULLED_BY_RANGE),
            cull_by_view: is_on(Measuring::CULLED_BY_VIEW),
            end_at_range: u32::from(end_at_range),
            choices_offset: self.choices_offset as u32,
            measures_offset: self.choices_offset as u32 + (choices / 16) as u32,
            views: self.views as u32,
            count_batches,
            group_and_batch: part as u32,
            uses_cache: is_on(Measuring::CACHED_BITS) & is_on(Measuring::CACHED_LISTS),
            needs_boxes: u32::from(bound_counts),
            used_lights: self.used_lights() as u32,
            has_receivers: u32::from(self.receivers > 0),
            largest_count: casters.largest_count(count_bits),
            ..sizes.shape
        }
    }
}
