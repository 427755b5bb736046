//! Clusters: decides whether all faces of a cluster face a light, or none does, and lists the chunks of faces that are left.
//! docs/numerics/clusters.md.

use super::table::SceneTable;
use crate::layout::{ScaledLight, SceneCaster, SceneDispatch};
use crate::mesh::clusters::{CLUSTER_FACES, ClusterBound, cluster_kinds};

/// Slots of a chunk.
const SLOTS: u32 = 64;
/// Words of a bound.
const BOUND_WORDS: usize = 12;

/// The facing of all faces of a cluster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Whole {
    /// Every face faces the light. The light is in no face's plane.
    Facing,
    /// No face faces the light. It is in no face's plane, but for faces that name a vertex twice, which are not excluded.
    Averted,
    /// Nothing is known.
    Mixed,
}

/// 2.5 units in the last place: what the rounding of `w·centre` may change the middle and the half by.
pub const PRODUCT: f32 = 2.5 / 8_388_608.0;
/// The most that underflow adds: 2⁻¹¹⁸.
pub const LEAST: f32 = f32::from_bits((127 - 118) << 23);

/// Decides a cluster for a light as given, which is finite.
pub fn clusters(bound: &ClusterBound, light: [f32; 4]) -> Whole {
    if bound.kind == cluster_kinds::MIXED {
        return Whole::Mixed;
    }
    if bound.kind == cluster_kinds::AVERTED {
        return Whole::Averted;
    }
    let [height, spread] = height_and_spread(bound, light);
    if height > spread && bound.kind != cluster_kinds::AT_MOST_AVERTED {
        Whole::Facing
    } else if height < -spread {
        Whole::Averted
    } else {
        Whole::Mixed
    }
}

/// The height of the scaled light over the middle of the planes, and how far the heights over the planes may be from it.
pub fn height_and_spread(bound: &ClusterBound, light: [f32; 4]) -> [f32; 2] {
    let ScaledLight { light: [x, y, z, w], inexact_w } = ScaledLight::new(light);
    let ClusterBound { centre: c, middle, half, .. } = *bound;
    let t = [x - w * c[0], y - w * c[1], z - w * c[2]];
    let height = middle[0] * t[0] + middle[1] * t[1] + middle[2] * t[2] + middle[3] * w;
    let spread = half[0] * t[0].abs() + half[1] * t[1].abs() + half[2] * t[2].abs() + half[3] * w.abs().max(inexact_w);
    [height, spread + PRODUCT * inexact_w * (c[0].abs() + c[1].abs() + c[2].abs()) + LEAST]
}

/// The listed chunks of faces of a group and batch.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ListedFaces {
    /// Each chunk with the lights that are decided for all its faces, those of them that the faces face, and the places of the
    /// lights that are tested, all if none is decided. In order.
    pub chunks: Vec<[u32; 4]>,
    /// For each chunk two words, of which only the first chunk of a cluster has any: lights for which all faces of the cluster
    /// have the same bit, and these bits.
    pub kept: Vec<u32>,
    /// Faces that are tested, and those that need not be.
    pub faces: [u32; 2],
}

/// Whether a caster's clusters decide anything. `words` are those of its page.
pub(super) fn has_clusters(caster: &SceneCaster) -> bool {
    caster.clusters_or_figure != u32::MAX && caster.flags & 4 != 0
}

/// The chunks of faces that are listed. `taken` is what [`super::reach::take`] returns, `words` are the clusters of the group's
/// page, and `before` is [`ListedFaces::kept`] of the encode before, or empty if it had another layout.
pub fn list_faces(
    table: SceneTable<'_>,
    group: &SceneDispatch,
    taken: &[u32],
    words: &[u32],
    before: &[u32],
) -> ListedFaces {
    let mut listed = ListedFaces { kept: before.to_vec(), ..ListedFaces::default() };
    listed.kept.resize(2 * group.face_chunks as usize, 0);
    // The decision for the current cluster, and whether the masks have it already.
    let (mut decision, mut is_known) = ([0; 2], false);
    for chunk in 0..group.face_chunks {
        let index = table.word(group.face_chunks_at, chunk);
        let caster = table.caster(index);
        let taken = taken.get((group.batch * group.casters + index) as usize).copied().unwrap_or(0);
        let number = chunk - caster.first_face_slot / SLOTS;
        if !has_clusters(&caster) {
            (decision, is_known) = ([0; 2], taken == 0);
        } else if (SLOTS * number).is_multiple_of(CLUSTER_FACES as u32) {
            let cluster = SLOTS * number / CLUSTER_FACES as u32;
            decision = decide(table, group, index, taken, bound(words, &caster, cluster));
            if let Some([decided, facing]) = listed.kept.get_mut(2 * chunk as usize..2 * chunk as usize + 2) {
                is_known = (0..32).filter(|light| taken >> light & 1 != 0).all(|light| {
                    let bits = [decision[0], *decided, decision[1], *facing].map(|word| word >> light & 1);
                    bits[0] == 1 && bits[1] == 1 && bits[2] == bits[3]
                });
                *decided = *decided & !taken | decision[0];
                *facing = *facing & !taken | decision[1];
            }
        }
        let faces = (caster.first_face_slot + caster.faces - SLOTS * chunk).min(SLOTS);
        let is_tested = taken & !decision[0] != 0;
        listed.faces[0] += if is_tested { faces } else { 0 };
        listed.faces[1] += if taken != 0 && !is_tested { faces } else { 0 };
        if !is_known {
            let allowed = table.lights(group, index, group.batch).allowed;
            let tested = (0..32)
                .filter(|light| allowed >> light & 1 != 0)
                .zip(0..)
                .fold(0, |tested, (light, place)| tested | (taken & !decision[0]) >> light << 31 >> (31 - place));
            listed.chunks.push([chunk, decision[0], decision[1], if decision[0] == 0 { u32::MAX } else { tested }]);
        }
    }
    listed
}

/// The bound of a cluster of a caster.
fn bound(words: &[u32], caster: &SceneCaster, cluster: u32) -> ClusterBound {
    let first = caster.clusters_or_figure as usize + BOUND_WORDS * cluster as usize;
    let words =
        words.get(first..first + BOUND_WORDS).map(|words| bytemuck::pod_read_unaligned(bytemuck::cast_slice(words)));
    words.unwrap_or_else(bytemuck::Zeroable::zeroed)
}

/// The lights that the cluster decides, and those of them that its faces face.
fn decide(table: SceneTable<'_>, group: &SceneDispatch, caster: u32, taken: u32, bound: ClusterBound) -> [u32; 2] {
    let lights = table.lights(group, caster, group.batch);
    let of_caster = (0..32).filter(|light| lights.allowed >> light & 1 != 0).zip((lights.first..).step_by(2));
    of_caster.filter(|(light, _)| taken >> light & 1 != 0).fold(
        [0; 2],
        |[decided, facing], (light, at)| match clusters(&bound, table.part(at).map(f32::from_bits)) {
            Whole::Facing => [decided | 1 << light, facing | 1 << light],
            Whole::Averted => [decided | 1 << light, facing],
            Whole::Mixed => [decided, facing],
        },
    )
}
