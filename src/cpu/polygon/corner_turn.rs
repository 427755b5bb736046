//! Turn: whether three points turn counter-clockwise as seen from a light.

use crate::cpu::common::double_sign::{certain_sign, cross, difference, dot, to_light};
use crate::cpu::extract::exact_facing::{AXES, exact_facing};

/// The exact sign of `det[b − a, c − a, l − w·a]`, the facing of a triangle: 1 if it turns counter-clockwise as seen from
/// the light `(l, w)`. All numbers are finite.
pub(crate) fn turn_as_given(a: [f32; 3], b: [f32; 3], c: [f32; 3], light: [f32; 4]) -> i32 {
    let [x, y, z, w] = light.map(f64::from);
    let [from_a, from_b, from_c] = [a, b, c].map(|point| point.map(f64::from));
    let vectors = [difference(from_b, from_a), difference(from_c, from_a), to_light(from_a, [x, y, z], w)];
    let [u, v, t] = vectors;
    match certain_sign(dot(cross(u, v), t), vectors) {
        0 => exact_facing(a, b, c, light),
        sign => sign,
    }
}

/// The same for the light moved by `(ε, ε², ε³)`, as for occluder counts. It is 0 only if the points lie on a line.
pub(crate) fn turn(a: [f32; 3], b: [f32; 3], c: [f32; 3], light: [f32; 4]) -> i32 {
    if a == b || b == c || c == a {
        return 0;
    }
    match turn_as_given(a, b, c, light) {
        0 => AXES.into_iter().map(|axis| turn_as_given(a, b, c, axis)).find(|&sign| sign != 0).unwrap_or(0),
        sign => sign,
    }
}
