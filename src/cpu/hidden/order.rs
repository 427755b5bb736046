//! The order in which faces are taken: about front to back. Any order is right.

use super::tree::Face;
use crate::light::Light;

/// Steps of distance, within which larger faces come first.
const STEPS: f64 = 64.0;

/// The numbers of the faces in their order.
pub(crate) fn order(faces: &[Face], light: Light) -> Vec<usize> {
    let near: Vec<f64> = faces.iter().map(|face| nearest(face, light)).collect();
    let finite = || near.iter().copied().filter(|distance| distance.is_finite());
    let (low, high) = finite().fold((f64::MAX, f64::MIN), |(low, high), d| (low.min(d), high.max(d)));
    // The conversion saturates, and takes what is no number to 0.
    let step = |distance: f64| (STEPS * (distance - low) / (high - low)) as u32;
    let mut keys: Vec<(u32, i32, u64, usize)> = faces
        .iter()
        .zip(near)
        .enumerate()
        .map(|(number, (face, distance))| (step(distance), size(face).saturating_neg(), mix(number as u64), number))
        .collect();
    keys.sort_unstable();
    keys.into_iter().map(|(.., number)| number).collect()
}

/// The distance of the corner next to the light, or a number that grows with it.
fn nearest(face: &Face, light: Light) -> f64 {
    let w = f64::from(light.w);
    let l = light.xyz.map(f64::from);
    let distance = |corner: [f32; 3]| {
        let corner = corner.map(f64::from);
        if w > 0.0 {
            (0..3).map(|axis| (corner[axis] - l[axis] / w).powi(2)).sum::<f64>().sqrt()
        } else {
            -(0..3).map(|axis| corner[axis] * l[axis]).sum::<f64>()
        }
    };
    face.corners.into_iter().map(distance).fold(f64::INFINITY, f64::min)
}

/// The power of two of the largest extent.
fn size(face: &Face) -> i32 {
    let [a, b, c] = face.corners.map(|corner| corner.map(f64::from));
    let extent = |from: [f64; 3], to: [f64; 3]| (0..3).map(|axis| (to[axis] - from[axis]).abs()).fold(0.0, f64::max);
    extent(a, b).max(extent(a, c)).log2() as i32
}

/// Neighbours in a mesh come at random, so that the tree stays flat.
fn mix(number: u64) -> u64 {
    let mixed = (number ^ number >> 31).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (mixed ^ mixed >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9)
}
