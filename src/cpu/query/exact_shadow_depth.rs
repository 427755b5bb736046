//! Exact shadow depth: whether a face lies strictly between a point and a light, in integer arithmetic.

use crate::cpu::extract::exact_facing::ExactFace;

/// Lights along the axes. To break a tie, the light moves along each of them, by infinitely less each time.
const AXES: [[f32; 4]; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// Whether the face `(a, b, c)` lies strictly between the point `p` and the light `(l, w)`, with `w ≥ 0`. This means:
/// point and light are strictly on opposite sides of its plane, and the line between them goes through the inside of
/// the face after the light has moved by `(ε, ε², ε³)`; docs/numerics/query.md. The orientation of the face has no effect.
/// All numbers are finite.
pub(crate) fn exactly_between([a, b, c]: [[f32; 3]; 3], p: [f32; 3], light: [f32; 4]) -> bool {
    let [x, y, z] = p;
    let face = ExactFace::new(a, b, c);
    let point_side = face.sign([x, y, z, 1.0]);
    let light_side = face.sign(light);
    point_side * light_side < 0
        && [(a, b), (b, c), (c, a)].iter().all(|&(a, b)| edge_sign(a, b, p, light) == light_side)
}

/// The side on which the line from `p` to the light passes the edge's line. It is 0 only if `p` is on the edge's line.
fn edge_sign(a: [f32; 3], b: [f32; 3], p: [f32; 3], light: [f32; 4]) -> i32 {
    let plane = ExactFace::new(a, b, p);
    let signs = std::iter::once(light).chain(AXES).map(|light| plane.sign(light));
    signs.into_iter().find(|&sign| sign != 0).unwrap_or(0)
}
