//! Exact facing: decides in integers what the filter leaves undecided, and in fixed point where the numbers fit.

use crate::cpu::common::exact_sign::exact_sign;
use crate::cpu::common::fixed_sign::FixedFace;

/// The exact sign of `det[b − a, c − a, l − w·a]`: 1, 0 or −1. All numbers are finite. The light is `(l, w)`.
pub fn exact_facing(a: [f32; 3], b: [f32; 3], c: [f32; 3], light: [f32; 4]) -> i32 {
    ExactFace::new(a, b, c).sign(light)
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
