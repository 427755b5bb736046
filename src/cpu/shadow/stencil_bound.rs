//! Stencil bound: an upper bound of the stencil counts of a caster's volumes, for one light.

use glam::Vec3;

use crate::cpu::common::positions::is_finite;
use crate::layout::ShadowLight;
use crate::shadow::CAST_NOTHING;

/// The number of bins of the pencil of half planes.
const BINS: usize = 256;

/// An upper bound of the caster's stencil counts for `light`. `low` and `high` are the corners of the caster's box.
/// `faces` is the number of its faces. `sides` are its sides: the positions of the ends of their edges, and their weights.
/// The bound is 0 if nothing casts.
pub fn stencil_bound(
    light: &ShadowLight,
    [low, high]: [[f32; 3]; 2],
    faces: u32,
    sides: impl IntoIterator<Item = ([[f32; 3]; 2], i64)>,
) -> u32 {
    if light.casting == CAST_NOTHING {
        return 0;
    }
    let Some(pencil) = Pencil::new(light, Vec3::from(low), Vec3::from(high)) else { return faces };
    let corner =
        |number: u32| Vec3::from_array(std::array::from_fn(|axis| [low, high][(number >> axis & 1) as usize][axis]));
    let places = (0..8).map(|number| pencil.half_plane(corner(number)));
    let (first, last) =
        places.fold((f32::INFINITY, f32::NEG_INFINITY), |(first, last), at| (first.min(at), last.max(at)));
    let scale = BINS as f32 / (last - first).max(1e-30);
    let bin = |p: f32| p.clamp(0.0, (BINS - 1) as f32) as usize;
    let mut changes = [0_i64; BINS + 1];
    for (ends, weight) in sides {
        if ends.iter().all(|&end| is_finite(end)) {
            let [p, q] = ends.map(|end| (pencil.half_plane(Vec3::from(end)) - first) * scale);
            changes[bin(p.min(q))] += weight;
            changes[bin(p.max(q)) + 1] -= weight;
        }
    }
    let sums = changes.iter().scan(0, |crossed, change| {
        *crossed += change;
        Some(*crossed)
    });
    faces.min(sums.max().map_or(0, |most| (most + 1) / 2) as u32)
}

/// The half planes from an axis that goes through the light and misses the caster.
struct Pencil {
    forward: Vec3,
    aside: Vec3,
    place: Vec3,
    is_point: bool,
}

impl Pencil {
    /// `None` if the light is at the box.
    fn new(light: &ShadowLight, low: Vec3, high: Vec3) -> Option<Self> {
        let [x, y, z, w] = light.light;
        let is_point = w > 0.0;
        let place = if is_point { Vec3::new(x, y, z) / w } else { Vec3::ZERO };
        let forward = if is_point { place.clamp(low, high) - place } else { -Vec3::new(x, y, z) };
        let size = forward.abs().max_element();
        let slack = 4e-6 * low.abs().max(high.abs()).max(place.abs());
        if is_point && size <= 4.0 * slack.max_element() {
            return None;
        }
        let forward = forward / size;
        let a = forward.abs();
        let aside = if a.y <= a.x && a.y <= a.z {
            Vec3::new(-forward.z, 0.0, forward.x)
        } else if a.z <= a.x {
            Vec3::new(forward.y, -forward.x, 0.0)
        } else {
            Vec3::new(0.0, forward.z, -forward.y)
        };
        Some(Self { forward, aside, place, is_point })
    }

    fn half_plane(&self, position: Vec3) -> f32 {
        let d = position - self.place;
        let dot = |a: Vec3| a.x * d.x + a.y * d.y + a.z * d.z;
        dot(self.aside) / if self.is_point { dot(self.forward) } else { 1.0 }
    }
}
