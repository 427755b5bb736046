//! Faces between a point of a line and the eye by brute force, written apart from `src/`: the eye is really moved, by a power of
//! two below all that comes up, and the crossing is a point in a plane. In big integers, but for faces that `f64` finds far from
//! the ray or far inside.

use num_bigint::{BigInt, Sign};

type Vector = [BigInt; 3];

/// A finite number times `2^scale`, an integer.
fn scaled(value: f32, scale: i32) -> BigInt {
    let bits = value.abs().to_bits();
    let (exponent, fraction) = ((bits >> 23) as i32, bits & 0x7f_ffff);
    let (mantissa, exponent) = if exponent == 0 { (fraction, -149) } else { (fraction | 1 << 23, exponent - 150) };
    let size = BigInt::from(mantissa) << (exponent + scale);
    if value < 0.0 { -size } else { size }
}

fn sign(value: &BigInt) -> i32 {
    match value.sign() {
        Sign::Plus => 1,
        Sign::NoSign => 0,
        Sign::Minus => -1,
    }
}

/// A point `(xyz, w)`, w positive, or a direction with w 0. Coordinates are multiplied by [`SCALE`]'s power of two.
pub(crate) struct Point {
    xyz: Vector,
    w: BigInt,
}

/// All finite numbers are multiples of 2⁻¹⁴⁹.
const SCALE: i32 = 149;
/// Shares of a line are multiples of 2⁻⁴⁰.
pub(crate) const SHARES: i64 = 1 << 40;

impl Point {
    /// A vertex.
    fn new(position: [f32; 3]) -> Self {
        Self { xyz: position.map(|c| scaled(c, SCALE)), w: BigInt::from(1) }
    }

    /// At a share of the way from one point to another.
    pub(crate) fn between(from: &Self, to: &Self, share: i64) -> Self {
        let (before, beyond) = (&from.w * share, &to.w * (SHARES - share));
        let xyz = std::array::from_fn(|axis| &from.xyz[axis] * &beyond + &to.xyz[axis] * &before);
        Self { xyz, w: &from.w * &to.w * SHARES }
    }

    /// At a share of the way from one vertex to another.
    pub(crate) fn on_edge([a, b]: [[f32; 3]; 2], share: i64) -> Self {
        Self::between(&Self::new(a), &Self::new(b), share)
    }

    /// The two points where the edges of a triangle cross the plane of another one; none if they do not.
    pub(crate) fn crossings(face: [[f32; 3]; 3], plane: [[f32; 3]; 3]) -> Vec<Self> {
        let plane = Face::new(plane, 0).expect("it has a normal");
        let corners = face.map(Self::new);
        let heights = [0, 1, 2].map(|at| plane.height(&corners[at]));
        let pairs =
            [(0, 1), (1, 2), (2, 0)].into_iter().filter(|&(i, j)| (sign(&heights[i]) < 0) != (sign(&heights[j]) < 0));
        let found = pairs.map(|(i, j)| {
            let [p, q] = [&heights[j], &heights[i]].map(|height| BigInt::from(height.magnitude().clone()));
            let xyz = std::array::from_fn(|axis| &corners[i].xyz[axis] * &p + &corners[j].xyz[axis] * &q);
            Self { xyz, w: p + q }
        });
        found.collect()
    }

    /// Rounded.
    pub(crate) fn double(&self) -> [f64; 3] {
        let unit = BigInt::from(1) << (SCALE + 60);
        self.xyz.clone().map(|c| {
            // Sixty bits behind the point are enough for models of about unit size.
            let value: BigInt = (c << 120_u32) / (&self.w * &unit);
            i128::try_from(value).map_or(f64::NAN, |value| value as f64 / (1_u64 << 60) as f64)
        })
    }
}

struct Face {
    corners: [Vector; 3],
    normal: Vector,
    /// The same in `f64`.
    doubles: [[f64; 3]; 3],
    polygon: usize,
}

impl Face {
    /// `None` for a triangle that is a line.
    fn new(positions: [[f32; 3]; 3], polygon: usize) -> Option<Self> {
        let corners = positions.map(|position| Point::new(position).xyz);
        let minus = |at: usize| -> Vector { std::array::from_fn(|axis| &corners[at][axis] - &corners[0][axis]) };
        let (u, v) = (minus(1), minus(2));
        let normal: Vector = std::array::from_fn(|axis| {
            let (y, z) = ((axis + 1) % 3, (axis + 2) % 3);
            &u[y] * &v[z] - &u[z] * &v[y]
        });
        let doubles = positions.map(|position| position.map(f64::from));
        normal.iter().any(|n| sign(n) != 0).then_some(Self { corners, normal, doubles, polygon })
    }

    fn height(&self, point: &Point) -> BigInt {
        (0..3).map(|axis| &self.normal[axis] * (&point.xyz[axis] - &point.w * &self.corners[0][axis])).sum()
    }

    /// Whether a point of the plane with positive w is in the triangle.
    fn holds(&self, point: &Point) -> bool {
        let axis = (0..3).find(|&axis| sign(&self.normal[axis]) != 0).expect("it has a normal");
        let (y, z) = ((axis + 1) % 3, (axis + 2) % 3);
        (0..3).all(|at| {
            let (from, to) = (&self.corners[at], &self.corners[(at + 1) % 3]);
            let side = |axis: usize| &point.xyz[axis] - &point.w * &from[axis];
            let area = (&to[y] - &from[y]) * side(z) - (&to[z] - &from[z]) * side(y);
            sign(&area) * sign(&self.normal[axis]) >= 0
        })
    }
}

/// Faces, and an eye that looks at them.
pub(crate) struct Oracle {
    faces: Vec<Face>,
    eye: Point,
    moved: Point,
    doubles: [f64; 4],
}

impl Oracle {
    /// `polygons` names the polygon of each face. The eye is `(l, w)`, w 0 or 1.
    pub(crate) fn new(positions: &[[f32; 3]], faces: &[([u32; 3], usize)], eye: [f32; 4]) -> Self {
        let made = |&(face, polygon): &([u32; 3], usize)| Face::new(face.map(|v| positions[v as usize]), polygon);
        let faces: Vec<Face> = faces.iter().filter_map(made).collect();
        let [x, y, z, w] = eye;
        let eye = Point { w: BigInt::from(u8::from(w != 0.0)), ..Point::new([x, y, z]) };
        // A polynomial of a fourth degree in these numbers, and in a point whose numbers have seven times as many bits, has no root
        // below this power.
        let most = faces.iter().flat_map(|face| face.corners.as_flattened()).chain(&eye.xyz).map(BigInt::bits).max();
        let epsilon = 16 * (most.unwrap_or(0) + 64);
        let mut moved = Point { xyz: eye.xyz.clone().map(|c| c << (3 * epsilon)), w: eye.w.clone() << (3 * epsilon) };
        for (axis, c) in moved.xyz.iter_mut().enumerate() {
            *c += BigInt::from(1) << ((2 - axis as u64) * epsilon);
        }
        Self { faces, eye, moved, doubles: [x, y, z, w].map(f64::from) }
    }

    /// The number of faces, or polygons, strictly between the eye and a point. With its place in `f64`, this may decide what is far
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

    fn is_between(&self, face: &Face, point: &Point) -> bool {
        let (before, beyond) = (face.height(point), face.height(&self.moved));
        if sign(&face.height(&self.eye)) == 0 || sign(&before) * sign(&beyond) >= 0 {
            return false;
        }
        let [before, beyond] = [before, beyond].map(|height| BigInt::from(height.magnitude().clone()));
        let mix = |p: &BigInt, q: &BigInt| -> BigInt { p * &beyond + q * &before };
        let xyz = std::array::from_fn(|axis| mix(&point.xyz[axis], &self.moved.xyz[axis]));
        face.holds(&Point { xyz, w: mix(&point.w, &self.moved.w) })
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
