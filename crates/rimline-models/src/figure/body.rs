//! The body's shape: tapered capsules, flattened where a body is, and their smooth union.

use glam::Vec3;

use super::skeleton::{
    CHEST, FOOT, HAND, HEAD, HIPS, LOWER_ARM, LOWER_LEG, NECK, SPINE, Side, TOES, UPPER_ARM, UPPER_LEG, on,
};

/// A capsule whose radius changes along its axis.
pub(super) struct Part {
    /// The joint that it moves with.
    pub joint: usize,
    ends: [Vec3; 2],
    radii: [f32; 2],
    /// Widths along the axes are the radii times these.
    widths: Vec3,
    /// How far the seam with what came before is rounded, in metres.
    blend: f32,
}

impl Part {
    /// Distance to the axis at `point`, and the radius there, in the part's own widths.
    fn axis(&self, point: Vec3) -> (f32, f32) {
        let [a, b] = self.ends.map(|end| end / self.widths);
        let (point, along) = (point / self.widths - a, b - a);
        let t = (point.dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
        let [from, to] = self.radii;
        ((point - along * t).length(), from + (to - from) * t)
    }

    /// Distance to the axis as a fraction of the radius: 1 on the part's surface.
    pub(super) fn relative_distance(&self, point: Vec3) -> f32 {
        let (distance, radius) = self.axis(point);
        distance / radius
    }

    fn distance(&self, point: Vec3) -> f32 {
        let (distance, radius) = self.axis(point);
        (distance - radius) * self.widths.min_element()
    }
}

/// Negative inside the body, positive outside, about a distance near the surface.
pub(super) fn field(parts: &[Part], point: Vec3) -> f32 {
    let body = parts.iter().fold(1.0, |distance, part| smooth_minimum(distance, part.distance(point), part.blend));
    // Soles are flat: nothing lies below the ground.
    -smooth_minimum(-body, point.y, 0.012)
}

/// The lesser of two, rounded by a parabola where they differ by less than `blend`.
fn smooth_minimum(a: f32, b: f32, blend: f32) -> f32 {
    let overlap = (blend - (a - b).abs()).max(0.0);
    a.min(b) - overlap * overlap / (4.0 * blend)
}

/// Joint, one end and its radius, the other end and its radius, widths, blend.
type Row = (usize, [f32; 3], f32, [f32; 3], f32, [f32; 3], f32);

const ROUND: [f32; 3] = [1.0; 3];

/// The trunk and the head.
#[rustfmt::skip]
const MIDDLE: [Row; 9] = [
    // Pelvis, waist, ribs.
    (HIPS, [-0.046, 0.945, 0.0], 0.108, [0.046, 0.945, 0.0], 0.108, [1.0, 1.0, 0.88], 0.02),
    (SPINE, [0.0, 1.0, 0.004], 0.132, [0.0, 1.13, 0.008], 0.117, [1.0, 1.0, 0.76], 0.03),
    (CHEST, [0.0, 1.13, 0.008], 0.117, [0.0, 1.31, -0.008], 0.154, [1.0, 1.0, 0.76], 0.012),
    // Breast, shoulder girdle, and the slope from it to the neck.
    (CHEST, [-0.062, 1.325, 0.05], 0.062, [0.062, 1.325, 0.05], 0.062, [1.0, 1.0, 0.8], 0.05),
    (CHEST, [-0.135, 1.395, -0.015], 0.062, [0.135, 1.395, -0.015], 0.062, ROUND, 0.05),
    (NECK, [0.0, 1.42, -0.02], 0.062, [0.0, 1.57, 0.0], 0.05, ROUND, 0.07),
    // Skull and jaw, and a hint of a nose, so that one sees which way it looks.
    (HEAD, [0.0, 1.665, -0.014], 0.102, [0.0, 1.655, 0.012], 0.098, [0.82, 0.94, 1.0], 0.02),
    (HEAD, [0.0, 1.625, 0.028], 0.08, [0.0, 1.574, 0.058], 0.044, [0.83, 1.0, 0.86], 0.06),
    (HEAD, [0.0, 1.67, 0.094], 0.008, [0.0, 1.632, 0.114], 0.012, ROUND, 0.03),
];

/// Arm and leg of the left side.
#[rustfmt::skip]
const LIMBS: [Row; 15] = [
    // Deltoid, upper arm, forearm with its belly near the elbow.
    (UPPER_ARM, [0.172, 1.4, -0.015], 0.057, [0.225, 1.337, -0.016], 0.048, ROUND, 0.03),
    (UPPER_ARM, [0.225, 1.337, -0.016], 0.048, [0.352, 1.185, -0.02], 0.036, ROUND, 0.008),
    (LOWER_ARM, [0.352, 1.185, -0.02], 0.036, [0.4, 1.128, -0.012], 0.038, ROUND, 0.012),
    (LOWER_ARM, [0.4, 1.128, -0.012], 0.038, [0.512, 0.994, 0.005], 0.026, ROUND, 0.008),
    // Palm, fingers held together, thumb.
    (HAND, [0.512, 0.994, 0.005], 0.027, [0.553, 0.945, 0.012], 0.04, [0.72, 0.86, 1.0], 0.012),
    (HAND, [0.553, 0.945, 0.012], 0.04, [0.597, 0.88, 0.028], 0.027, [0.62, 0.8, 1.0], 0.01),
    (HAND, [0.532, 0.966, 0.03], 0.017, [0.55, 0.92, 0.058], 0.014, ROUND, 0.025),
    // Seat.
    (HIPS, [0.062, 0.925, -0.045], 0.085, [0.07, 0.89, -0.035], 0.082, ROUND, 0.04),
    // Thigh, knee, shank, calf.
    (UPPER_LEG, [0.09, 0.89, 0.004], 0.087, [0.1, 0.5, 0.012], 0.05, ROUND, 0.03),
    (LOWER_LEG, [0.1, 0.5, 0.012], 0.05, [0.105, 0.1, -0.026], 0.033, ROUND, 0.01),
    (LOWER_LEG, [0.104, 0.4, -0.022], 0.042, [0.104, 0.3, -0.026], 0.038, ROUND, 0.05),
    // Ankle, heel, instep, ball, toes.
    (FOOT, [0.105, 0.1, -0.026], 0.034, [0.105, 0.042, -0.05], 0.04, ROUND, 0.012),
    (FOOT, [0.105, 0.08, -0.015], 0.036, [0.113, 0.034, 0.075], 0.04, [1.0, 0.9, 1.0], 0.03),
    (FOOT, [0.105, 0.03, -0.045], 0.037, [0.114, 0.026, 0.1], 0.044, [1.0, 0.75, 1.0], 0.02),
    (TOES, [0.114, 0.022, 0.1], 0.044, [0.118, 0.016, 0.155], 0.035, [1.0, 0.7, 1.0], 0.012),
];

/// All parts of the body.
pub(super) fn parts() -> Vec<Part> {
    let part = |side: Side, joint, &(_, a, from, b, to, widths, blend): &Row| Part {
        joint,
        ends: [a, b].map(|end| side.mirror(Vec3::from_array(end))),
        radii: [from, to],
        widths: Vec3::from_array(widths),
        blend,
    };
    let middle = MIDDLE.iter().map(|row| part(Side::Left, row.0, row));
    let limbs = LIMBS.iter().flat_map(|row| {
        Side::BOTH.map(|side| {
            let joint = if row.0 == HIPS { HIPS } else { on(side, row.0) };
            part(side, joint, row)
        })
    });
    middle.chain(limbs).collect()
}
