//! The contours of a depth map: depths as integers, marked edges, and the places where a contour crosses them.

use super::samples::{Key, Samples};
use crate::layout::ContourShape;

/// Cells along the side of a tile.
pub(crate) const TILE: i32 = 16;
/// Parts of a texel that places count.
pub(crate) const TEXEL: i32 = 256;
/// The nearest that a place may be to a sample.
pub(crate) const LEAST: i32 = TEXEL / 16;
/// Parts of the square of the last difference that a round surface may be off a conic.
const NEAR_CONIC: i32 = 8;
/// Units that the last difference before a rim has at least, and how many times what depths may be off by it is.
const LEAST_RISE: i32 = 1024;
const PRECISE: i32 = 16;
/// The distance of the far end of the device depths from the near end.
pub(crate) const RANGE: i32 = 1 << 29;
/// The distance of a sample that casts nothing.
pub const FAR: i32 = i32::MAX;
/// The corners of a cell in turn. Edge b lies between the corners b and b + 1. Walked over from within the cell, the first is on
/// the left.
pub(crate) const TURN: [[i32; 2]; 4] = [[0, 0], [1, 0], [1, 1], [0, 1]];
/// The steps over the edges of a cell.
pub(crate) const OUT: [[i32; 2]; 4] = [[0, -1], [1, 0], [0, 1], [-1, 0]];

/// A depth map and how its contours are found.
#[derive(Clone, Copy, Debug)]
pub struct Map<'a> {
    /// The samples.
    pub samples: &'a Samples<'a>,
    /// Thresholds and sizes of the contours.
    pub shape: &'a ContourShape,
}

/// An edge of the lattice: its first sample, and whether the second is below it, not to its right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// The first sample.
    pub at: [i32; 2],
    /// 0: the second is to the right. 1: below.
    pub axis: usize,
}

pub(crate) fn sum(a: [i32; 2], b: [i32; 2]) -> [i32; 2] {
    [a[0].wrapping_add(b[0]), a[1].wrapping_add(b[1])]
}

/// The edge of a cell.
pub(crate) fn edge_of_cell(cell: [i32; 2], bit: usize) -> Edge {
    let at = if bit == 1 || bit == 2 { sum(cell, OUT[bit]) } else { cell };
    Edge { at, axis: bit % 2 }
}

/// The smaller of two differences, 0 if they have different signs.
pub(crate) fn smaller(a: i32, b: i32) -> i32 {
    if (a ^ b) < 0 {
        0
    } else if a.abs() < b.abs() {
        a
    } else {
        b
    }
}

/// `a` times `parts` of 256, rounded down.
pub(crate) fn parts(a: i32, parts: i32) -> i32 {
    (a >> 8) * parts + (((a & 255) * parts) >> 8)
}

/// How a smooth surface bends towards a rim. The surface along a row is taken for a conic whose tangent at the rim is a ray of the
/// light: the square of the distance from the rim's depth is a quadratic polynomial.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Conic {
    /// The last difference, in eleven bits.
    pub(crate) u: i32,
    /// The rim's depth less that of the last sample, in the same units.
    pub(crate) y: i32,
    /// Differences of the squares, from the last sample on.
    pub(crate) first: i32,
    /// The one before.
    pub(crate) second: i32,
}

impl Map<'_> {
    /// The conic through a sample and the three before it, in the direction of a step. A fourth before it has to lie on it: but for
    /// a part of the square of the last difference.
    pub(crate) fn conic(&self, last: [i32; 2], step: [i32; 2], off: i32) -> Option<Conic> {
        let z = self.distance(last);
        let mut gone = [0; 5];
        for number in 1..5 {
            let own = self.distance(sum(last, step.map(|step| -(number as i32) * step)));
            if own == FAR || z - own <= gone[number - 1] {
                return None;
            }
            gone[number] = z - own;
        }
        if gone[1] < LEAST_RISE.max(PRECISE * self.precision(z).min(RANGE / PRECISE)) {
            return None;
        }
        // Eleven bits of the largest difference are enough.
        let shift = 21_u32.saturating_sub(gone[1].leading_zeros());
        let [_, u, of_two, of_three, of_four] = gone.map(|gone| gone >> shift);
        let [v, w, x] = [of_two - u, of_three - of_two, of_four - of_three];
        let bend = u - 2 * v + w;
        if v.max(w).max(x) > u || bend <= 0 {
            return None;
        }
        let rise = 4 * u * v + 2 * v * v - u * u - w * (2 * (u + v) + w);
        if rise < 0 || rise / bend > 16 * u {
            return None;
        }
        let y = rise / (2 * bend);
        let first = u * (2 * y + u);
        let second = v * (2 * (y + u) + v);
        let third = w * (2 * (y + u + v) + w);
        let fourth = x * (2 * (y + u + v + w) + x);
        ((fourth - 2 * third + second).abs() <= u * u / off).then_some(Conic { u, y, first, second })
    }

    /// Samples across and down on the lattice.
    pub fn lattice(&self) -> [i32; 2] {
        self.samples.shape.size.map(|texels| texels as i32 + 2)
    }

    /// The distance of a sample from the near plane.
    pub fn distance(&self, at: [i32; 2]) -> i32 {
        let Key::Steps(steps) = self.samples.at(at.map(|at| at as u32)) else { return FAR };
        let bits = self.samples.depth(steps).to_bits();
        let mantissa = (bits & 0x007f_ffff) | 0x0080_0000;
        let exponent = bits >> 23;
        let depth = match exponent {
            0 => 0,
            121.. => mantissa << (exponent - 121),
            _ => mantissa.checked_shr(121 - exponent).unwrap_or(0),
        } as i32;
        let distance = if self.samples.shape.is_reversed == 1 { RANGE - depth } else { depth };
        distance.min(RANGE - 1)
    }

    /// How far the surface at a sample goes away for each step in a direction, as told by the two samples on the other side.
    fn slope(&self, at: [i32; 2], step: [i32; 2]) -> i32 {
        let back = step.map(|step| -step);
        let own = self.distance(at);
        let first = self.distance(sum(at, back));
        let second = self.distance(sum(sum(at, back), back));
        if own == FAR || first == FAR || second == FAR { 0 } else { smaller(own - first, first - second) }
    }

    /// The slope to both sides that is smaller, 0 at a ridge or where a side is far.
    fn slope_between(&self, at: [i32; 2], step: [i32; 2]) -> i32 {
        let [before, own, after] = [sum(at, step.map(|step| -step)), at, sum(at, step)].map(|at| self.distance(at));
        if before == FAR || own == FAR || after == FAR { 0 } else { smaller(own - before, after - own).abs() }
    }

    /// The largest error of the depths of the map and of the eye, at a distance.
    pub(crate) fn precision(&self, own: i32) -> i32 {
        let depth = if self.samples.shape.is_reversed == 1 { RANGE - own } else { own };
        (((depth >> 10) * self.shape.share) >> 19) + self.shape.constant
    }

    /// The distance of a sample, moved away from the light.
    pub fn moved(&self, at: [i32; 2]) -> i32 {
        let own = self.distance(at);
        if own == FAR {
            return FAR;
        }
        let slope_bias = self.shape.slope_bias;
        let slopes = self.slope_between(at, [1, 0]) + self.slope_between(at, [0, 1]);
        let most = (RANGE - own) / 2;
        // It is cut off before it overflows.
        let of_slopes =
            if slopes >> 8 > (RANGE >> 1) / slope_bias.max(1) { RANGE >> 1 } else { parts(slopes, slope_bias) };
        own + (of_slopes + self.precision(own)).min(most)
    }

    /// Whether there is a jump between the samples of an edge, and not only a slope. One that is not sure must be twice as large
    /// as the differences beside it.
    pub fn is_marked(&self, edge: Edge) -> bool {
        let step = if edge.axis == 0 { [1, 0] } else { [0, 1] };
        let other = sum(edge.at, step);
        let [a, b] = [edge.at, other].map(|at| self.distance(at));
        if a == FAR || b == FAR {
            return a != b;
        }
        let threshold = self.shape.threshold;
        let object = |at: [i32; 2]| self.samples.object(at.map(|at| at as u32));
        if self.samples.shape.objects == 1 && object(edge.at) != object(other) {
            return true;
        }
        if (b - a).abs() <= threshold {
            return false;
        }
        // From the nearer sample to the farther one.
        let (near, away) = if b > a { (edge.at, step) } else { (other, step.map(|step| -step)) };
        let far = sum(near, away);
        let back = away.map(|away| -away);
        let jump = (b - a).abs();
        let before = match self.distance(sum(near, back)) {
            FAR => 0,
            first => a.min(b) - first,
        };
        let after = match self.distance(sum(far, away)) {
            FAR => FAR,
            second => second - a.max(b),
        };
        // Three samples of a plane.
        if [before, after].iter().any(|beside| (jump - beside).abs() <= threshold) {
            return false;
        }
        // A round surface bends away on its way to a rim, and rises still more there.
        if after > jump && self.conic(far, away, NEAR_CONIC).is_some() {
            return false;
        }
        let is_alone = before.max(after) / 2 < jump / 4;
        let slopes = self.slope(near, away).max(-self.slope(far, back));
        (jump > self.shape.sure || is_alone) && jump - slopes > threshold
    }
}
