//! Exact facing: the sign of a face's determinant by integers, in fixed point where the numbers fit. Facing and occluder
//! counts ask for what their filters leave undecided. Polygons and occluded faces ask, too.

use crate::cpu::common::exact_sign::exact_sign;
use crate::cpu::common::fixed_sign::FixedFace;
use crate::cpu::common::positions::{is_finite, position};
use crate::layout::low_bits;
use crate::light::Light;
use crate::mesh::is_degenerate;

/// Lights along the axes. To break a tie, a light moves along each of them, by infinitely less each time.
pub(crate) const AXES: [[f32; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// The exact sign of `det[b − a, c − a, l − w·a]`: 1, 0 or −1. All numbers are finite. The light is `(l, w)`.
pub fn exact_facing(a: [f32; 3], b: [f32; 3], c: [f32; 3], light: [f32; 4]) -> i32 {
    ExactFace::new(a, b, c).sign(light)
}

/// The reference of the excluded masks that the stage `exact_facing` writes. For each face the lights for which it is
/// excluded: those in its plane, and all lights if it has a corner that is not finite, or that `positions` lacks. ⌈N/32⌉
/// planes of one `u32` a face, as facing masks are. Other faces that name a vertex twice have none. Lights are finite.
pub fn excluded(positions: &[[f32; 3]], faces: &[[u32; 3]], lights: &[Light]) -> Vec<u32> {
    let mask = |face: &[u32; 3], lights: &[Light]| {
        let [a, b, c] = face.map(|vertex| position(positions, vertex));
        if ![a, b, c].into_iter().all(is_finite) {
            return low_bits(lights.len());
        }
        if is_degenerate(*face) {
            return 0;
        }
        let exact = ExactFace::new(a, b, c);
        let bits = (0..).zip(lights).map(|(bit, light)| u32::from(exact.sign(light.to_array()) == 0) << bit);
        bits.fold(0, |mask, bit| mask | bit)
    };
    lights.chunks(32).flat_map(|lights| faces.iter().map(move |face| mask(face, lights))).collect()
}

/// A face, prepared for several lights.
pub(crate) struct ExactFace {
    corners: [[f32; 3]; 3],
    fixed: Option<FixedFace>,
}

impl ExactFace {
    pub(crate) fn new(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> Self {
        Self { corners: [a, b, c], fixed: FixedFace::new(a, b, c) }
    }

    /// Returns 1, 0 or −1.
    pub(crate) fn sign(&self, light: [f32; 4]) -> i32 {
        let [a, b, c] = self.corners;
        let fixed = self.fixed.as_ref().and_then(|face| face.sign(light));
        fixed.unwrap_or_else(|| exact_sign(a, b, c, light))
    }
}
