//! Bounds on the error of the `f32` determinant; docs/numerics/facing.md, "Filter".

/// Ten units in the last place: 10 · 2⁻²³.
pub const RELATIVE: f32 = 10.0 / 8_388_608.0;
/// The most that underflow adds: 2⁻¹¹⁵.
pub const UNDERFLOW: f32 = f32::from_bits((127 - 115) << 23);
/// A coordinate of 2⁴⁰ or more could overflow the determinant.
pub(crate) const LARGE: f32 = 1_099_511_627_776.0;

/// The most that underflow adds for a face whose coordinates are up to `largest`, for a light of size 1.
pub(crate) fn underflow_bound(largest: f32) -> f32 {
    let span = (2.0 * largest).max(1.0);
    UNDERFLOW * span * span
}

/// One bound for all lights of a batch: a factor of |u|₁ |v|₁ and a term that is added. `largest` bounds the
/// coordinates. `magnitudes` is the largest |x|, |y| or |z| of the lights, and their largest |w| or `inexact_w`.
pub(crate) fn face_bound(largest: f32, magnitudes: [f32; 2]) -> (f32, f32) {
    let to_light = magnitudes[0] + largest * magnitudes[1];
    (RELATIVE * to_light, underflow_bound(largest) * (1.0 + to_light))
}
