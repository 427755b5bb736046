//! The rule by which an edge between two samples is marked: from first differences, or from these and those beside them.

use std::cmp::Ordering;

use super::edge_code::exceeds;
use super::samples::{Key, Samples};
use crate::layout::DepthEdgeRule;

/// How second differences decide whether an edge above the threshold is marked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Second {
    /// Nothing: all edges above the threshold are marked.
    Nothing,
    /// An edge is marked whose difference is larger than both beside it.
    Both,
    /// One is marked whose difference is larger than one of them.
    One,
}

/// The samples before an edge, at its ends and after it.
pub(super) type Line = [Key; 4];

/// Bits of what the difference of two depths may be off by, of which `large` is the larger.
fn noise_at(rule: &DepthEdgeRule, large: f32) -> f32 {
    let bits = large.to_bits();
    let moved = bits.checked_sub(rule.noise_exponents << 23).filter(|&bits| bits >= f32::MIN_POSITIVE.to_bits());
    let share = moved.filter(|_| rule.noise_exponents > 0).map_or(0.0, f32::from_bits);
    share.max(f32::from_bits(rule.noise))
}

/// An integer, lowest word first, in units of 2⁻¹⁴⁹ or their square.
type Wide = [u32; 16];

/// The absolute value of a float that is 0 or normal.
fn wide(value: f32) -> Wide {
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

fn order(a: &Wide, b: &Wide) -> Ordering {
    a.iter().rev().cmp(b.iter().rev())
}

fn sum(a: &Wide, b: &Wide) -> Wide {
    let mut carry = 0;
    std::array::from_fn(|at| {
        carry += u64::from(a[at]) + u64::from(b[at]);
        let word = carry as u32;
        carry >>= 32;
        word
    })
}

fn distance(a: &Wide, b: &Wide) -> Wide {
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
fn product(a: &Wide, b: &Wide) -> Wide {
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

/// Whether the difference of two depths is larger than multiples of that of two others, and noise.
fn bends(rule: &DepthEdgeRule, ends: [f32; 2], beside: Option<[f32; 2]>, slopes: f32) -> bool {
    let noise = noise_at(rule, ends[0].max(ends[1]));
    // Integers only where numbers with twice as many bits are too near to each other.
    let rough = |[a, b]: [f32; 2]| (f64::from(a) - f64::from(b)).abs();
    let [step, most] = [rough(ends), f64::from(slopes) * beside.map_or(0.0, rough) + f64::from(noise)];
    if (step - most).abs() > 1e-12 * (step + most) {
        return step > most;
    }
    let width = |[a, b]: [f32; 2]| distance(&wide(a), &wide(b));
    let one = wide(1.0);
    let most = beside.map_or([0; 16], |beside| product(&wide(slopes), &width(beside)));
    order(&product(&one, &width(ends)), &sum(&most, &product(&one, &wide(noise)))).is_gt()
}

/// Whether an edge is marked. `level`: 1 next to the end of a marked edge.
pub(super) fn is_marked(samples: &Samples<'_>, rule: &DepthEdgeRule, second: Second, line: Line, level: usize) -> bool {
    let [before, Key::Steps(a), Key::Steps(b), after] = line else { return line[1] != line[2] };
    if a == b {
        return false;
    }
    let ends = [a, b].map(|steps| samples.depth(steps));
    let [small, large] = [ends[0].min(ends[1]), ends[0].max(ends[1])].map(f32::to_bits);
    let is_above = |threshold: u32| exceeds(large, small, threshold);
    // The step between two samples, if it goes the same way.
    let beside = |from: Key, to: Key| match (from, to) {
        (Key::Steps(p), Key::Steps(q)) if p.cmp(&q) == a.cmp(&b) => Some([p, q].map(|steps| samples.depth(steps))),
        _ => None,
    };
    let bends = |beside| bends(rule, ends, beside, f32::from_bits(rule.slopes[level]));
    let [before, after] = [beside(before, line[1]), beside(line[2], after)];
    is_above(rule.low[level])
        && match second {
            Second::Nothing => true,
            _ if is_above(rule.high) => true,
            Second::Both => bends(before) && bends(after),
            Second::One => bends(before) || bends(after),
        }
}
