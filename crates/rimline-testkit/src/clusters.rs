//! Decisions by the bound of a cluster, in `f64`. docs/numerics/clusters.md, "Bound on planes".

use rimline::Light;
use rimline::internals::clusters::ClusterBound;
use rimline::internals::layout::LightBatch;

/// 2.5 units in the last place: the most that the rounding of `w·centre` in `f32` changes the height by.
pub const PRODUCT: f32 = 2.5 / 8_388_608.0;
/// The most that underflow of `f32` adds: 2⁻¹¹⁸.
pub const LEAST: f32 = f32::from_bits((127 - 118) << 23);

/// The height of the scaled light over the middle of the planes, and what it must exceed for `f32` to decide.
pub fn height_and_spread(bound: &ClusterBound, light: Light) -> [f64; 2] {
    let batch = LightBatch::new(&[light], 0, 3);
    let ([x, y, z, w], inexact_w) = (batch.lights[0].map(f64::from), f64::from(batch.inexact_w[0][0]));
    let (c, middle, half) = (bound.centre.map(f64::from), bound.middle.map(f64::from), bound.half.map(f64::from));
    let t = [x - w * c[0], y - w * c[1], z - w * c[2], w];
    let sizes = [t[0].abs(), t[1].abs(), t[2].abs(), w.abs().max(inexact_w)];
    let sum = |factors: [f64; 4], terms: [f64; 4]| (0..4).map(|at| factors[at] * terms[at]).sum::<f64>();
    let size: f64 = c.map(f64::abs).iter().sum();
    [sum(middle, t), sum(half, sizes) + f64::from(PRODUCT) * inexact_w * size + f64::from(LEAST)]
}

/// Whether all faces of the cluster face the light, or none does and it is in no face's plane. `None`: nothing is
/// known. Faces that name a vertex twice face no light.
pub fn whole(bound: &ClusterBound, light: Light) -> Option<bool> {
    let [height, spread] = height_and_spread(bound, light);
    match bound.kind {
        0 => None,
        1 => (height.abs() > spread).then_some(height > 0.0),
        2 => (height < -spread).then_some(false),
        _ => Some(false),
    }
}
