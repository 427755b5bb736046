//! Contour places: where on a marked edge the contour crosses it, from the run of edges that it crosses in a row.

use super::contour::{Edge, Map, OUT, TEXEL, edge_of_cell, sum};
use super::contour_marks::{code_of_cell, is_marked};

/// Cells that a run is followed along, to each side.
const REACH: i32 = 32;
/// Edges within which a run that turns to the same side at both ends leaves this side.
const RAMP: i32 = 4;
/// The nearest that a place may be to a sample.
pub(crate) const LEAST: i32 = TEXEL / 16;

/// Follows a run through its cells. Edges that it crosses further, and the place that it turns to: the first sample's, the
/// second's, or the middle.
fn followed(map: &Map<'_>, marks: &[u32], mut cell: [i32; 2], out: usize) -> (i32, i32) {
    for crossed in 0..REACH {
        // The other edge of the cell.
        let others = code_of_cell(map, marks, cell) & !(1 << ((out + 2) % 4));
        if others != 1 << out {
            let [first, second] = if out % 2 == 1 { [0, 2] } else { [3, 1] };
            return match others {
                turn if turn == 1 << first => (crossed, 0),
                turn if turn == 1 << second => (crossed, TEXEL),
                _ => (crossed, TEXEL / 2),
            };
        }
        cell = sum(cell, OUT[out]);
    }
    (REACH, TEXEL / 2)
}

fn place(map: &Map<'_>, marks: &[u32], edge: Edge) -> i32 {
    // The cells to both sides: above and below, or to the left and right.
    let [before, after] = if edge.axis == 0 { [0, 2] } else { [3, 1] };
    let (index, start) = followed(map, marks, sum(edge.at, OUT[before]), before);
    let (rest, end) = followed(map, marks, edge.at, after);
    let count = index + rest + 1;
    let place = if start == end {
        let ramp = count.min(2 * RAMP);
        start + (TEXEL / 2 - start) * (2 * index.min(rest) + 1).min(ramp) / ramp
    } else {
        start + (end - start) * (2 * index + 1) / (2 * count)
    };
    place.clamp(LEAST, TEXEL - LEAST)
}

/// For each sample of the lattice the places on the edges to its right and below it, 16 bits each, in parts of 65,536 of a texel
/// from the sample. 0: not marked.
pub fn contour_places(map: &Map<'_>, marks: &[u32]) -> Vec<u32> {
    let [across, down] = map.lattice();
    let samples = (0..across * down).map(|sample| [sample % across, sample / across]);
    let of_edge = |edge| if is_marked(map, marks, edge) { (place(map, marks, edge) << 8) as u32 } else { 0 };
    samples.map(|at| of_edge(Edge { at, axis: 0 }) | (of_edge(Edge { at, axis: 1 }) << 16)).collect()
}

/// The place on an edge, in parts of 256 of a texel.
pub(crate) fn place_of(map: &Map<'_>, places: &[u32], edge: Edge) -> i32 {
    let [x, y] = edge.at;
    let word = places.get((y * map.lattice()[0] + x) as usize).copied().unwrap_or(0);
    (word >> (16 * edge.axis + 8) & 255) as i32
}

/// The place on the edge of a cell, as parts of 256 of a texel on the lattice.
pub(crate) fn point_of(map: &Map<'_>, places: &[u32], cell: [i32; 2], bit: usize) -> [i32; 2] {
    let edge = edge_of_cell(cell, bit);
    let mut point = edge.at.map(|at| at * TEXEL);
    point[edge.axis] += place_of(map, places, edge);
    point
}
