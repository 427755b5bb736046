//! The CPU's copy of the scene table. Changes of casters and lights update it, and each encode uploads it.

use bytemuck::Zeroable;

use super::caster::{CasterEntry, Placement};
use super::lights::Lights;
use crate::Transform;
use crate::layout::caster_flags::{BOUNDED, CLOSED, EXCLUDES, MIRRORED, NON_FINITE, PROXY, RIGID, UNCACHED};
use crate::layout::{CasterLights, LightCone, NO_CLUSTERS, SceneCaster, bits};
use crate::light::Light;
use crate::light_batch::ScaledLight;

/// Four words of the table.
pub(crate) type Part = [u32; 4];
/// Parts of a caster.
pub(crate) const CASTER_PARTS: usize = size_of::<SceneCaster>() / size_of::<Part>();
/// Parts of a light: as given, and scaled.
pub(crate) const LIGHT_PARTS: u32 = 2;
/// Parts of the ranges of a batch, and of the versions of its lights.
pub(crate) const RANGE_PARTS: usize = 8;

/// Parts of the cone of a light.
const CONE_PARTS: usize = size_of::<LightCone>() / size_of::<Part>();

/// The table, and the offsets of its sections. Casters are first.
#[derive(Debug, Default)]
pub(crate) struct Table {
    pub(crate) parts: Vec<Part>,
    pub(crate) casters: usize,
    pub(crate) batches: usize,
    /// Whether lights cull casters by range and cone.
    pub(crate) culls_by_range: bool,
    /// Whether occluders cull casters.
    pub(crate) culls_by_occluders: bool,
}

impl Table {
    /// The bits of the lights of each batch and caster.
    pub(crate) fn lights_offset(&self) -> usize {
        CASTER_PARTS * self.casters
    }

    /// The ranges of lights, then their versions.
    pub(crate) fn ranges_offset(&self) -> usize {
        self.lights_offset() + self.batches * self.casters
    }

    /// The number of the encode, and two other words.
    fn encode_offset(&self) -> usize {
        self.ranges_offset() + 2 * RANGE_PARTS * self.batches
    }

    /// The cones of lights.
    fn cones_offset(&self) -> usize {
        self.encode_offset() + 1
    }

    /// The lights in the spaces of casters.
    pub(crate) fn caster_lights_offset(&self) -> usize {
        self.cones_offset() + CONE_PARTS * 32 * self.batches
    }

    /// Writes the number of the encode, the word of the work lists where the states of deforming casters begin (0: none),
    /// and the largest coordinate of the origins of cameras.
    pub(crate) fn put_encode(&mut self, encode: u32, needed_states_offset: u32, origin: f32) {
        self.put(self.encode_offset(), &[[encode, needed_states_offset, origin.to_bits(), 0]]);
    }

    pub(crate) fn put(&mut self, offset: usize, parts: &[Part]) {
        if let Some(range) = self.parts.get_mut(offset..offset + parts.len()) {
            range.copy_from_slice(parts);
        }
    }

    /// Writes a caster. `slots` has its group, its slots there, and the flag of the group.
    pub(crate) fn put_caster(&mut self, entry: &CasterEntry, slots: SceneCaster) {
        let mesh = &entry.mesh;
        let [faces, edges, _, clusters] = mesh.region.ranges.clone().map(|range| range.start);
        let [position_offset, position_stride] = entry.position_words();
        let is_rigid = matches!(entry.placement, Placement::Rigid(_));
        let [row_0, row_1, row_2] = Transform::UNIT;
        let mut caster = SceneCaster {
            row_0,
            row_1,
            row_2,
            low: mesh.low,
            scale: 1.0,
            high: mesh.high,
            flags: slots.flags
                | flag(mesh.is_closed, CLOSED)
                | flag(!entry.in_depth, PROXY)
                | flag(is_rigid, RIGID)
                | flag(is_rigid && mesh.is_holed, NON_FINITE)
                | flag(entry.is_excluding(), EXCLUDES),
            faces: mesh.faces,
            first_face: faces,
            position_offset,
            edges: mesh.edges(),
            first_edge: edges,
            position_stride,
            clusters_or_deforming_index: if mesh.order.is_some() { clusters } else { NO_CLUSTERS },
            ..slots
        };
        set_changes(&mut caster, entry);
        self.put(CASTER_PARTS * entry.index as usize, bytemuck::cast_slice(&[caster]));
    }

    /// Writes the parts of a caster that may change without a new layout.
    pub(crate) fn put_change(&mut self, entry: &CasterEntry) {
        let offset = CASTER_PARTS * entry.index as usize;
        let parts = self.parts.get_mut(offset..offset + CASTER_PARTS).unwrap_or_default();
        for caster in bytemuck::cast_slice_mut(parts) {
            set_changes(caster, entry);
        }
    }

    /// Writes the lights of a caster in its space. A light that cannot be moved to this space is not allowed.
    pub(crate) fn put_lights(&mut self, caster: &CasterEntry, lights: &Lights) {
        let mask = caster.lights.and(&lights.used);
        let mut first = caster.first_light;
        for batch in 0..self.batches {
            let (mut allowed, mut offset, mut magnitudes) = (0, first, [0.0_f32; 2]);
            for bit in bits(mask.word(batch)) {
                let Some(light) = caster.light(lights, 32 * batch as u32 + bit).map(Light::to_array) else { continue };
                let ScaledLight { light: scaled, inexact_w } = ScaledLight::new(light);
                self.put(offset as usize, &[light.map(f32::to_bits), scaled.map(f32::to_bits)]);
                let [x, y, z, w] = scaled.map(f32::abs);
                magnitudes = [magnitudes[0].max(x).max(y).max(z), magnitudes[1].max(w.max(inexact_w))];
                allowed |= 1 << bit;
                offset += LIGHT_PARTS;
            }
            let lights = CasterLights { allowed, first, magnitudes };
            self.put(
                self.lights_offset() + batch * self.casters + caster.index as usize,
                bytemuck::cast_slice(&[lights]),
            );
            first += LIGHT_PARTS * mask.word(batch).count_ones();
        }
    }

    /// Writes the ranges of all lights, 0 for no limit, their versions, and their cones.
    pub(crate) fn put_ranges(&mut self, lights: &Lights) {
        let culls_by_range = self.culls_by_range;
        let range = |bit| match lights.get(bit) {
            Some(Light { range, w, .. }) if culls_by_range && range.is_finite() && w != 0.0 => range.to_bits(),
            _ => 0,
        };
        let versions_offset = self.ranges_offset() + RANGE_PARTS * self.batches;
        for part in 0..RANGE_PARTS * self.batches {
            let bits = [0, 1, 2, 3].map(|bit| 4 * part as u32 + bit);
            self.put(self.ranges_offset() + part, &[bits.map(range)]);
            self.put(versions_offset + part, &[bits.map(|bit| lights.version(bit))]);
        }
        for bit in 0..32 * self.batches {
            let light = lights.get(bit as u32).filter(|_| culls_by_range);
            let cone = light.map_or_else(LightCone::zeroed, |light| LightCone::of(&light));
            self.put(self.cones_offset() + CONE_PARTS * bit, bytemuck::cast_slice(&[cone]));
        }
    }
}

/// Sets what may change without a new layout: the transform if the caster is rigid, else the stated box and the index among
/// deforming casters; and the version.
fn set_changes(caster: &mut SceneCaster, entry: &CasterEntry) {
    let mut flags = flag(entry.is_uncached(), UNCACHED) | flag(entry.bounds.is_some(), BOUNDED);
    match &entry.placement {
        Placement::Rigid(rigid) => {
            [caster.row_0, caster.row_1, caster.row_2] = finite(rigid.rows);
            caster.scale = rigid.scale;
            flags |= flag(rigid.is_mirrored, MIRRORED);
        }
        Placement::World { .. } => {
            // Low is above high if no box is stated.
            [caster.low, caster.high] = entry.bounds.unwrap_or([[f32::MAX; 3], [f32::MIN; 3]]);
            caster.clusters_or_deforming_index = entry.deforming_index;
        }
    }
    caster.flags = caster.flags & !(MIRRORED | UNCACHED | BOUNDED) | flags;
    caster.version = entry.version;
}

pub(crate) fn flag(is_set: bool, flag: u32) -> u32 {
    if is_set { flag } else { 0 }
}

/// Rows, or zeros if a component is not finite. Such a caster casts nothing.
fn finite(rows: crate::Matrix3x4) -> crate::Matrix3x4 {
    if rows.iter().flatten().all(|c| c.is_finite()) { rows } else { [[0.0; 4]; 3] }
}
