//! The sign of `det[b − a, c − a, l − w·a]` in fixed point, for faces and lights whose numbers lie in a window of bits.
//! The WGSL is in `wgsl/common/exact_sign.wgsl`. This code uses wider integers and so decides more lights.

use std::array::from_fn;

/// The largest number of bits from the lowest to the highest set bit of a face's nine coordinates, and of `l` and
/// `w·a`.
const FACE_BITS: i32 = 46;
const LIGHT_BITS: i32 = 96;

/// An odd number or zero, times a power of two. The value is `mantissa · 2^(exponent − 149)`.
#[derive(Clone, Copy)]
struct Number {
    mantissa: i64,
    exponent: i32,
}

impl Number {
    fn new(value: f32) -> Self {
        let bits = value.to_bits();
        let exponent = bits >> 23 & 0xff;
        let implied = if exponent == 0 { 0 } else { 0x0080_0000 };
        let mantissa = i64::from(bits & 0x007f_ffff | implied);
        let zeros = mantissa.trailing_zeros().min(23);
        let signed = if value.is_sign_negative() { -(mantissa >> zeros) } else { mantissa >> zeros };
        Self { mantissa: signed, exponent: exponent.max(1) as i32 - 1 + zeros as i32 }
    }

    fn times(self, other: Self) -> Self {
        Self { mantissa: self.mantissa * other.mantissa, exponent: self.exponent + other.exponent - 149 }
    }

    /// The number as a multiple of 2^(`lowest` − 149). No number of its window is below that.
    fn at(self, lowest: i32) -> i128 {
        i128::from(self.mantissa) << (self.exponent - lowest).clamp(0, LIGHT_BITS)
    }
}

/// The exponent of the lowest set bit, and one more than that of the highest. Both are 0 if all numbers are zero.
fn window(numbers: &[Number]) -> (i32, i32) {
    let set = numbers.iter().filter(|number| number.mantissa != 0);
    let ends = set.map(|number| {
        let length = 64 - number.mantissa.unsigned_abs().leading_zeros() as i32;
        (number.exponent, number.exponent + length)
    });
    ends.reduce(|(low, high), (other_low, other_high)| (low.min(other_low), high.max(other_high))).unwrap_or((0, 0))
}

/// The values that all lights of a face share.
pub(crate) struct FixedFace {
    a: [Number; 3],
    /// `(b − a) × (c − a)` as multiples of a power of two, below 2⁹⁵.
    normal: [i128; 3],
}

impl FixedFace {
    /// `None` if the coordinates do not fit the window.
    pub(crate) fn new(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> Option<Self> {
        let all: [Number; 9] = from_fn(|at| Number::new([a, b, c][at / 3][at % 3]));
        let (lowest, end) = window(&all);
        if end - lowest > FACE_BITS {
            return None;
        }
        // So few bits fit an i64, and one instruction multiplies two i64 to an i128.
        let at = |corner: usize| -> [i64; 3] {
            from_fn(|axis| {
                let number = all[3 * corner + axis];
                number.mantissa << (number.exponent - lowest).clamp(0, FACE_BITS)
            })
        };
        let [a, b, c] = [at(0), at(1), at(2)];
        let (u, v): ([i64; 3], [i64; 3]) = (from_fn(|axis| b[axis] - a[axis]), from_fn(|axis| c[axis] - a[axis]));
        let component = |j: usize, k: usize| product(u[j], v[k]) - product(u[k], v[j]);
        let normal = [component(1, 2), component(2, 0), component(0, 1)];
        Some(Self { a: from_fn(|axis| all[axis]), normal })
    }

    /// Returns 1, 0 or −1, or `None` if the light's numbers do not fit the window.
    pub(crate) fn sign(&self, [x, y, z, w]: [f32; 4]) -> Option<i32> {
        let (l, w) = ([x, y, z].map(Number::new), Number::new(w));
        let wa = self.a.map(|a| a.times(w));
        let [lx, ly, lz] = l;
        let [ax, ay, az] = wa;
        let (lowest, end) = window(&[lx, ly, lz, ax, ay, az]);
        if end - lowest > LIGHT_BITS {
            return None;
        }
        let mut sums = [0_i128; 3];
        for axis in 0..3 {
            let [n_low, n_high] = halves(self.normal[axis]);
            let [t_low, t_high] = halves(l[axis].at(lowest) - wa[axis].at(lowest));
            sums[0] += product(n_low, t_low);
            sums[1] += product(n_low, t_high) + product(n_high, t_low);
            sums[2] += product(n_high, t_high);
        }
        let second = sums[1] + (sums[0] >> 48);
        let top = sums[2] + (second >> 48);
        // Digits of 48 bits. The last has the sign.
        let below = (sums[0] | second) & ((1 << 48) - 1);
        Some(if top < 0 { -1 } else { i32::from(top > 0 || below != 0) })
    }
}

fn product(p: i64, q: i64) -> i128 {
    i128::from(p) * i128::from(q)
}

/// The lower 48 bits, and the bits above them with the sign.
fn halves(value: i128) -> [i64; 2] {
    [value as i64 & ((1 << 48) - 1), (value >> 48) as i64]
}
