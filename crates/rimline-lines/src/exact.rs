//! Signs and values of `det[b − a, p − a, l − w·a]`, for points `a`, `b`, `p` and the eye `(l, w)`. They say on which side
//! of the line from `a` to `b` the eye sees `p`. [`Plane`] and [`Height`] find them in `f64` with a bound of the error.
//! The functions `…_value` compute in integers, for where that bound leaves the sign or the accuracy open.

use std::array::from_fn;
use std::ops::{Add, Mul, Sub};

use num_bigint::BigInt;

use crate::view::{cross, dot};

/// More than 8 · 2⁻⁵³: the error of the determinant in `f64` relative to the product of the three vectors' sums of sizes.
const RELATIVE: f64 = 1e-15;
/// A value that is so many times its error has 30 bits.
const ACCURATE: f64 = (1_u64 << 30) as f64;
/// From the lowest to the highest bit of coordinates whose determinants fit an `i128`.
const WINDOW: i32 = 40;

/// The eye as `(l, w)`; `w` is 0 or 1.
pub(crate) type Eye = [f32; 4];

/// A determinant for the eye moved by `(ε, ε², ε³)`: the value of the lowest order in ε that is not 0. Beside it values of
/// higher orders are infinitely small.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Value {
    /// 0 for the eye as given, 1 to 3 for an axis, 4 if all that count are 0.
    order: u8,
    value: f64,
}

impl Value {
    pub(crate) const ZERO: Self = Self { order: 4, value: 0.0 };

    pub(crate) fn sign(self) -> i32 {
        i32::from(self.value > 0.0) - i32::from(self.value < 0.0)
    }

    /// The value without its order. Callers ask it of face values, which are of order 0, or 0.
    pub(crate) fn number(self) -> f64 {
        self.value
    }

    /// Where between this end (0) and the other (1) a linear function with opposite signs there is 0.
    pub(crate) fn crossing(self, other: Self) -> f64 {
        // An end of higher order is infinitely nearer to the 0.
        match self.order.cmp(&other.order) {
            std::cmp::Ordering::Less => 1.0,
            std::cmp::Ordering::Greater => 0.0,
            std::cmp::Ordering::Equal => self.value.abs() / (self.value.abs() + other.value.abs()),
        }
    }
}

/// The plane through an edge and the eye, or that of a face, with the error of what `f64` finds.
pub(crate) struct Plane {
    /// A point of the plane.
    at: [f64; 3],
    normal: [f64; 3],
    /// The error of a determinant divided by the sum of sizes of its third vector.
    unit_error: f64,
}

impl Plane {
    /// For `det[to − from, p − from, l − w·from]`.
    pub(crate) fn of_edge(from: [f32; 3], to: [f32; 3], [x, y, z, w]: Eye) -> Self {
        let at = from.map(f64::from);
        let towards = [x, y, z].map(f64::from);
        let towards = from_fn(|axis| towards[axis] - f64::from(w) * at[axis]);
        Self::new(at, towards, difference(to.map(f64::from), at))
    }

    /// For `det[b − a, c − a, p − a]`.
    pub(crate) fn of_face(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> Self {
        let at = a.map(f64::from);
        Self::new(at, difference(b.map(f64::from), at), difference(c.map(f64::from), at))
    }

    fn new(at: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Self {
        Self { at, normal: cross(u, v), unit_error: RELATIVE * sum_of_sizes(u) * sum_of_sizes(v) }
    }

    pub(crate) fn normal(&self) -> [f64; 3] {
        self.normal
    }

    /// The product of the sums of sizes of the vectors that span it.
    pub(crate) fn size(&self) -> f64 {
        self.unit_error / RELATIVE
    }

    /// The determinant at `p`, and a bound of its error.
    pub(crate) fn height(&self, p: [f64; 3]) -> Height {
        self.along(difference(p, self.at))
    }

    /// The determinant with a direction instead of `p − a`.
    pub(crate) fn along(&self, direction: [f64; 3]) -> Height {
        Height { value: dot(self.normal, direction), error: self.unit_error * sum_of_sizes(direction) }
    }
}

/// A determinant in `f64` and a bound of its error. It is the height of a point over a plane, times the length of the
/// plane's normal.
#[derive(Clone, Copy)]
pub(crate) struct Height {
    value: f64,
    error: f64,
}

impl Height {
    /// The height of the mean of two points, from theirs. The weights are off by a few units in the last place.
    pub(crate) fn mean(heights: [Self; 2], weights: [f64; 2]) -> Self {
        let [p, q] = [0, 1].map(|at| weights[at] * heights[at].value);
        let errors = weights[0] * heights[0].error + weights[1] * heights[1].error;
        Self { value: p + q, error: errors * (1.0 + 8.0 * RELATIVE) + 2.0 * RELATIVE * (p.abs() + q.abs()) }
    }

    /// Its sign, or 0 if it is not certain.
    pub(crate) fn certain_sign(self) -> i32 {
        i32::from(self.value > self.error) - i32::from(self.value < -self.error)
    }

    /// The value if it has 30 bits.
    pub(crate) fn accurate(self) -> Option<Value> {
        (self.value.abs() > ACCURATE * self.error).then_some(Value { order: 0, value: self.value })
    }

    /// The value if its sign is certain.
    pub(crate) fn certain(self) -> Option<Value> {
        (self.value.abs() > self.error).then_some(Value { order: 0, value: self.value })
    }
}

fn difference(p: [f64; 3], q: [f64; 3]) -> [f64; 3] {
    from_fn(|axis| p[axis] - q[axis])
}

pub(crate) fn sum_of_sizes(v: [f64; 3]) -> f64 {
    v[0].abs() + v[1].abs() + v[2].abs()
}

/// `det[b − a, p − a, l − w·a]`, rounded. Where it is 0, the value for the moved eye.
pub(crate) fn edge_value(a: [f32; 3], b: [f32; 3], p: [f32; 3], eye: Eye) -> Value {
    value(a, b, p, eye, true)
}

/// Whether a point lies in the plane through a line and the eye.
pub(crate) fn is_in_plane(a: [f32; 3], b: [f32; 3], p: [f32; 3], eye: Eye) -> bool {
    let height = Plane::of_edge(a, b, eye).height(p.map(f64::from));
    height.certain_sign() == 0 && value(a, b, p, eye, false).sign() == 0
}

/// `det[b − a, c − a, p − a]`, rounded: the height of `p` over a face. It does not depend on the eye, so 0 stays 0.
pub(crate) fn face_value(a: [f32; 3], b: [f32; 3], c: [f32; 3], p: [f32; 3]) -> Value {
    if [a, b, c].contains(&p) {
        return Value::ZERO;
    }
    value(a, b, c, [p[0], p[1], p[2], 1.0], false)
}

/// The sign of `det[b − a, c − a, l − w·a]`.
pub(crate) fn facing(a: [f32; 3], b: [f32; 3], c: [f32; 3], eye: Eye) -> i32 {
    value(a, b, c, eye, false).sign()
}

/// `det[b − a, c − a, l − w·a]`, rounded. `is_moved`: a 0 is replaced by the value for the moved eye.
fn value(a: [f32; 3], b: [f32; 3], c: [f32; 3], eye: Eye, is_moved: bool) -> Value {
    // Copies of a mesh ask for this most.
    if a == b || b == c || c == a {
        return Value::ZERO;
    }
    let is_point = eye[3] != 0.0;
    let units = Units::new(&[a, b, c], eye);
    if units.bits <= WINDOW {
        let values = determinants(&units.all([a, b, c], eye, fixed), is_point);
        first_of(|order| values[order], is_moved, &units, None)
    } else {
        let values = determinants(&units.all([a, b, c], eye, big), is_point);
        first_of(|order| values[order].clone(), is_moved, &units, None)
    }
}

/// The ends of an edge and the corners of a face that it pierces. The point of piercing is no `f32`: it is the mean of the
/// ends, each weighted with the height of the other over the face.
pub(crate) struct PiercePositions {
    pub(crate) edge: [[f32; 3]; 2],
    pub(crate) face: [[f32; 3]; 3],
}

impl PiercePositions {
    /// [`edge_value`] where the edge pierces the face.
    pub(crate) fn edge_value(&self, a: [f32; 3], b: [f32; 3], eye: Eye) -> Value {
        if self.edge == [a, b] || self.edge == [b, a] {
            return Value::ZERO;
        }
        // The third point varies below. Its coordinates are among the edge's.
        let units = self.units([a, b, a], eye);
        self.mean(|p| ([a, b, p], eye), true, &units)
    }

    /// [`face_value`] where the edge pierces the face.
    pub(crate) fn face_value(&self, a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> Value {
        let is_corner = |p: &[f32; 3]| [a, b, c].contains(p);
        if self.edge.iter().all(is_corner) || self.face.iter().all(is_corner) {
            return Value::ZERO;
        }
        let units = self.units([a, b, c], [0.0, 0.0, 0.0, 1.0]);
        self.mean(|[x, y, z]| ([a, b, c], [x, y, z, 1.0]), false, &units)
    }

    fn units(&self, [a, b, c]: [[f32; 3]; 3], eye: Eye) -> Units {
        let ([p, q], [d, e, f]) = (self.edge, self.face);
        Units::new(&[a, b, c, p, q, d, e, f], eye)
    }

    /// The value at the point of piercing, from those at the edge's ends. The weight of an end is the height of the other
    /// end over the face, without its sign. `of` has the points and the eye of a determinant for an end.
    fn mean(&self, of: impl Fn([f32; 3]) -> ([[f32; 3]; 3], Eye), is_moved: bool, units: &Units) -> Value {
        if units.bits <= WINDOW {
            self.mean_of_integers(of, is_moved, units, fixed)
        } else {
            self.mean_of_integers(of, is_moved, units, big)
        }
    }

    fn mean_of_integers<T: Integer + Into<BigInt>>(
        &self,
        of: impl Fn([f32; 3]) -> ([[f32; 3]; 3], Eye),
        is_moved: bool,
        units: &Units,
        integer: impl Fn(f32, i32) -> T,
    ) -> Value {
        let at_ends = self.edge.map(|end| {
            let (points, eye) = of(end);
            determinants(&units.all(points, eye, &integer), eye[3] != 0.0)
        });
        let heights = self.edge.map(|[x, y, z]| {
            // Here an end of the edge stands where the eye stands else, so it has the unit of points.
            let all = Units { far_low: units.low, ..*units }.all(self.face, [x, y, z, 1.0], &integer);
            let [height, ..] = determinants(&all, true);
            BigInt::from(height.into().into_parts().1)
        });
        let at_end = |end: usize, order: usize| -> BigInt { at_ends[end][order].clone().into() };
        let sum = |order: usize| at_end(0, order) * &heights[1] + at_end(1, order) * &heights[0];
        first_of(sum, is_moved, units, Some(&heights[0] + &heights[1]))
    }
}

/// Units in which coordinates are integers.
struct Units {
    /// Coordinates of points are multiples of `2^low`.
    low: i32,
    /// Coordinates of the eye are multiples of `2^far_low`. It differs from `low` only for an eye at infinity.
    far_low: i32,
    /// The most bits from a unit to the highest bit of its coordinates.
    bits: i32,
}

impl Units {
    fn new(points: &[[f32; 3]], [x, y, z, w]: Eye) -> Self {
        let far = [[x, y, z]];
        let near = points.as_flattened().iter().copied();
        if w == 0.0 {
            let ((low, high), (far_low, far_high)) = (window(near), window(far.into_iter().flatten()));
            return Self { low, far_low, bits: (high - low).max(far_high - far_low) };
        }
        let (low, high) = window(near.chain(far.into_iter().flatten()));
        Self { low, far_low: low, bits: high - low }
    }

    /// The coordinates of `a`, `b`, `c` and the eye as integers, three each. `integer` takes a coordinate and the exponent
    /// of its unit.
    fn all<T>(&self, [a, b, c]: [[f32; 3]; 3], [x, y, z, _]: Eye, integer: impl Fn(f32, i32) -> T) -> [T; 12] {
        let all = [a, b, c, [x, y, z]];
        from_fn(|at| integer(all[at / 3][at % 3], if at < 9 { self.low } else { self.far_low }))
    }
}

/// Integers in which determinants are exact.
pub(crate) trait Integer: Clone + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// The value times `2^exponent`, rounded to about half a unit in the last place; 0 only if the value is.
    fn rounded(&self, exponent: i32) -> f64;
}

impl Integer for i128 {
    fn rounded(&self, exponent: i32) -> f64 {
        *self as f64 * 2_f64.powi(exponent)
    }
}

impl Integer for BigInt {
    fn rounded(&self, exponent: i32) -> f64 {
        // The highest 100 bits.
        let dropped = self.bits().saturating_sub(100) as i32;
        i128::try_from(self >> dropped).unwrap_or(0) as f64 * 2_f64.powi(exponent + dropped)
    }
}

/// A determinant for each order of [`Value`]: `det[b − a, c − a, l − w·a]`, then those with an axis as the third vector.
/// `all` has the coordinates of a, b, c and l.
fn determinants<T: Integer>(all: &[T; 12], is_point: bool) -> [T; 4] {
    let minus = |at: usize| -> [T; 3] { from_fn(|axis| all[at + axis].clone() - all[axis].clone()) };
    let towards = if is_point { minus(9) } else { from_fn(|axis| all[9 + axis].clone()) };
    let ([nx, ny, nz], [x, y, z]) = (integer_cross(&minus(3), &minus(6)), towards);
    [nx.clone() * x + ny.clone() * y + nz.clone() * z, nx, ny, nz]
}

/// The first of the determinants, `of` an order, that is not 0. `divisor`: they are sums weighted with heights over a face, to
/// be divided by the sum of the weights.
fn first_of<T: Integer>(of: impl Fn(usize) -> T, is_moved: bool, units: &Units, divisor: Option<T>) -> Value {
    // A height over a face is a product of three coordinates, and has the cube of their unit.
    let (weight_exponent, divisor) =
        divisor.map_or((0, 1.0), |divisor| (3 * units.low, divisor.rounded(3 * units.low)));
    for order in 0..if is_moved { 4 } else { 1_u8 } {
        // Two vectors between points, and as the third the eye or, in higher orders, an axis, which has no unit.
        let exponent = weight_exponent + 2 * units.low + if order == 0 { units.far_low } else { 0 };
        let value = of(order.into()).rounded(exponent) / divisor;
        if value != 0.0 {
            return Value { order, value };
        }
    }
    Value::ZERO
}

pub(crate) fn integer_cross<T: Integer>(u: &[T; 3], v: &[T; 3]) -> [T; 3] {
    let product = |i: usize, j: usize| u[i].clone() * v[j].clone();
    [product(1, 2) - product(2, 1), product(2, 0) - product(0, 2), product(0, 1) - product(1, 0)]
}

/// A finite float as an odd number or 0, times a power of two.
fn decode(value: f32) -> (i64, i32) {
    let bits = value.to_bits();
    let exponent = (bits >> 23 & 0xff) as i32;
    let mantissa = i64::from(bits & 0x007f_ffff | if exponent == 0 { 0 } else { 0x0080_0000 });
    let zeros = mantissa.trailing_zeros().min(23) as i32;
    let size = mantissa >> zeros;
    (if value < 0.0 { -size } else { size }, exponent.max(1) - 150 + zeros)
}

/// The exponents of the lowest bit, and of the one above the highest, of those numbers that are not 0. Without any, both are 0.
pub(crate) fn window(numbers: impl Iterator<Item = f32>) -> (i32, i32) {
    let decoded = numbers.map(decode).filter(|&(mantissa, _)| mantissa != 0);
    let ends =
        decoded.map(|(mantissa, exponent)| (exponent, exponent + 64 - mantissa.unsigned_abs().leading_zeros() as i32));
    ends.reduce(|one, other| (one.0.min(other.0), one.1.max(other.1))).unwrap_or((0, 0))
}

/// The number as a multiple of `2^low`, for `low` of a window of at most [`WINDOW`] bits that the number is in.
fn fixed(number: f32, low: i32) -> i128 {
    let (mantissa, exponent) = decode(number);
    i128::from(mantissa << (exponent - low).clamp(0, WINDOW))
}

/// The number as a multiple of `2^low`, for `low` of any window that the number is in.
pub(crate) fn big(number: f32, low: i32) -> BigInt {
    let (mantissa, exponent) = decode(number);
    BigInt::from(mantissa) << (exponent - low).max(0)
}
