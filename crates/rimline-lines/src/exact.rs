//! Signs and values of `det[b − a, p − a, l − w·a]`, and what `f64` leaves undecided of them.

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

/// A determinant for the eye moved by `(ε, ε², ε³)`: the value of the first order in ε that is not 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Value {
    /// 0 for the eye as given, 1 to 3 for an axis, 4 if all are 0.
    order: u8,
    value: f64,
}

impl Value {
    pub(crate) const ZERO: Self = Self { order: 4, value: 0.0 };

    pub(crate) fn sign(self) -> i32 {
        i32::from(self.value > 0.0) - i32::from(self.value < 0.0)
    }

    /// Where between this end (0) and the other (1) a linear function with opposite signs there is 0.
    pub(crate) fn crossing(self, other: Self) -> f64 {
        match self.order.cmp(&other.order) {
            std::cmp::Ordering::Less => 1.0,
            std::cmp::Ordering::Greater => 0.0,
            std::cmp::Ordering::Equal => self.value.abs() / (self.value.abs() + other.value.abs()),
        }
    }
}

/// The plane through an edge and the eye, or that of a face, with the error of what `f64` finds.
pub(crate) struct Plane {
    at: [f64; 3],
    normal: [f64; 3],
    size: f64,
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
        Self { at, normal: cross(u, v), size: RELATIVE * sum_of_sizes(u) * sum_of_sizes(v) }
    }

    /// The determinant at `p`, and a bound of its error.
    pub(crate) fn height(&self, p: [f64; 3]) -> Height {
        self.along(difference(p, self.at))
    }

    /// The determinant with a direction in the place of `p − a`.
    pub(crate) fn along(&self, direction: [f64; 3]) -> Height {
        Height { value: dot(self.normal, direction), error: self.size * sum_of_sizes(direction) }
    }
}

/// A determinant in `f64`.
#[derive(Clone, Copy)]
pub(crate) struct Height {
    value: f64,
    error: f64,
}

impl Height {
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

fn sum_of_sizes(v: [f64; 3]) -> f64 {
    v[0].abs() + v[1].abs() + v[2].abs()
}

/// `det[b − a, p − a, l − w·a]`, rounded once; a 0 is broken by the moved eye.
pub(crate) fn edge_value(a: [f32; 3], b: [f32; 3], p: [f32; 3], eye: Eye) -> Value {
    value(a, b, p, eye, true)
}

/// Whether a point lies in the plane through a line and the eye.
pub(crate) fn is_in_plane(a: [f32; 3], b: [f32; 3], p: [f32; 3], eye: Eye) -> bool {
    let height = Plane::of_edge(a, b, eye).height(p.map(f64::from));
    height.certain_sign() == 0 && value(a, b, p, eye, false).sign() == 0
}

/// `det[b − a, c − a, p − a]`, rounded once.
pub(crate) fn face_value(a: [f32; 3], b: [f32; 3], c: [f32; 3], p: [f32; 3]) -> Value {
    value(a, b, c, [p[0], p[1], p[2], 1.0], false)
}

/// The sign of `det[b − a, c − a, l − w·a]`.
pub(crate) fn facing(a: [f32; 3], b: [f32; 3], c: [f32; 3], eye: Eye) -> i32 {
    value(a, b, c, eye, false).sign()
}

fn value(a: [f32; 3], b: [f32; 3], c: [f32; 3], eye: Eye, is_moved: bool) -> Value {
    let [x, y, z, w] = eye;
    let near: [f32; 12] = from_fn(|at| if at < 9 { [a, b, c][at / 3][at % 3] } else { [x, y, z][at % 3] });
    if w == 0.0 {
        let (low, high) = window(&near[..9]);
        let (far_low, far_high) = window(&near[9..]);
        return if high - low <= WINDOW && far_high - far_low <= WINDOW {
            let all = from_fn(|at| i128::from(fixed(near[at], if at < 9 { low } else { far_low })));
            of_integers(all, false, [low, far_low], is_moved)
        } else {
            let all = from_fn(|at| big(near[at], if at < 9 { low } else { far_low }));
            of_integers(all, false, [low, far_low], is_moved)
        };
    }
    let (low, high) = window(&near);
    if high - low <= WINDOW {
        of_integers(near.map(|c| i128::from(fixed(c, low))), true, [low; 2], is_moved)
    } else {
        of_integers(near.map(|c| big(c, low)), true, [low; 2], is_moved)
    }
}

/// Integers in which determinants are exact.
pub(crate) trait Integer: Clone + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// The value times `2^exponent`, rounded; 0 only if it is.
    fn rounded(&self, exponent: i32) -> f64;
}

impl Integer for i128 {
    fn rounded(&self, exponent: i32) -> f64 {
        *self as f64 * 2_f64.powi(exponent)
    }
}

impl Integer for BigInt {
    fn rounded(&self, exponent: i32) -> f64 {
        let above = self.bits().saturating_sub(100) as i32;
        i128::try_from(self >> above).unwrap_or(0) as f64 * 2_f64.powi(exponent + above)
    }
}

/// `all` are a, b, c and l. `exponents` are those of the units of points and of l.
fn of_integers<T: Integer>(all: [T; 12], is_point: bool, exponents: [i32; 2], is_moved: bool) -> Value {
    let minus = |at: usize| -> [T; 3] { from_fn(|axis| all[at + axis].clone() - all[axis].clone()) };
    let (u, v) = (minus(3), minus(6));
    let towards = if is_point { minus(9) } else { from_fn(|axis| all[9 + axis].clone()) };
    let normal = integer_cross(u, v);
    let [x, y, z] = from_fn(|axis| normal[axis].clone() * towards[axis].clone());
    let value = (x + y + z).rounded(2 * exponents[0] + exponents[1]);
    if value != 0.0 {
        return Value { order: 0, value };
    }
    if is_moved {
        let axes = (1..).zip(&normal).map(|(order, n)| Value { order, value: n.rounded(2 * exponents[0]) });
        return axes.into_iter().find(|found| found.value != 0.0).unwrap_or(Value::ZERO);
    }
    Value::ZERO
}

pub(crate) fn integer_cross<T: Integer>(u: [T; 3], v: [T; 3]) -> [T; 3] {
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

/// The exponents of the lowest bit, and of the one above the highest, of numbers that are not all 0.
pub(crate) fn window(numbers: &[f32]) -> (i32, i32) {
    let decoded = numbers.iter().map(|&number| decode(number)).filter(|&(mantissa, _)| mantissa != 0);
    let ends =
        decoded.map(|(mantissa, exponent)| (exponent, exponent + 64 - mantissa.unsigned_abs().leading_zeros() as i32));
    ends.reduce(|one, other| (one.0.min(other.0), one.1.max(other.1))).unwrap_or((0, 0))
}

/// The number as a multiple of `2^low`, which its window begins with.
fn fixed(number: f32, low: i32) -> i64 {
    let (mantissa, exponent) = decode(number);
    mantissa << (exponent - low).clamp(0, WINDOW)
}

pub(crate) fn big(number: f32, low: i32) -> BigInt {
    let (mantissa, exponent) = decode(number);
    BigInt::from(mantissa) << (exponent - low).max(0)
}
