//! Weld distances, and whether two points are at most so far apart; docs/numerics/welding.md.

use std::cmp::Ordering;

use crate::mesh::MeshError;

/// How far apart vertices may be that are welded: see [`Weld::Distance`](super::Weld::Distance).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WeldDistance {
    bits: u32,
    across_data: bool,
}

impl WeldDistance {
    /// A distance in the space of the positions. 0 joins vertices with equal positions, like
    /// [`Weld::Data`](super::Weld::Data) does.
    ///
    /// # Errors
    /// [`MeshError`] for a distance that is negative, infinite or NaN.
    pub fn new(distance: f32) -> Result<Self, MeshError> {
        if !(distance.is_finite() && distance >= 0.0) {
            return Err(MeshError::WeldDistance { distance });
        }
        Ok(Self { bits: super::bits(distance), across_data: false })
    }

    /// The same distance, where vertices are joined even if their skin or morph data differ. All of a group take the data
    /// of the vertex whose position they take.
    #[must_use]
    pub fn across_data(self) -> Self {
        Self { across_data: true, ..self }
    }

    /// The distance.
    pub fn get(self) -> f32 {
        f32::from_bits(self.bits)
    }

    /// Whether vertices are joined even if their skin or morph data differ.
    pub fn is_across_data(self) -> bool {
        self.across_data
    }

    /// Whether two finite points are at most so far apart, decided exactly.
    pub(crate) fn reaches(self, a: [f32; 3], b: [f32; 3]) -> bool {
        self.reaches_times(1, a, b)
    }

    /// Whether two finite points are at most a multiple of the distance apart, decided exactly. The factor is at most 1,000.
    pub(crate) fn reaches_times(self, times: u32, a: [f32; 3], b: [f32; 3]) -> bool {
        // Three subtractions, squares and sums are off by less than three epsilons, and the limit by two.
        const ERROR: f64 = 8.0 * f64::EPSILON;
        let squares = [0, 1, 2].map(|axis| (f64::from(a[axis]) - f64::from(b[axis])).powi(2));
        let square = squares[0] + squares[1] + squares[2];
        let limit = (f64::from(times) * f64::from(self.get())).powi(2);
        if square < limit * (1.0 - ERROR) {
            return true;
        }
        if square > limit * (1.0 + ERROR) {
            return false;
        }
        let squares = [0, 1, 2].map(|axis| squared(difference(a[axis], b[axis])));
        let square = squares.into_iter().fold([0; 10], sum);
        compare(&square, &squared(multiplied(magnitude(self.get()), times))) != Ordering::Greater
    }
}

/// An integer of multiples of 2⁻¹⁴⁹, lowest word first. Every sum of two finite floats takes 278 bits.
type Wide = [u64; 5];

/// The absolute value of a finite float.
fn magnitude(value: f32) -> Wide {
    let bits = value.to_bits();
    let exponent = bits >> 23 & 0xff;
    let implied = if exponent == 0 { 0 } else { 1 << 23 };
    let mantissa = bits & ((1 << 23) - 1) | implied;
    let shift = exponent.max(1) - 1;
    let shifted = u128::from(mantissa) << (shift % 64);
    let mut words = [0; 5];
    let low = words.iter_mut().skip(shift as usize / 64).zip([shifted as u64, (shifted >> 64) as u64]);
    low.for_each(|(word, value)| *word = value);
    words
}

/// |a − b|.
fn difference(a: f32, b: f32) -> Wide {
    let [x, y] = [a, b].map(magnitude);
    if a.is_sign_negative() != b.is_sign_negative() {
        return sum(x, y);
    }
    let (larger, smaller) = if compare(&x, &y) == Ordering::Less { (y, x) } else { (x, y) };
    let mut borrow = false;
    let mut result = [0; 5];
    for ((word, large), small) in result.iter_mut().zip(larger).zip(smaller) {
        let (first, below) = large.overflowing_sub(small);
        let (second, below_again) = first.overflowing_sub(u64::from(borrow));
        *word = second;
        borrow = below || below_again;
    }
    result
}

fn sum<const N: usize>(a: [u64; N], b: [u64; N]) -> [u64; N] {
    let mut carry = 0;
    let mut result = [0; N];
    for ((word, x), y) in result.iter_mut().zip(a).zip(b) {
        let all = u128::from(x) + u128::from(y) + carry;
        *word = all as u64;
        carry = all >> 64;
    }
    result
}

fn multiplied(a: Wide, times: u32) -> Wide {
    let mut carry = 0;
    a.map(|word| {
        let all = u128::from(word) * u128::from(times) + carry;
        carry = all >> 64;
        all as u64
    })
}

fn squared(a: Wide) -> [u64; 10] {
    let mut result = [0; 10];
    for (first, &x) in a.iter().enumerate() {
        let mut carry = 0;
        for (word, y) in result.iter_mut().skip(first).zip(a.into_iter().chain([0])) {
            let all = u128::from(x) * u128::from(y) + u128::from(*word) + carry;
            *word = all as u64;
            carry = all >> 64;
        }
    }
    result
}

fn compare<const N: usize>(a: &[u64; N], b: &[u64; N]) -> Ordering {
    a.iter().rev().cmp(b.iter().rev())
}
