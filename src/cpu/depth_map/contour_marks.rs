//! Contour marks: which edges of the lattice a contour crosses.

use super::contour::{Edge, Map, sum};

/// Samples that a word has marks for.
const SAMPLES: usize = 16;

/// Marks: for each sample of the lattice two bits, for the edges to its right and below it, 16 samples a word. A row has words of
/// its own.
pub fn contour_marks(map: &Map<'_>) -> Vec<u32> {
    let [across, down] = map.lattice();
    let words = map.shape.words as usize;
    let mut marks = vec![0; words * down as usize];
    for (y, row) in (0..).zip(marks.chunks_mut(words.max(1))) {
        for x in 0..across {
            let at = [x, y];
            let right = x + 1 < across && map.is_marked(Edge { at, axis: 0 });
            let below = y + 1 < down && map.is_marked(Edge { at, axis: 1 });
            let bits = u32::from(right) | (u32::from(below) << 1);
            if let Some(word) = row.get_mut(x as usize / SAMPLES) {
                *word |= bits << (2 * (x as usize % SAMPLES));
            }
        }
    }
    marks
}

/// Whether an edge is marked.
pub(crate) fn is_marked(map: &Map<'_>, marks: &[u32], edge: Edge) -> bool {
    let [x, y] = edge.at.map(|at| at as usize);
    let word = marks.get(y * map.shape.words as usize + x / SAMPLES).copied().unwrap_or(0);
    word >> (2 * (x % SAMPLES) + edge.axis) & 1 == 1
}

/// Whether a contour crosses between a sample and the one before it, in the direction of a step.
pub(crate) fn is_marked_before(map: &Map<'_>, marks: &[u32], at: [i32; 2], step: [i32; 2]) -> bool {
    let before = sum(at, step.map(|step| -step));
    let first = [at[0].min(before[0]), at[1].min(before[1])];
    is_marked(map, marks, Edge { at: first, axis: usize::from(step[0] == 0) })
}

/// The edges of a cell that are marked: bits for top, right, bottom and left.
pub(crate) fn code_of_cell(map: &Map<'_>, marks: &[u32], cell: [i32; 2]) -> u32 {
    (0..4).map(|bit| u32::from(is_marked(map, marks, super::contour::edge_of_cell(cell, bit))) << bit).sum()
}
