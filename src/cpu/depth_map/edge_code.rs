//! The edge code of a cell: which of its edges are marked, how it is split, which of its triangles are drawn.

use super::depth_cube::CubeSample;
use super::samples::{Key, Samples};

/// The bits of an entry that number its cell.
pub const CELL_MASK: u32 = (1 << 29) - 1;
/// The cell is split from sample (1, 0) to (0, 1).
pub const SPLIT: u32 = 1 << 29;
/// The triangle at sample (0, 0) or, in a cell that is not split so, (1, 0) is drawn.
pub const FIRST_TRIANGLE: u32 = 1 << 30;
/// The other triangle is drawn.
pub const SECOND_TRIANGLE: u32 = 1 << 31;

/// A cell between the samples (0, 0), (1, 0), (0, 1) and (1, 1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Its place, which is that of its sample (0, 0).
    pub at: [u32; 2],
    /// Its edges at the top, right, bottom and left are marked.
    pub marked: [bool; 4],
    /// Its samples (0, 0), (1, 0), (0, 1) and (1, 1) have a depth and are at the end of a marked edge, within the cell or not.
    /// All are false where only edges of the cell matter.
    pub ends: [bool; 4],
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
        Self::at(samples, place_of_cell(samples, number))
    }

    /// Reads the cell whose sample (0, 0) is there.
    pub fn at(samples: &Samples<'_>, at: [u32; 2]) -> Self {
        let is_marked = |places: [[u32; 2]; 2]| is_marked(samples, places);
        let is_end = |[x, y]: [u32; 2]| {
            let beside = [[x + 1, y], [x, y + 1], [x.wrapping_sub(1), y], [x, y.wrapping_sub(1)]];
            samples.at([x, y]) != Key::Far && beside.into_iter().any(|other| is_marked([[x, y], other]))
        };
        Self::with(samples, at, is_marked, |at| samples.shape.spread == 1 && is_end(at))
    }

    /// The cell whose sample (0, 0) is there, whose edges are marked so. `is_end` tells of each corner whether triangles at it
    /// are drawn.
    pub(super) fn with(
        samples: &Samples<'_>,
        at @ [x, y]: [u32; 2],
        is_marked: impl Fn([[u32; 2]; 2]) -> bool,
        is_end: impl Fn([u32; 2]) -> bool,
    ) -> Self {
        let corners = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]];
        let [a, b, c, d] = corners.map(|at| samples.at(at));
        let marked = [(0, 1), (1, 3), (2, 3), (0, 2)].map(|(p, q)| is_marked([corners[p], corners[q]]));
        let distance = |p: Key, q: Key| p.code().abs_diff(q.code());
        let ends = corners.map(is_end);
        Self { at, marked, ends, is_split: distance(a, d) > distance(b, c) }
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

    /// Which of the two triangles are drawn: those with a marked edge, or a sample at the end of one.
    pub fn is_drawn(&self) -> [bool; 2] {
        let [top, right, bottom, left] = self.marked;
        let has_edge = if self.is_split { [top || left, right || bottom] } else { [top || right, bottom || left] };
        let [a, b, c, d] = self.ends;
        let has_end = if self.is_split { [a || b || c, b || c || d] } else { [a || b || d, a || c || d] };
        [0, 1].map(|number| has_edge[number] || has_end[number])
    }

    /// Its entry in a list.
    pub fn entry(&self, number: u32) -> u32 {
        let [first, second] = self.is_drawn();
        let bit = |is_set, bit| if is_set { bit } else { 0 };
        number | bit(self.is_split, SPLIT) | bit(first, FIRST_TRIANGLE) | bit(second, SECOND_TRIANGLE)
    }
}

pub(super) fn place_of_cell(samples: &Samples<'_>, number: u32) -> [u32; 2] {
    let side = samples.shape.size[0];
    if samples.shape.faces > 1 {
        let (across, face) = (side - 1, number / ((side - 1) * (side - 1)));
        let rest = number % (across * across);
        return CubeSample { face, at: [rest % across, rest / across] }.place(side);
    }
    [number % (side + 1), number / (side + 1)]
}

fn is_marked(samples: &Samples<'_>, places: [[u32; 2]; 2]) -> bool {
    match places.map(|place| samples.at(place)) {
        [Key::Far, Key::Far] => false,
        [Key::Steps(p), Key::Steps(q)] => {
            let [p, q] = [p, q].map(|steps| samples.depth(steps).to_bits());
            let [first, second] = places.map(|place| samples.object(place));
            samples.shape.every_cell == 1
                || samples.shape.objects == 1 && first != second
                || exceeds(p.max(q), p.min(q), samples.shape.threshold)
        }
        _ => true,
    }
}
