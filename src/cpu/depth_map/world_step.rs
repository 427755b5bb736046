//! Whether two depths of a perspective map are farther from each other than a distance in world units, exactly.

use std::cmp::Ordering;

/// An integer, lowest word first, in units of 2⁻¹⁴⁹ or their square.
pub(super) type Wide = [u32; 16];

/// The absolute value of a float that is 0 or normal.
pub(super) fn wide(value: f32) -> Wide {
    let bits = value.to_bits() & 0x7fff_ffff;
    let mut result = [0; 16];
    if bits != 0 {
        let places = (bits >> 23) - 1;
        let moved = u64::from(bits & 0x007f_ffff | 0x0080_0000) << (places % 32);
        let at = (places / 32) as usize;
        (result[at], result[at + 1]) = (moved as u32, (moved >> 32) as u32);
    }
    result
}

pub(super) fn order(a: &Wide, b: &Wide) -> Ordering {
    a.iter().rev().cmp(b.iter().rev())
}

pub(super) fn sum(a: &Wide, b: &Wide) -> Wide {
    let mut carry = 0;
    std::array::from_fn(|at| {
        carry += u64::from(a[at]) + u64::from(b[at]);
        let word = carry as u32;
        carry >>= 32;
        word
    })
}

pub(super) fn distance(a: &Wide, b: &Wide) -> Wide {
    let (large, small) = if order(a, b).is_lt() { (b, a) } else { (a, b) };
    let mut borrow = 0;
    std::array::from_fn(|at| {
        borrow += i64::from(large[at]) - i64::from(small[at]);
        let word = borrow as u32;
        borrow >>= 32;
        word
    })
}

/// Words beyond the last are 0 for what is multiplied here.
pub(super) fn product(a: &Wide, b: &Wide) -> Wide {
    let mut result = [0_u32; 16];
    for (i, &x) in a.iter().enumerate() {
        let mut carry = 0;
        for (word, &y) in result[i..].iter_mut().zip(b) {
            carry += u64::from(*word) + u64::from(x) * u64::from(y);
            *word = carry as u32;
            carry >>= 32;
        }
    }
    result
}

/// Whether `ratio` · |a − b| is more than |a − i| · |b − i|, with i = `at_infinity`. All are 0 or normal, `a` and `b` are from 0
/// to 1, and |i| is less than 2¹⁰.
pub fn world_step(a: f32, b: f32, ratio: f32, at_infinity: f32) -> bool {
    let infinity = wide(at_infinity);
    let [x, y] = [wide(a), wide(b)];
    let from_infinity =
        [&x, &y].map(|depth| if at_infinity < 0.0 { sum(depth, &infinity) } else { distance(depth, &infinity) });
    let step = product(&wide(ratio), &distance(&x, &y));
    order(&step, &product(&from_infinity[0], &from_infinity[1])).is_gt()
}
