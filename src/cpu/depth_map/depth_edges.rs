//! Depth edges: marks edges between samples, continues those that dangle, and decides about cells from the marks.

use super::depth_cells::{CellList, list_cells};
use super::edge_code::{Cell, place_of_cell};
use super::edge_marks::{EdgeMarks, STEPS};
use super::edge_rule::{Second, is_marked};
use super::samples::{Key, Samples};
use crate::layout::DepthEdgeRule;

/// How edges are found.
#[derive(Clone, Copy, Debug)]
pub struct EdgeDetector {
    /// Thresholds.
    pub rule: DepthEdgeRule,
    /// How second differences decide.
    pub second: Second,
    /// Cells by which an edge that dangles is continued at most.
    pub cells: u32,
    /// A triangle is drawn if one of its samples is so many edges, less one, from the end of a marked edge.
    pub rings: u32,
}

/// Samples across and down.
fn lattice(samples: &Samples<'_>) -> [u32; 2] {
    let [width, height] = samples.shape.size;
    if samples.shape.faces > 1 { [3 * width, 2 * height] } else { [width + 2, height + 2] }
}

/// The sample so many steps from a place. Beside a map nothing casts.
fn key_along(samples: &Samples<'_>, at: [u32; 2], axis: usize, steps: i64) -> Key {
    let place = [0, 1].map(|other| i64::from(at[other]) + steps * i64::from(STEPS[axis][other]));
    let side = i64::from(samples.shape.size[0]);
    let is_outside = if samples.shape.faces > 1 {
        place[axis].div_euclid(side) != i64::from(at[axis]) / side
    } else {
        place[axis] < 0
    };
    if is_outside { Key::Far } else { samples.at(place.map(|place| place as u32)) }
}

/// The marks before any is continued: above the thresholds, or above those next to marked edges.
fn marks(samples: &Samples<'_>, detector: &EdgeDetector, level: usize) -> EdgeMarks {
    let side = samples.shape.size[0];
    EdgeMarks::new(lattice(samples), |at, axis| {
        if samples.shape.faces > 1 && at[axis] % side == side - 1 {
            return false;
        }
        let line = [-1, 0, 1, 2].map(|steps| key_along(samples, at, axis, steps));
        let next = [0, 1].map(|other| at[other] + STEPS[axis][other]);
        let is_same = samples.shape.objects == 0 || samples.object(at) == samples.object(next);
        let casts = line[1] != Key::Far && line[2] != Key::Far;
        casts && !is_same || is_marked(samples, &detector.rule, detector.second, line, level)
    })
}

/// Lists the cells of a map, with an object for each texel or none.
pub fn depth_edges(samples: &Samples<'_>, detector: &EdgeDetector) -> CellList {
    let mut edges = marks(samples, detector, 0);
    if detector.cells > 0 {
        let faint = marks(samples, detector, 1);
        for _ in 0..detector.cells {
            let next = EdgeMarks::new(lattice(samples), |at, axis| {
                // The cell above the edge, or on its left.
                let other = [0, 1].map(|place| at[place].wrapping_sub(STEPS[1 - axis][place]));
                let continues = || edges.dangles(samples, at) || edges.dangles(samples, other);
                edges.at(at, axis) || faint.at(at, axis) && continues()
            });
            if next == edges {
                break;
            }
            edges = next;
        }
    }
    list_cells(samples.shape, |number| {
        let is_marked = |[a, b]: [[u32; 2]; 2]| edges.at(a, usize::from(a[0] == b[0]));
        let is_end = |at| edges.is_in_ring(samples, at, detector.rings);
        Cell::with(samples, place_of_cell(samples, number), is_marked, is_end)
    })
}
