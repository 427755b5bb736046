//! Marks of edges, and which of them dangle.

use super::samples::{Key, Samples};

/// The marks of a map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct EdgeMarks {
    /// Samples across and down.
    size: [u32; 2],
    /// For each sample, row by row, the edge to the one on its right, and that to the one below it.
    marks: Vec<[bool; 2]>,
}

/// The step to the right or down.
pub(super) const STEPS: [[u32; 2]; 2] = [[1, 0], [0, 1]];

impl EdgeMarks {
    pub(super) fn new(size: [u32; 2], is_marked: impl Fn([u32; 2], usize) -> bool) -> Self {
        let [width, height] = size;
        let places = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
        Self { size, marks: places.map(|at| [is_marked(at, 0), is_marked(at, 1)]).collect() }
    }

    /// The edge to the right of a sample (0) or below it (1).
    pub(super) fn at(&self, [x, y]: [u32; 2], axis: usize) -> bool {
        x < self.size[0] && self.marks.get((y * self.size[0] + x) as usize).is_some_and(|mark| mark[axis % 2])
    }

    /// Whether exactly one edge of the cell below and on the right of a sample is marked. A cube has no cells between two maps.
    pub(super) fn dangles(&self, samples: &Samples<'_>, at @ [x, y]: [u32; 2]) -> bool {
        let side = samples.shape.size[0];
        if samples.shape.faces > 1 && at.iter().any(|place| place.wrapping_add(1).is_multiple_of(side)) {
            return false;
        }
        let edges = [(at, 0), (at, 1), ([x, y.wrapping_add(1)], 0), ([x.wrapping_add(1), y], 1)];
        edges.into_iter().filter(|&(at, axis)| self.at(at, axis)).count() == 1
    }

    /// Whether an edge at a sample is marked, or the sample is on the border of a map of a cube, whose other maps may have one
    /// there.
    fn ends_at(&self, samples: &Samples<'_>, at @ [x, y]: [u32; 2]) -> bool {
        let side = samples.shape.size[0];
        let is_border = |place: u32| matches!(place % side, 0) || place % side == side - 1;
        samples.shape.faces > 1 && at.into_iter().any(is_border)
            || self.at(at, 0)
            || self.at(at, 1)
            || self.at([x.wrapping_sub(1), y], 0)
            || self.at([x, y.wrapping_sub(1)], 1)
    }

    /// Whether triangles at a sample are drawn for the marked edges near it.
    pub(super) fn is_in_ring(&self, samples: &Samples<'_>, at @ [x, y]: [u32; 2], rings: u32) -> bool {
        let beside = [[x + 1, y], [x, y + 1], [x.wrapping_sub(1), y], [x, y.wrapping_sub(1)]];
        let is_inside = |[x, y]: &[u32; 2]| *x < self.size[0] && *y < self.size[1];
        samples.at(at) != Key::Far
            && match rings {
                0 => false,
                1 => self.ends_at(samples, at),
                _ => {
                    self.ends_at(samples, at)
                        || beside.iter().filter(|at| is_inside(at)).any(|&at| self.ends_at(samples, at))
                }
            }
    }
}
