//! Cut edges: the border of what a twisted outline darkens, in pieces of its edges that are wound so that it adds up with
//! other volumes; docs/numerics/twisted-polygons.md.

use super::edge_pair::Edge;
use super::outline::Outline;
use super::turn::{light_of_cut, turn, turn_as_given, turn_values};
use crate::cpu::common::double_sign::{cross, difference, dot, sum_of_sizes, to_light};
use crate::cpu::common::fixed_sign::holds_all;

/// Where a piece begins or ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PieceEnd {
    /// At the end of its edge.
    Corner,
    /// At the end of another edge, which is on its own in space.
    Touch([f32; 3]),
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

/// The pieces of an outline's edges. A point that they wind around has an odd number of `triangles` between it and the light.
/// Any other point has an even number. `triangles` are those of the polygon: their boundary is the outline. Where edges
/// overlap in space, their pieces cancel except for one, or all.
pub fn cut_edges(outline: &Outline, triangles: &[[[f32; 3]; 3]], light: [f32; 4]) -> Vec<Piece> {
    let edges = outline.edges();
    let of_edges = SeenEdges { edges, light, holds_turns: holds_all(edges.iter().map(|edge| edge[0]), light) };
    let mut pieces = Vec::new();
    for (index, &edge) in edges.iter().enumerate() {
        let others = edges.iter().enumerate().filter(|&(other, _)| other != index);
        let cutting = others.clone().filter_map(|(other, _)| cut(edges, index, other, light));
        let crossings = in_order(of_edges, index, &cutting.collect::<Vec<_>>());
        let crossing = |cut: &Cut| match cut.touch {
            Some(end) => PieceEnd::Touch(end),
            None => PieceEnd::Crossing { edge: cut.edge, at: cut_at(edges[cut.edge], edge, light) },
        };
        let ends: Vec<PieceEnd> = std::iter::once(PieceEnd::Corner)
            .chain(crossings.iter().map(crossing))
            .chain(std::iter::once(PieceEnd::Corner))
            .collect();
        // The last piece ends at the end of the edge, and each crossing exchanges the sides.
        let beyond = triangles.iter().filter(|triangle| holds_left_of_end(triangle, edge, light)).count();
        let between = others.filter(|&(other, _)| is_left_at_end(edges, index, other, light)).count();
        let is_odd_at_end = (beyond + between) % 2 != 0;
        for (piece, ends) in ends.windows(2).enumerate() {
            let is_odd = is_odd_at_end == (crossings.len() - piece).is_multiple_of(2);
            pieces.push(Piece { edge: index, ends: [ends[0], ends[1]], is_turned: !is_odd });
        }
    }
    pieces
}

/// The edges of an outline, and what sees them.
#[derive(Clone, Copy)]
struct SeenEdges<'a> {
    edges: &'a [Edge],
    light: [f32; 4],
    /// Fixed point holds all turns. If not, nothing tells where edges that are seen in line cut each other.
    holds_turns: bool,
}

/// Where an edge is cut by another.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cut {
    /// The other edge.
    edge: usize,
    /// The end of the other, if it is on the edge that is cut, in space.
    touch: Option<[f32; 3]>,
}

impl Cut {
    /// How far along edge `e` it is. It is rounded.
    fn along(&self, seen: SeenEdges<'_>, e: usize) -> f64 {
        let Some(touch) = self.touch else { return seen_cut_at(seen, self.edge, e).0 };
        let [a, b] = seen.edges[e].map(|end| end.map(f64::from));
        let axis = (0..3).max_by(|&i, &j| (b[i] - a[i]).abs().total_cmp(&(b[j] - a[j]).abs())).unwrap_or(0);
        (f64::from(touch[axis]) - a[axis]) / (b[axis] - a[axis])
    }
}

/// How edge `other` cuts edge `e` between its ends as seen from the light. Points on the line of `e` in space are taken as beside
/// it: on the right of the direction in which coordinates grow. So edges that begin or end there cut in pairs or not at all,
/// except where they pass from one side to the other. An edge that overlaps `e` is beside it, too, on the side that [`precedes`]
/// tells. If that is the other one, it cuts `e` where it ends.
fn cut(edges: &[Edge], e: usize, other: usize, light: [f32; 4]) -> Option<Cut> {
    let ([a, b], [c, d]) = (edges[e], edges[other]);
    let ends = [turn(c, d, a, light), turn(c, d, b, light)];
    let sides = [turn(a, b, c, light), turn(a, b, d, light)];
    if sides == [0, 0] {
        let ([low, high], [_, end]) = (in_space([a, b]), in_space([c, d]));
        let is_within = is_below(low, end) && is_below(end, high);
        return (is_within && precedes(edges, other, e)).then_some(Cut { edge: other, touch: Some(end) });
    }
    if ends[0] * ends[1] >= 0 {
        return None;
    }
    let is_left = |side: i32| if is_below(a, b) { side > 0 } else { side >= 0 };
    let touch = if sides[0] == 0 { Some(c) } else { (sides[1] == 0).then_some(d) };
    // Not where it crosses the opposite directions. An end that lies on the other edge is no opposite.
    (is_left(sides[0]) != is_left(sides[1]) && (touch.is_some() || sides[0] == ends[1]))
        .then_some(Cut { edge: other, touch })
}

/// Whether edge `other` overlaps edge `e` in space next to the end of `e`, on its left.
fn is_left_at_end(edges: &[Edge], e: usize, other: usize, light: [f32; 4]) -> bool {
    let ([a, b], [c, d]) = (edges[e], edges[other]);
    if turn(a, b, c, light) != 0 || turn(a, b, d, light) != 0 {
        return false;
    }
    let ([low, high], [from, to]) = (in_space([a, b]), in_space([c, d]));
    if is_below(a, b) {
        precedes(edges, other, e) && !is_below(to, high)
    } else {
        from == low && !precedes(edges, other, e)
    }
}

/// Whether one of two edges on a line is on the left of the other, seen in the direction in which coordinates grow: it begins
/// before it, or ends behind it.
fn precedes(edges: &[Edge], one: usize, other: usize) -> bool {
    let ([low, high], [from, to]) = (in_space(edges[one]), in_space(edges[other]));
    is_below(low, from) || low == from && (is_below(to, high) || high == to && one < other)
}

/// The ends of an edge in the direction in which coordinates grow.
fn in_space([a, b]: Edge) -> Edge {
    if is_below(a, b) { [a, b] } else { [b, a] }
}

/// Whether a point comes before another on a line, in the direction in which coordinates grow: the first that differs.
fn is_below(p: [f32; 3], q: [f32; 3]) -> bool {
    p.into_iter().zip(q).find(|(p, q)| p != q).is_some_and(|(p, q)| p < q)
}

/// With more cuts, those of an edge are ordered by how far along they are, which is rounded.
const MOST_ORDERED: usize = 256;

/// The cuts of edge `e`, in order along it. By turns if their answers fit together, and else by rounded places.
fn in_order(seen: SeenEdges<'_>, e: usize, cuts: &[Cut]) -> Vec<Cut> {
    let ranked = |is_before: &dyn Fn(&Cut, &Cut) -> bool| -> Vec<(usize, Cut)> {
        let rank = |i: &Cut| cuts.iter().filter(|j| j.edge != i.edge && is_before(j, i)).count();
        let mut ranked: Vec<_> = cuts.iter().map(|i| (rank(i), *i)).collect();
        ranked.sort_by_key(|&(rank, cut)| (rank, cut.edge));
        ranked
    };
    let at = |cut: &Cut| cut.along(seen, e);
    let mut found = if cuts.len() <= MOST_ORDERED { ranked(&|j, i| is_before(seen, e, j, i)) } else { Vec::new() };
    if found.len() < cuts.len() || found.windows(2).any(|pair| pair[0].0 == pair[1].0) {
        found = ranked(&|j, i| at(j) < at(i) || at(j) == at(i) && j.edge < i.edge);
    }
    found.into_iter().map(|(_, cut)| cut).collect()
}

/// Whether cut `j` of edge `e` comes before cut `i`. Turns decide where the one cut is on one side of the other edge.
/// Otherwise all three edges cross each other, and how far along one of the three the others cut it decides for all three. If
/// they seem to cross in one point, the moved light tells them apart, or [`is_before_in_one_point`] decides.
fn is_before(seen: SeenEdges<'_>, e: usize, j: &Cut, i: &Cut) -> bool {
    let SeenEdges { edges, light, .. } = seen;
    let side = |of: usize, point: [f32; 3]| turn(edges[of][0], edges[of][1], point, light);
    let [start, end] = edges[e];
    let (touches, [j, i]) = ([j.touch, i.touch], [j.edge, i.edge]);
    let is_up = is_below(start, end);
    let sides = |of: usize, edge: usize| edges[edge].map(|end| side(of, end));
    let (of_j, of_i) = (sides(i, j), sides(j, i));
    match (touches, of_j == [0, 0], side(i, end)) {
        ([Some(p), Some(q)], ..) if p != q => return is_below(p, q) == is_up,
        // All in one line: what is nearer cuts first upwards.
        (_, true, 0) => return precedes(edges, i, j) == is_up,
        (_, true, of_end) => return precedes(edges, j, i) == (of_end == right_of(edges[i])),
        // Both from one point on e. One that is in line with e says nothing of the other.
        ([Some(_), Some(_)], _, 0) => return of_i[0] + of_i[1] == side(j, end),
        ([Some(_), Some(_)], _, of_end) => return of_j[0] + of_j[1] != of_end,
        _ => {}
    }
    match touches {
        [Some(p), _] => return side_of_touch(edges, e, j, p, i, light) != side(i, end),
        [_, Some(p)] => return side_of_touch(edges, e, i, p, j, light) == side(j, end),
        _ => {}
    }
    let common = |[p, q]: [i32; 2]| if p * q < 0 { 0 } else { p + q };
    match (common(of_j).signum(), common(of_i).signum()) {
        (0, 0) => {}
        (0, sign) => return sign == side(j, end),
        (sign, _) => return sign != side(i, end),
    }
    let crosses = of_j[0] == of_i[1];
    if !crosses {
        let [at_j, at_i] = [j, i].map(|cutting| seen_cut_at(seen, cutting, e).0);
        let is_nearer = at_j < at_i || at_j == at_i && j < i;
        let told = if (at_j - at_i).abs() > ONE_POINT { None } else { moved_apart(seen, [e, j.min(i), j.max(i)]) };
        return told.map_or(is_nearer, |is_after| is_after == (i < j));
    }
    let Some((first, is_after)) = decisive(seen, [e, j, i]) else {
        return is_before_in_one_point(seen, e, j, i);
    };
    let comes_after = |one: usize, other: usize| if one < other { is_after } else { !is_after };
    if first == e {
        return comes_after(i, j);
    }
    let other = if first == i { j } else { i };
    let sense = if comes_after(e, other) { 1 } else { -1 } * side(e, edges[first][1]) * side(other, edges[first][1]);
    let turned = if first == i { -sense } else { sense };
    turned * side(i, end) * side(j, end) > 0
}

/// Parts of an edge that are taken for one point of it.
const ONE_POINT: f64 = 1.0 / (1_u64 << 40) as f64;

/// Which of three edges that cross each other tells their order, and whether the earlier of the two others cuts it after the
/// later one. It is the earliest of them. If some are seen in line, others see these cross in one point, so it is the one along
/// which the others are farthest apart. `None` if they seem to cross in one point.
fn decisive(seen: SeenEdges<'_>, mut three: [usize; 3]) -> Option<(usize, bool)> {
    three.sort_unstable();
    let [first, second, third] = three;
    let mut are_in_line = false;
    let apart = [[first, second, third], [second, first, third], [third, first, second]].map(|[cut, one, other]| {
        let [one, other] = [one, other].map(|by| seen_cut_at(seen, by, cut));
        are_in_line |= one.1 || other.1;
        one.0 - other.0
    });
    let told = if are_in_line {
        // The first of those that are equal.
        (0..3)
            .rev()
            .max_by(|&p, &q| apart[p].abs().total_cmp(&apart[q].abs()))
            .filter(|&at| apart[at].abs() > ONE_POINT)
    } else {
        apart.iter().all(|apart| apart.abs() > ONE_POINT).then_some(0)
    };
    match told {
        Some(at) => Some((three[at], apart[at] > 0.0)),
        None => moved_apart(seen, three).map(|is_after| (first, is_after)),
    }
}

/// Where the light as given sees three edges cross in one point, whether the second cuts the first after the third as the moved
/// light sees it. `None` if that sees them cross in one point, too, or nearly.
fn moved_apart(seen: SeenEdges<'_>, [e, f, g]: [usize; 3]) -> Option<bool> {
    let SeenEdges { edges, light, holds_turns } = seen;
    if !holds_turns {
        return None;
    }
    let values = |of: usize| -> Option<[[f64; 4]; 2]> {
        let [a, b] = edges[e].map(|end| turn_values(edges[of][0], edges[of][1], end, light));
        Some([a?, b?])
    };
    let ([f_a, f_b], [g_a, g_b]) = (values(f)?, values(g)?);
    // The place of an edge is t/(t - t'), where t and t' are powers of the light's movement with these factors.
    for power in 0..7_usize {
        let (mut sum, mut size) = (0.0_f64, 0.0);
        for one in 0..4_usize {
            let Some(other) = power.checked_sub(one).filter(|&other| other < 4) else { continue };
            let (p, q) = (g_a[one] * f_b[other], f_a[one] * g_b[other]);
            sum += p - q;
            size += p.abs() + q.abs();
        }
        if sum.abs() > SAME * size {
            let side = |of: usize| turn(edges[of][0], edges[of][1], edges[e][1], light);
            let is_after = (sum > 0.0) == (side(f) * side(g) > 0);
            return (power > 0).then_some(is_after);
        }
    }
    None
}

/// Parts of a sum of products that may be rounding.
const SAME: f64 = 1.0 / (1_u64 << 48) as f64;

/// Likewise, where all three edges cross each other in one point. Then each is moved to its left a little, and the foremost one
/// farther than the others, out of their crossing. If nobody knows where edges that are seen in line cross, the foremost is one
/// of these. Where both are cut, they are beside each other then, and their own crossing is elsewhere.
fn is_before_in_one_point(seen: SeenEdges<'_>, e: usize, j: usize, i: usize) -> bool {
    let SeenEdges { edges, light, holds_turns } = seen;
    let side = |of: usize, point: [f32; 3]| turn(edges[of][0], edges[of][1], point, light);
    let foremost = |one: usize, other: usize| if precedes(edges, one, other) { one } else { other };
    let are_in_line = |one: usize, other: usize| {
        !holds_turns && edges[other].iter().all(|&end| turn_as_given(edges[one][0], edges[one][1], end, light) == 0)
    };
    let first = if are_in_line(e, j) {
        foremost(e, j)
    } else if are_in_line(e, i) {
        foremost(e, i)
    } else if are_in_line(i, j) {
        foremost(i, j)
    } else {
        foremost(e, foremost(i, j))
    };
    let end = edges[e][1];
    if first == i {
        return right_of(edges[i]) != side(i, end);
    }
    if first == j {
        return right_of(edges[j]) == side(j, end);
    }
    // It is cut where the others have left their crossing.
    let is_right = side(e, edges[j][0]) == right_of(edges[e]);
    side(i, edges[j][usize::from(is_right)]) != side(i, end)
}

/// The sign of the turns to points on the right of an edge, seen in the direction in which coordinates grow.
fn right_of([a, b]: Edge) -> i32 {
    if is_below(a, b) { -1 } else { 1 }
}

/// The side of edge `other` on which edge `touching` cuts edge `e`, on which its end `point` is. If that is on both in space, it
/// is on the right of both, and farther from the one that [`precedes`]. So `touching` cuts the other first.
fn side_of_touch(edges: &[Edge], e: usize, touching: usize, point: [f32; 3], other: usize, light: [f32; 4]) -> i32 {
    let side = |of: usize, point: [f32; 3]| turn(edges[of][0], edges[of][1], point, light);
    let is_in_line = side(touching, edges[e][1]) == 0;
    let sides = edges[touching].map(|end| side(other, end));
    match (side(other, point), is_in_line || precedes(edges, other, e)) {
        (0, true) => right_of(edges[other]),
        (0, false) => sides[0] + sides[1],
        (sign, _) => sign,
    }
}

/// How far along edge `e` the moved light sees `f` cross it, and whether it does not do so as given: then it sees them in line.
fn seen_cut_at(seen: SeenEdges<'_>, f: usize, e: usize) -> (f64, bool) {
    let (f, e) = (seen.edges[f], seen.edges[e]);
    let (light, is_given) = if seen.holds_turns { light_of_cut(f, e, seen.light) } else { (seen.light, true) };
    (cut_at(f, e, light), !is_given)
}

/// How far along `(a, b)` the plane through the light and `(c, d)` is. If the light looks along `(c, d)`, it is where it sees
/// `c`.
fn cut_at([c, d]: Edge, [a, b]: Edge, [x, y, z, w]: [f32; 4]) -> f64 {
    let [a, b, c, d] = [a, b, c, d].map(|point| point.map(f64::from));
    let towards = |point| to_light(point, [x, y, z].map(f64::from), f64::from(w));
    let [along, sight] = [difference(d, c), towards(c)];
    let mut normal = cross(along, sight);
    if sum_of_sizes(normal) <= END_ON * sum_of_sizes(along) * sum_of_sizes(sight) {
        normal = cross(cross(difference(b, a), towards(a)), sight);
    }
    let [from, to] = [a, b].map(|end| dot(normal, difference(end, c)));
    let at = from / (from - to);
    // The signs of both are exactly opposite, but here they are rounded, and the light has not moved.
    if at.is_nan() { 0.5 } else { at.clamp(0.0, 1.0) }
}

/// The sine of an angle at which rounding tells more of a plane than the light and the edge in it do.
const END_ON: f64 = 1e-12;

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
