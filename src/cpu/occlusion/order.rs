//! The order in which faces are searched: about front to back. Any order is right.

use glam::DVec3;

use super::tree::Face;
use crate::light::Light;

/// Steps of distance. Within a step, larger faces come first.
const STEPS: f64 = 64.0;

/// The indices of the faces in their order.
pub(crate) fn order(faces: &[Face], light: Light) -> Vec<usize> {
    let near: Vec<f64> = faces.iter().map(|face| nearest(face, light)).collect();
    let finite = || near.iter().copied().filter(|distance| distance.is_finite());
    let (low, high) = finite().fold((f64::MAX, f64::MIN), |(low, high), d| (low.min(d), high.max(d)));
    // The conversion saturates and maps NaN to 0.
    let step = |distance: f64| (STEPS * (distance - low) / (high - low)) as u32;
    let key = |(number, (face, distance)): (usize, (&Face, f64))| Key {
        step: step(distance),
        smallness: size(face).saturating_neg(),
        mixed: mix(number as u64),
        number,
    };
    let mut keys: Vec<Key> = faces.iter().zip(near).enumerate().map(key).collect();
    keys.sort_unstable();
    keys.into_iter().map(|key| key.number).collect()
}

/// Faces are sorted by these fields, in order.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    /// The step of its distance.
    step: u32,
    /// The negative [`size`].
    smallness: i32,
    /// Its index, mixed.
    mixed: u64,
    number: usize,
}

/// The distance of the face from the light, or a number that grows with it. The distance of the corners alone would put a
/// large wall behind the faces that it occludes.
fn nearest(face: &Face, light: Light) -> f64 {
    let (l, w) = (DVec3::from(light.xyz.map(f64::from)), f64::from(light.w));
    let corners = face.corners.map(|corner| DVec3::from(corner.map(f64::from)));
    if w > 0.0 {
        distance(corners.map(|corner| corner - l / w))
    } else {
        let towards = corners.map(|corner| -corner.dot(l));
        towards.into_iter().fold(f64::INFINITY, f64::min)
    }
}

/// The distance of a triangle from the origin.
fn distance([a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let is_within = [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| (to - from).cross(-from).dot(normal) >= 0.0);
    if is_within {
        return a.dot(normal.normalize_or_zero()).abs();
    }
    let to_edge = |(from, to): (DVec3, DVec3)| {
        let along = to - from;
        let part = (-from.dot(along) / along.length_squared()).clamp(0.0, 1.0);
        (from + part * along).length()
    };
    [(a, b), (b, c), (c, a)].into_iter().map(to_edge).fold(f64::INFINITY, f64::min)
}

/// The power of two of the largest extent.
fn size(face: &Face) -> i32 {
    let [a, b, c] = face.corners.map(|corner| corner.map(f64::from));
    let extent = |from: [f64; 3], to: [f64; 3]| (0..3).map(|axis| (to[axis] - from[axis]).abs()).fold(0.0, f64::max);
    extent(a, b).max(extent(a, c)).log2() as i32
}

/// A hash, so that neighbours in a mesh are far apart in the order and the tree stays flat.
fn mix(number: u64) -> u64 {
    let mixed = (number ^ number >> 31).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (mixed ^ mixed >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9)
}
