//! Whether two faces meet at a crease, compared exactly with the cosine of an angle.

use num_bigint::BigInt;

use crate::exact::{big, integer_cross, window};
use crate::view::{cross, dot};

/// The corners of a triangle of a face.
type Corners = [[f32; 3]; 3];

/// An angle, by its cosine.
#[derive(Clone, Copy)]
pub(crate) struct Crease {
    cosine: f64,
}

impl Crease {
    pub(crate) const RIGHT_ANGLE: Self = Self { cosine: 0.0 };

    pub(crate) fn new(degrees: f64) -> Self {
        Self { cosine: libm::cos(degrees.to_radians()).next_up() }
    }

    /// Whether the normals of two faces are at least this angle apart. `is_turned` turns the second one. A face without
    /// an area makes no crease.
    pub(crate) fn is_between(
        self,
        first: impl Iterator<Item = Corners> + Clone,
        second: impl Iterator<Item = Corners> + Clone,
        is_turned: bool,
    ) -> bool {
        let turn = if is_turned { -1.0 } else { 1.0 };
        let ((n, n_size), (m, m_size)) = (normal(first.clone()), normal(second.clone()));
        let d = turn * dot(n, m);
        let difference = d * d.abs() - self.cosine * self.cosine.abs() * (dot(n, n) * dot(m, m));
        // The roundings of both sides are below fifty units in the last place of this product.
        let error = 1e-13 * (n_size * m_size) * (n_size * m_size);
        if difference.abs() > error && error > 1e-280 && difference.is_finite() {
            return difference < 0.0;
        }
        self.is_exactly_between(first, second, is_turned)
    }

    #[cold]
    fn is_exactly_between(
        self,
        first: impl Iterator<Item = Corners> + Clone,
        second: impl Iterator<Item = Corners> + Clone,
        is_turned: bool,
    ) -> bool {
        let (low, _) = window(first.clone().chain(second.clone()).flatten().flatten());
        let (n, m) = (exact_normal(first, low), exact_normal(second, low));
        let d = exact_dot(&n, &m) * if is_turned { -1 } else { 1 };
        let lengths = exact_dot(&n, &n) * exact_dot(&m, &m);
        if lengths == BigInt::ZERO {
            return false;
        }
        // No cosine of an `f64` is nearer to 0 than 2⁻⁵⁴, but for 0 itself, so it is a multiple of 2⁻¹²⁰.
        let cosine = (self.cosine * 2_f64.powi(120)) as i128;
        let squared = |value: BigInt| if value < BigInt::ZERO { -(&value * &value) } else { &value * &value };
        squared(d) << 240 <= squared(BigInt::from(cosine)) * lengths
    }
}

/// The sum of the triangles' normals, and that of their sizes.
fn normal(triangles: impl Iterator<Item = Corners>) -> ([f64; 3], f64) {
    triangles.fold(([0.0; 3], 0.0), |(sum, sizes), corners| {
        let [a, b, c] = corners.map(|corner| corner.map(f64::from));
        let [u, v] = [b, c].map(|corner| [0, 1, 2].map(|axis| corner[axis] - a[axis]));
        let n = cross(u, v);
        let size = |v: [f64; 3]| v[0].abs() + v[1].abs() + v[2].abs();
        ([0, 1, 2].map(|axis| sum[axis] + n[axis]), sizes + size(u) * size(v))
    })
}

fn exact_normal(triangles: impl Iterator<Item = Corners>, low: i32) -> [BigInt; 3] {
    triangles.fold([const { BigInt::ZERO }; 3], |sum, corners| {
        let [a, b, c] = corners.map(|corner| corner.map(|c| big(c, low)));
        let minus = |p: &[BigInt; 3]| [0, 1, 2].map(|axis| &p[axis] - &a[axis]);
        let n = integer_cross(&minus(&b), &minus(&c));
        [0, 1, 2].map(|axis| &sum[axis] + &n[axis])
    })
}

fn exact_dot(u: &[BigInt; 3], v: &[BigInt; 3]) -> BigInt {
    (0..3).map(|axis| &u[axis] * &v[axis]).sum()
}

#[cfg(test)]
mod tests {
    use std::iter::once;

    use super::*;

    /// The product of both normals' squares is beyond the range of `f64`.
    #[test]
    fn creases_of_huge_faces_are_decided_exactly() {
        let [a, b, c] = [[-3e38, -3e38, 0.0], [3e38, -3e38, 0.0], [-3e38, 3e38, 0.0_f32]];
        // 0.2° from a right angle.
        let d = [-3e38, -3e38 - 1.047e36, 3e38];
        let is_between = |degrees: f64| Crease::new(degrees).is_between(once([a, b, c]), once([b, a, d]), false);
        assert!(is_between(89.7) && !is_between(89.9));
    }
}
