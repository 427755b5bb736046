//! Contour places: where on a marked edge the contour crosses it. Near a smooth rim the depths beside the edge tell. Elsewhere the
//! run of the contour does: a line or a parabola through the edges that it crosses before and after.

use super::contour::{Edge, LEAST, Map, OUT, TEXEL, edge_of_cell, sum};
use super::contour_marks::{code_of_cell, is_marked};
use super::contour_rim::rim_beyond;

/// Edges that the contour is followed over to each side, for a line.
const REACH: usize = 12;
/// Edges to each side for a parabola, at most.
const BENT: usize = 8;
/// Edges to each side from which on a line is tried first.
const LINE: usize = 5;

/// An edge that the contour crosses: its middle from that of another edge, in half texels, and its axis.
type Crossed = ([i32; 2], usize);

/// Twice the middle of an edge.
fn doubled([edge_x, edge_y]: [i32; 2], axis: usize) -> [i32; 2] {
    [2 * edge_x + i32::from(axis == 0), 2 * edge_y + i32::from(axis == 1)]
}

/// Follows the contour from an edge out of a cell: the edges that it crosses.
fn followed(map: &Map<'_>, marks: &[u32], edge: Edge, mut cell: [i32; 2], out: usize) -> Vec<Crossed> {
    let origin = doubled(edge.at, edge.axis);
    let mut back = (out + 2) % 4;
    let mut crossed = Vec::new();
    while crossed.len() < REACH {
        let others = code_of_cell(map, marks, cell) & !(1 << back);
        if others.count_ones() != 1 {
            break;
        }
        let bit = others.trailing_zeros() as usize;
        let next = edge_of_cell(cell, bit);
        crossed.push((sum(doubled(next.at, next.axis), origin.map(|at| -at)), next.axis));
        cell = sum(cell, OUT[bit]);
        back = (bit + 2) % 4;
    }
    crossed
}

/// The place where a curve crosses the edge in the middle of some, in parts of a texel: a line or a parabola by least squares
/// through their middles. It has to cross each of them.
fn fitted(edges: &[Crossed], is_line: bool) -> Option<i32> {
    let count = (edges.len() / 2) as i32;
    let &(_, axis) = edges.get(edges.len() / 2)?;
    let numbered = || (-count..).zip(edges);
    let total = |power: u32| {
        let term = |(number, (place, _)): (i32, &Crossed)| place.map(|at| number.pow(power) * at);
        numbered().map(term).fold([0; 2], sum)
    };
    let [sums, firsts, seconds] = [0, 1, 2].map(total);
    let number = 2 * count + 1;
    let squares = count * (count + 1) * number / 3;
    let fourths = squares * (3 * count * (count + 1) - 1) / 5;
    let whole = number * fourths - squares * squares;
    let both = [0, 1];
    let middle = both.map(|c| {
        if is_line {
            sums[c] * (TEXEL / 2) / number
        } else {
            (fourths * sums[c] - squares * seconds[c]) * (TEXEL / 2) / whole
        }
    });
    // 64 times as fine.
    let bend = both.map(|c| if is_line { 0 } else { (number * seconds[c] - squares * sums[c]) * (TEXEL * 32) / whole });
    let way = firsts.map(|first| first * (TEXEL / 2) / squares);
    for (number, &(place, axis)) in numbered() {
        let off = both.map(|c| place[c] * (TEXEL / 2) - middle[c] - number * way[c] - number * number * bend[c] / 64);
        let along = both.map(|c| way[c] + number * bend[c] / 32);
        let over = along[1 - axis].abs();
        if over == 0 || (off[0] * along[1] - off[1] * along[0]).abs() > over * (TEXEL / 2) {
            return None;
        }
    }
    Some(TEXEL / 2 + middle[axis] - middle[1 - axis] * way[axis] / way[1 - axis])
}

/// The place that the run of the contour tells.
fn run_place(map: &Map<'_>, marks: &[u32], edge: Edge) -> i32 {
    // The cells to both sides: above and below, or to the left and right.
    let [before, after] = if edge.axis == 0 { [0, 2] } else { [3, 1] };
    let mut edges = followed(map, marks, edge, sum(edge.at, OUT[before]), before);
    let last = followed(map, marks, edge, edge.at, after);
    let most = edges.len().min(last.len());
    edges.truncate(most);
    edges.reverse();
    edges.push(([0; 2], edge.axis));
    edges.extend(last.iter().take(most));
    // First a line over all of them, then parabolas over fewer and fewer. Three edges have a line.
    let line = (most >= LINE).then_some((most, true));
    let tries = line.into_iter().chain((1..=most.min(BENT)).rev().map(|count| (count, count == 1)));
    let fit = |(count, is_line): (usize, bool)| fitted(edges.get(most - count..=most + count)?, is_line);
    tries.into_iter().find_map(fit).unwrap_or(TEXEL / 2)
}

fn place(map: &Map<'_>, marks: &[u32], edge: Edge) -> i32 {
    let step = if edge.axis == 0 { [1, 0] } else { [0, 1] };
    let other = sum(edge.at, step);
    // The surface that is nearer ends there.
    let rim = if map.distance(edge.at) < map.distance(other) {
        rim_beyond(map, marks, edge.at, step)
    } else {
        rim_beyond(map, marks, other, step.map(|step| -step)).map(|rim| TEXEL - rim)
    };
    rim.unwrap_or_else(|| run_place(map, marks, edge)).clamp(LEAST, TEXEL - LEAST)
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
