//! Clusters: decides whether all faces of a cluster face a light, or none does.
//! docs/numerics/clusters.md.

use crate::layout::ScaledLight;
use crate::mesh::clusters::{ClusterBound, cluster_kinds};

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
