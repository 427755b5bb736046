//! Faces between a point of a line and the eye by brute force, written apart from `src/`: the eye is really moved, by a power of
//! two below all that comes up, and the crossing is a point in a plane. In big integers, but for faces that `f64` finds far from
//! the ray or far inside.

use num_bigint::BigInt;
use rimline_testkit::shadow_oracle::{Homogeneous, Triangle, scaled, sign};

/// A point, or a direction with w 0. Coordinates are multiplied by [`SCALE`]'s power of two.
pub(crate) struct Point(Homogeneous);

/// All finite numbers are multiples of 2⁻¹⁴⁹.
const SCALE: i32 = 149;
/// Shares of a line are multiples of 2⁻⁴⁰.
pub(crate) const SHARES: i64 = 1 << 40;

impl Point {
    /// A vertex.
    fn new(position: [f32; 3]) -> Self {
        Self(Homogeneous { xyz: position.map(|c| scaled(c, SCALE)), w: BigInt::from(1) })
    }

    /// At a share of the way from one point to another.
    pub(crate) fn between(Self(from): &Self, Self(to): &Self, share: i64) -> Self {
        let (before, beyond) = (&from.w * share, &to.w * (SHARES - share));
        let xyz = std::array::from_fn(|axis| &from.xyz[axis] * &beyond + &to.xyz[axis] * &before);
        Self(Homogeneous { xyz, w: &from.w * &to.w * SHARES })
    }

    /// At a share of the way from one vertex to another.
    pub(crate) fn on_edge([a, b]: [[f32; 3]; 2], share: i64) -> Self {
        Self::between(&Self::new(a), &Self::new(b), share)
    }

    /// The two points where the edges of a triangle cross the plane of another one; none if they do not.
    pub(crate) fn crossings(face: [[f32; 3]; 3], plane: [[f32; 3]; 3]) -> Vec<Self> {
        let plane = Triangle::new(plane.map(|at| Self::new(at).0.xyz)).expect("it has a normal");
        let corners = face.map(|at| Self::new(at).0);
        let heights = corners.each_ref().map(|corner| plane.height(corner));
        let pairs = [(0, 1), (1, 2), (2, 0)].into_iter();
        let pairs = pairs.filter(|&(i, j)| (sign(&heights[i]) < 0) != (sign(&heights[j]) < 0));
        let found = pairs.map(|(i, j)| {
            let [p, q] = [&heights[j], &heights[i]].map(size);
            let xyz = std::array::from_fn(|axis| &corners[i].xyz[axis] * &p + &corners[j].xyz[axis] * &q);
            Self(Homogeneous { xyz, w: p + q })
        });
        found.collect()
    }

    /// Rounded.
    pub(crate) fn double(&self) -> [f64; 3] {
        let unit = BigInt::from(1) << (SCALE + 60);
        self.0.xyz.clone().map(|c| {
            // Sixty bits behind the point are enough for models of about unit size.
            let value: BigInt = (c << 120_u32) / (&self.0.w * &unit);
            i128::try_from(value).map_or(f64::NAN, |value| value as f64 / (1_u64 << 60) as f64)
        })
    }
}

fn size(value: &BigInt) -> BigInt {
    BigInt::from(value.magnitude().clone())
}

struct Face {
    exact: Triangle,
    /// The corners in `f64`.
    doubles: [[f64; 3]; 3],
    polygon: usize,
}

/// Faces, and an eye that looks at them.
pub(crate) struct Oracle {
    faces: Vec<Face>,
    eye: Homogeneous,
    moved: Homogeneous,
    doubles: [f64; 4],
}

impl Oracle {
    /// `polygons` names the polygon of each face. The eye is `(l, w)`, w 0 or 1.
    pub(crate) fn new(positions: &[[f32; 3]], faces: &[([u32; 3], usize)], eye: [f32; 4]) -> Self {
        let made = |&(face, polygon): &([u32; 3], usize)| {
            let corners = face.map(|v| positions[v as usize]);
            let exact = Triangle::new(corners.map(|at| Point::new(at).0.xyz))?;
            Some(Face { exact, doubles: corners.map(|corner| corner.map(f64::from)), polygon })
        };
        let faces: Vec<Face> = faces.iter().filter_map(made).collect();
        let [x, y, z, w] = eye;
        let eye = Homogeneous { w: BigInt::from(u8::from(w != 0.0)), ..Point::new([x, y, z]).0 };
        // A polynomial of a fourth degree in these numbers, and in a point whose numbers have seven times as many bits, has no root
        // below this power.
        let corners = faces.iter().flat_map(|face| face.exact.corners.as_flattened());
        let epsilon = 16 * (corners.chain(&eye.xyz).map(BigInt::bits).max().unwrap_or(0) + 64);
        let mut moved = eye.clone();
        moved.xyz.iter_mut().chain([&mut moved.w]).for_each(|c| *c <<= 3 * epsilon);
        for (axis, c) in moved.xyz.iter_mut().enumerate() {
            *c += BigInt::from(1) << ((2 - axis as u64) * epsilon);
        }
        Self { faces, eye, moved, doubles: [x, y, z, w].map(f64::from) }
    }

    /// The number of faces, or polygons, strictly between the eye and a point. With its `f64` position, this may decide what is far
    /// from doubt.
    pub(crate) fn count(&self, point: &Point, quick: Option<[f64; 3]>) -> u32 {
        let mut odd = std::collections::BTreeMap::new();
        for face in &self.faces {
            let quick = quick.and_then(|point| self.quick(face, point));
            if quick.unwrap_or_else(|| self.is_between(face, point)) {
                *odd.entry(face.polygon).or_insert(0) += 1;
            }
        }
        odd.values().map(|count| count % 2).sum()
    }

    fn is_between(&self, Face { exact, .. }: &Face, Point(point): &Point) -> bool {
        let (before, beyond) = (exact.height(point), exact.height(&self.moved));
        if sign(&exact.height(&self.eye)) == 0 || sign(&before) * sign(&beyond) >= 0 {
            return false;
        }
        let mix = |p: &BigInt, q: &BigInt| -> BigInt { p * size(&beyond) + q * size(&before) };
        let xyz = std::array::from_fn(|axis| mix(&point.xyz[axis], &self.moved.xyz[axis]));
        exact.holds(&Homogeneous { xyz, w: mix(&point.w, &self.moved.w) })
    }

    /// The answer of `f64` if nothing is near doubt, by where the ray crosses the plane.
    fn quick(&self, face: &Face, p: [f64; 3]) -> Option<bool> {
        let [x, y, z, w] = self.doubles;
        let [a, b, c] = face.doubles;
        let minus = |p: [f64; 3], q: [f64; 3]| [0, 1, 2].map(|axis| p[axis] - q[axis]);
        let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        let cross = |p: [f64; 3], q: [f64; 3]| {
            [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
        };
        let length = |p: [f64; 3]| dot(p, p).sqrt();
        let towards = [x - w * p[0], y - w * p[1], z - w * p[2]];
        let (u, v, from) = (minus(b, a), minus(c, a), minus(p, a));
        let n = cross(u, v);
        let slope = dot(towards, n) / (length(towards) * length(n));
        if slope.is_nan() || slope.abs() < 1e-3 || length(n) < 1e-3 * length(u) * length(v) {
            return None;
        }
        // The ray p + f·towards meets the plane at a + s·u + t·v.
        let f = -dot(from, n) / dot(towards, n);
        let end = if w == 0.0 { f64::INFINITY } else { 1.0 };
        let hit = minus([0, 1, 2].map(|axis| p[axis] + f * towards[axis]), a);
        let (s, t) = (dot(cross(hit, v), n) / dot(n, n), dot(cross(u, hit), n) / dot(n, n));
        let size = length(towards) / length(u).max(length(v));
        let margins = [s, t, 1.0 - s - t, f * size, (end - f) * size];
        let doubt = 1e-3 + 1e-9 * length(from) / length(u).min(length(v));
        if margins.iter().any(|&margin| margin < -doubt) {
            return Some(false);
        }
        margins.iter().all(|&margin| margin > doubt).then_some(true)
    }
}
