//! The exact step of occluder counts: whether a face lies strictly between a point and a light, in integer arithmetic.
//! `shadow_depth` counts, and asks here only about faces that `f64` leaves undecided. The stage `exact_shadow_depth` makes
//! the same decisions on the GPU.

use crate::cpu::extract::exact_facing::{AXES, ExactFace};

/// Whether the face `(a, b, c)` lies strictly between the point `p` and the light `(l, w)`, with `w ≥ 0`. This means:
/// point and light are strictly on opposite sides of its plane, and the line between them goes through the inside of
/// the face after the light has moved by `(ε, ε², ε³)`; docs/numerics/query.md. The orientation of the face has no effect.
/// All numbers are finite. Only edges see the moved light: a point or light in the face's plane gives `false`.
pub(crate) fn exactly_between([a, b, c]: [[f32; 3]; 3], p: [f32; 3], light: [f32; 4]) -> bool {
    let [x, y, z] = p;
    let face = ExactFace::new(a, b, c);
    let point_side = face.sign([x, y, z, 1.0]);
    let light_side = face.sign(light);
    point_side * light_side < 0
        && [(a, b), (b, c), (c, a)].iter().all(|&(from, to)| edge_sign(from, to, p, light) == light_side)
}

/// The side on which the line from `p` to the moved light passes the edge's line: the sign of `det[b − a, p − a, l − w·a]`.
/// A line through the inside of a face has the sign of `light_side` at all three edges. The sign is 0 only if `p` is on
/// the edge's line.
fn edge_sign(a: [f32; 3], b: [f32; 3], p: [f32; 3], light: [f32; 4]) -> i32 {
    let edge_plane = ExactFace::new(a, b, p);
    let signs = std::iter::once(light).chain(AXES).map(|direction| edge_plane.sign(direction));
    signs.into_iter().find(|&sign| sign != 0).unwrap_or(0)
}
