//! The edge code of a cell: which of its edges are marked, how it is split, which of its triangles are drawn.

use super::samples::{Key, Samples};

/// The bits of an entry that number its cell.
pub const CELL_MASK: u32 = (1 << 29) - 1;
/// The cell is split from sample (1, 0) to (0, 1).
pub const SPLIT: u32 = 1 << 29;
/// The triangle at sample (0, 0) or, in a cell that is not split so, (1, 0) is drawn.
pub const FIRST_TRIANGLE: u32 = 1 << 30;
/// The other triangle is drawn.
pub const SECOND_TRIANGLE: u32 = 1 << 31;

/// Value of [`DepthMapShape::detector`](crate::layout::DepthMapShape::detector): every edge that is not far.
pub const EVERY_CELL: u32 = 1;
/// Value of [`DepthMapShape::detector`](crate::layout::DepthMapShape::detector): where depth jumps.
pub const JUMPS: u32 = 2;

/// A cell between the samples (0, 0), (1, 0), (0, 1) and (1, 1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Its place, which is that of its sample (0, 0).
    pub at: [u32; 2],
    /// Its edges at the top, right, bottom and left are marked.
    pub marked: [bool; 4],
    /// It is split from sample (1, 0) to (0, 1).
    pub is_split: bool,
}

/// Whether `large` is more than `small` + `threshold`, exactly. Each is the bits of a number from 0 to 1, none subnormal,
/// and `small` is at most `large`.
pub fn exceeds(large: u32, small: u32, threshold: u32) -> bool {
    if threshold >= large {
        return false;
    }
    // In units of 2⁻³² of the last place of `large`.
    let units = |bits: u32| {
        let mantissa = if bits == 0 { 0 } else { u64::from(bits & 0x007f_ffff | 0x0080_0000) };
        (mantissa << 32).checked_shr((large >> 23) - (bits >> 23)).unwrap_or(0)
    };
    units(large) > units(small) + units(threshold)
}

impl Cell {
    /// Reads the cell.
    pub fn of(samples: &Samples<'_>, number: u32) -> Self {
        let across = samples.shape.size[0] + 1;
        let at @ [x, y] = [number % across, number / across];
        let [a, b, c, d] = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]].map(|at| samples.at(at));
        let marked = [
            is_marked(samples, [x, y], [1, 0]),
            is_marked(samples, [x + 1, y], [0, 1]),
            is_marked(samples, [x, y + 1], [1, 0]),
            is_marked(samples, [x, y], [0, 1]),
        ];
        let distance = |p: Key, q: Key| p.code().abs_diff(q.code());
        Self { at, marked, is_split: distance(a, d) > distance(b, c) }
    }

    /// The corners of its two triangles, from its place. The diagonal is the last two corners of the first and the first and
    /// last of the second, or in a cell that is not split the first and last two.
    pub fn triangles(&self) -> [[[u32; 2]; 3]; 2] {
        if self.is_split {
            [[[0, 0], [1, 0], [0, 1]], [[1, 0], [1, 1], [0, 1]]]
        } else {
            [[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]]
        }
    }

    /// Which of the two triangles are drawn: those with a marked edge.
    pub fn is_drawn(&self) -> [bool; 2] {
        let [top, right, bottom, left] = self.marked;
        if self.is_split { [top || left, right || bottom] } else { [top || right, bottom || left] }
    }

    /// Its entry in a list.
    pub fn entry(&self, number: u32) -> u32 {
        let [first, second] = self.is_drawn();
        let bit = |is_set, bit| if is_set { bit } else { 0 };
        number | bit(self.is_split, SPLIT) | bit(first, FIRST_TRIANGLE) | bit(second, SECOND_TRIANGLE)
    }
}

/// Whether the edge from sample `first` to the one at `step` from it is marked.
fn is_marked(samples: &Samples<'_>, first: [u32; 2], step: [u32; 2]) -> bool {
    let next = |[x, y]: [u32; 2]| [x + step[0], y + step[1]];
    let second = next(first);
    let (Key::Steps(p), Key::Steps(q)) = (samples.at(first), samples.at(second)) else {
        return samples.at(first) != samples.at(second);
    };
    match samples.shape.detector {
        EVERY_CELL => true,
        JUMPS => {
            // A sample that is not far is not on the border of the lattice.
            let before = samples.at([first[0] - step[0], first[1] - step[1]]);
            is_jump(samples, before, [p, q], samples.at(next(second)))
        }
        _ => {
            let [p, q] = [p, q].map(|steps| samples.depth(steps).to_bits());
            exceeds(p.max(q), p.min(q), samples.shape.threshold)
        }
    }
}

/// Whether neither the line from `before` to p goes on to q, nor that from `after` to q goes on to p.
fn is_jump(samples: &Samples<'_>, before: Key, [p, q]: [u32; 2], after: Key) -> bool {
    // In units of 2⁻²⁹. The product is exact, and the conversion cuts off.
    let units = |steps: u32| (f64::from(samples.depth(steps)) * 536_870_912.0) as i64;
    let (p, q) = (units(p), units(q));
    let slack = i64::from(samples.shape.threshold) + (p.max(q) >> 20) + ((q - p).abs() >> 4);
    let is_line = |a: Key, b: i64, c: i64| match a {
        Key::Steps(a) => (units(a) - 2 * b + c).abs() <= slack,
        Key::Far => false,
    };
    (q - p).abs() > slack && !is_line(before, p, q) && !is_line(after, q, p)
}
