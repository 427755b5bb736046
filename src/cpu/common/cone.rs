//! The cones of spot lights. docs/numerics/scene.md, "Cones of lights".

use glam::Vec3;

use crate::layout::LightCone;

/// Sizes outside this range may overflow or underflow. The test then returns true.
const LARGEST: f32 = f32::from_bits((127 + 60) << 23);
const LEAST: f32 = f32::from_bits((127 - 30) << 23);
/// 512 units in the last place of the largest coordinate.
const SLACK: f32 = f32::from_bits((127 - 14) << 23);
/// How far the middle of a box is off the axis, squared, beside its distance.
const OFF: f32 = f32::from_bits((127 - 20) << 23);

fn dot(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// The part of a vector across the axis, at length 1.
fn across_axis(v: Vec3, axis: Vec3) -> Vec3 {
    let across = v - dot(v, axis) * axis;
    across / dot(across, across).sqrt()
}

/// Whether a box may have a place in the cone. It is never false for one that has. No term of the box's ends is above `terms`.
pub fn may_be_in_cone(cone: &LightCone, low: [f32; 3], high: [f32; 3], terms: f32) -> bool {
    let ([apex @ .., has_cone], [axis @ .., cosine]) = (cone.apex, cone.axis);
    let (apex, axis, low, high) = (Vec3::from(apex), Vec3::from(axis), Vec3::from(low), Vec3::from(high));
    let size = low.abs().max(high.abs()).max(apex.abs()).max_element().max(terms);
    if has_cone == 0.0 || low.x > high.x || size.is_nan() || !(LEAST..LARGEST).contains(&size) {
        return true;
    }
    let (begin, end) = (low - apex, high - apex);
    if cosine < 0.0 {
        // The outside of a cone wider than a half-space is convex, so its corners decide for the box.
        let is_outside = |number: usize| {
            let pick = |axis: usize| if number >> axis & 1 == 0 { begin[axis] } else { end[axis] };
            let corner = Vec3::from([0, 1, 2].map(pick));
            dot(corner, axis) < cosine * dot(corner, corner).sqrt() - SLACK * size
        };
        return !(0..8).all(is_outside);
    }
    let middle = 0.5 * (begin + end);
    let (along, distance) = (dot(middle, axis), dot(middle, middle).sqrt());
    let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
    let off = middle - along * axis;
    let is_aside = dot(off, off) > OFF * dot(middle, middle);
    let any = if axis.x.abs() < 0.5 { Vec3::X } else { Vec3::Y };
    let guide = if is_aside { middle } else { any };
    let across = across_axis(across_axis(guide, axis), axis);
    let is_behind = along < -sine * distance;
    let normal = if is_behind { middle / distance } else { cosine * across - sine * axis };
    let least = (normal * begin).min(normal * end);
    let is_beyond = least.x + least.y + least.z > SLACK * size;
    !is_beyond
}
