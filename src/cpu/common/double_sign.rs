//! Signs of determinants in `f64`, where they are certain. Products of two `f32` are exact, and nothing over- or
//! underflows.

/// More than 8 · 2⁻⁵³: the error of a determinant in `f64` relative to |u|₁ |v|₁ |t|₁, with the bound's own rounding.
pub(crate) const RELATIVE: f64 = 1e-15;

/// The sign of a determinant with the computed value `d`, of three vectors whose components are differences, each rounded
/// once. It is 0 if the sign is not certain.
pub(crate) fn certain_sign(d: f64, vectors: [[f64; 3]; 3]) -> i32 {
    let bound = vectors.into_iter().fold(RELATIVE, |bound, v| bound * sum_of_sizes(v));
    i32::from(d > bound) - i32::from(d < -bound)
}

pub(crate) fn sum_of_sizes(v: [f64; 3]) -> f64 {
    v[0].abs() + v[1].abs() + v[2].abs()
}

/// `l − w·a`, with each component rounded once.
pub(crate) fn to_light(a: [f64; 3], l: [f64; 3], w: f64) -> [f64; 3] {
    [0, 1, 2].map(|axis| l[axis] - w * a[axis])
}

pub(crate) fn difference(p: [f64; 3], q: [f64; 3]) -> [f64; 3] {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

pub(crate) fn cross(u: [f64; 3], v: [f64; 3]) -> [f64; 3] {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

pub(crate) fn dot(u: [f64; 3], v: [f64; 3]) -> f64 {
    u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
}
