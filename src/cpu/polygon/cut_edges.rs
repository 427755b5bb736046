//! Cut edges: the border of what a twisted outline darkens, in pieces of its edges that are wound so that it adds up with
//! other volumes; NUMERICS.md, "Shadows of twisted polygons".

use super::edge_pair::Edge;
use super::outline::Outline;
use super::turn::turn;
use crate::cpu::common::double_sign::{cross, difference, dot, to_light};

/// Where a piece begins or ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PieceEnd {
    /// At the end of its edge.
    Corner,
    /// Where its edge crosses another as seen from the light. The other has an end of a piece there, too.
    Crossing {
        /// The other edge, by its place in the outline.
        edge: usize,
        /// How far along the piece's own edge, from 0 to 1. It is rounded.
        at: f64,
    },
}

/// A piece of an edge of an outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Its edge, by its place in the outline.
    pub edge: usize,
    /// Where it begins and ends along the edge.
    pub ends: [PieceEnd; 2],
    /// Whether it runs against its edge. Then darkness is on the edge's right, otherwise on its left.
    pub is_turned: bool,
}

/// The pieces of an outline's edges. Each has an odd number of `triangles` between the light and what is on its left, and
/// an even number on its right. `triangles` are those of the polygon: their boundary is the outline. No edges of the
/// outline overlap in space.
pub fn cut_edges(outline: &Outline, triangles: &[[[f32; 3]; 3]], light: [f32; 4]) -> Vec<Piece> {
    let edges = outline.edges();
    let mut pieces = Vec::new();
    for (index, &edge) in edges.iter().enumerate() {
        let others = edges.iter().enumerate().filter(|&(other, _)| other != index);
        let cutting = others.filter(|&(_, &other)| cuts(other, edge, light));
        let crossings = in_order(edges, index, &cutting.map(|(other, _)| other).collect::<Vec<_>>(), light);
        let crossing = |&other: &usize| PieceEnd::Crossing { edge: other, at: cut_at(edges[other], edge, light) };
        let ends: Vec<PieceEnd> = std::iter::once(PieceEnd::Corner)
            .chain(crossings.iter().map(crossing))
            .chain(std::iter::once(PieceEnd::Corner))
            .collect();
        // The last piece ends at the end of the edge, and each crossing exchanges the sides.
        let is_odd_at_end =
            triangles.iter().filter(|triangle| holds_left_of_end(triangle, edge, light)).count() % 2 != 0;
        for (piece, ends) in ends.windows(2).enumerate() {
            let is_odd = is_odd_at_end == (crossings.len() - piece).is_multiple_of(2);
            pieces.push(Piece { edge: index, ends: [ends[0], ends[1]], is_turned: !is_odd });
        }
    }
    pieces
}

/// Whether an edge `(c, d)` cuts an edge `(a, b)` between its ends as seen from the light. An end of `(c, d)` that lies on
/// `(a, b)` in space counts as on its right. So edges that begin or end there cut in pairs or not at all, except
/// where they pass from one side to the other.
fn cuts([c, d]: Edge, [a, b]: Edge, light: [f32; 4]) -> bool {
    let ends = [turn(c, d, a, light), turn(c, d, b, light)];
    if ends[0] * ends[1] >= 0 {
        return false;
    }
    let sides = [turn(a, b, c, light), turn(a, b, d, light)];
    // Not where it crosses the opposite directions. An end that lies on the other edge is no opposite.
    (sides[0] > 0) != (sides[1] > 0) && (sides.contains(&0) || sides[0] == ends[1])
}

/// With more cuts, those of an edge are ordered by how far along they are, which is rounded.
const MOST_ORDERED: usize = 256;

/// What cuts edge `e`, in order along it. By turns if their answers fit together, and else by rounded places.
fn in_order(edges: &[Edge], e: usize, cuts: &[usize], light: [f32; 4]) -> Vec<usize> {
    let ranked = |is_before: &dyn Fn(usize, usize) -> bool| -> Vec<(usize, usize)> {
        let rank = |i: usize| cuts.iter().filter(|&&j| j != i && is_before(j, i)).count();
        let mut ranked: Vec<_> = cuts.iter().map(|&i| (rank(i), i)).collect();
        ranked.sort_unstable();
        ranked
    };
    let at = |i: usize| cut_at(edges[i], edges[e], light);
    let mut found =
        if cuts.len() <= MOST_ORDERED { ranked(&|j, i| is_before(edges, [e, j, i], light)) } else { Vec::new() };
    if found.len() < cuts.len() || found.windows(2).any(|pair| pair[0].0 == pair[1].0) {
        found = ranked(&|j, i| at(j) < at(i) || at(j) == at(i) && j < i);
    }
    found.into_iter().map(|(_, i)| i).collect()
}

/// Whether edge `j` cuts edge `e` before edge `i` does. Turns decide where the one cut is on one side of the other edge.
/// Otherwise all three may cross each other. How far along the earliest of the three the others cut it decides for all
/// three.
fn is_before(edges: &[Edge], [e, j, i]: [usize; 3], light: [f32; 4]) -> bool {
    let side = |of: usize, point: [f32; 3]| turn(edges[of][0], edges[of][1], point, light);
    let sides = |of: usize, edge: usize| edges[edge].map(|end| side(of, end));
    let common = |[p, q]: [i32; 2]| if p * q < 0 { 0 } else { p + q };
    let end = edges[e][1];
    let (of_j, of_i) = (sides(i, j), sides(j, i));
    match (common(of_j).signum(), common(of_i).signum()) {
        (0, 0) => {}
        (0, sign) => return sign == side(j, end),
        (sign, _) => return sign != side(i, end),
    }
    let crosses = of_j[0] == of_i[1];
    let first = if crosses { e.min(i).min(j) } else { e };
    let at = |cutting: usize| cut_at(edges[cutting], edges[first], light);
    if first == e {
        return at(j) < at(i) || at(j) == at(i) && j < i;
    }
    let other = if first == i { j } else { i };
    let sense = if at(e) > at(other) { 1 } else { -1 } * side(e, edges[first][1]) * side(other, edges[first][1]);
    let turned = if first == i { -sense } else { sense };
    turned * side(i, end) * side(j, end) > 0
}

/// How far along `(a, b)` the plane through the light and `(c, d)` is.
fn cut_at([c, d]: Edge, [a, b]: Edge, [x, y, z, w]: [f32; 4]) -> f64 {
    let [a, b, c, d] = [a, b, c, d].map(|point| point.map(f64::from));
    let normal = cross(difference(d, c), to_light(c, [x, y, z].map(f64::from), f64::from(w)));
    let [from, to] = [a, b].map(|end| dot(normal, difference(end, c)));
    let at = from / (from - to);
    // The signs of both are exactly opposite, but here they are rounded, and the light has not moved.
    if at.is_nan() { 0.5 } else { at.clamp(0.0, 1.0) }
}

/// Whether the directions next to the end of an edge, a little before it and less to its left, run through a triangle.
fn holds_left_of_end(&[p, q, r]: &[[f32; 3]; 3], [a, b]: Edge, light: [f32; 4]) -> bool {
    let side = |p: [f32; 3], q: [f32; 3]| {
        let signs = [turn(p, q, b, light), turn(p, q, a, light)];
        // Both are 0 only if the lines are one in space. Then it is on the left of both, or on the right of one.
        signs.into_iter().find(|&sign| sign != 0).unwrap_or_else(|| if runs_alike([p, q], [a, b]) { 1 } else { -1 })
    };
    let whole = turn(p, q, r, light);
    whole != 0 && [(p, q), (q, r), (r, p)].into_iter().all(|(p, q)| side(p, q) == whole)
}

/// Whether two edges on one line have the same direction.
fn runs_alike([p, q]: Edge, [a, b]: Edge) -> bool {
    (0..3).any(|axis| p[axis] < q[axis] && a[axis] < b[axis] || p[axis] > q[axis] && a[axis] > b[axis])
}
