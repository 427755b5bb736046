//! Many edges: how a light sees a boundary of many edges, without going over all pairs of them; docs/numerics/polygons.md,
//! "Many edges".

use super::corner_turn::turn_as_given;
use super::edge_pair::{Edge, edge_pair};
use super::orientation::Orientation;
use crate::cpu::common::double_sign::{cross, difference, dot, sum_of_sizes, to_light};

/// With fewer edges, all pairs take less time.
pub(crate) const MANY_EDGES: usize = 64;

/// How the light sees the edges of a boundary, none of which has length 0. It equals the result of all pairs of edges.
/// `None` if this way cannot decide: the light is close to the boundary, or amid its corners.
pub(crate) fn many_edges(edges: &[Edge], light: [f32; 4]) -> Option<Orientation> {
    if is_in_plane(edges, light) {
        return Some(Orientation::InPlane);
    }
    let flat = Flat::new(edges, light)?;
    if flat.any_close_pair(|e, f| edge_pair(edges[e], edges[f], light).meets) {
        return Some(Orientation::Twisted);
    }
    // No edges meet, so the region on the left of an edge goes on along the next one, up to a corner where others begin.
    let windings = chains(edges).into_iter().map(|e| {
        // An edge all on one side of the line of `e` does not pass it: it counts 0.
        let passing = (0..edges.len()).filter(|&f| f != e && !flat.are_apart(e, f));
        passing.map(|f| edge_pair(edges[e], edges[f], light).left_of_e).sum::<i32>()
    });
    Some(Orientation::of_windings(&windings.collect::<Vec<i32>>()))
}

/// Whether each edge is in one plane with the light and each corner. An edge that points at the light always is. Any other
/// edge decides for all corners.
fn is_in_plane(edges: &[Edge], light: [f32; 4]) -> bool {
    let Some(&[a, b]) = edges.iter().find(|&&edge| !points_at(edge, light)) else { return true };
    edges.iter().all(|&[c, _]| turn_as_given(a, b, c, light) == 0)
}

/// Whether an edge is in one plane with the light and any point: those beside one end along each axis.
fn points_at([a, b]: Edge, light: [f32; 4]) -> bool {
    (0..3).all(|axis| {
        let mut beside = a;
        beside[axis] = if a[axis] < 0.0 { a[axis].next_up() } else { a[axis].next_down() };
        turn_as_given(a, b, beside, light) == 0
    })
}

/// An edge of each part of the boundary that no other edges begin at.
fn chains(edges: &[Edge]) -> Vec<usize> {
    let key = |point: [f32; 3]| point.map(|c| (c + 0.0).to_bits());
    let mut starts: Vec<_> = edges.iter().enumerate().map(|(edge, &[start, _])| (key(start), edge)).collect();
    starts.sort_unstable();
    // The number of edges that begin at a corner equals the number that end there. This is the next edge, if it is the only
    // one.
    let next = |edge: usize| {
        let end = key(edges[edge][1]);
        let first = starts.partition_point(|&(start, _)| start < end);
        let mut nexts = starts[first..].iter().take_while(|&&(start, _)| start == end);
        match (nexts.next(), nexts.next()) {
            (Some(&(_, next)), None) => Some(next),
            _ => None,
        }
    };
    let next: Vec<Option<usize>> = (0..edges.len()).map(next).collect();
    let mut is_next = vec![false; edges.len()];
    next.iter().flatten().for_each(|&edge| is_next[edge] = true);
    let mut is_walked = vec![false; edges.len()];
    let mut first_edges = Vec::new();
    // Where a part begins; then those that are left, which are loops without a beginning.
    let begins = (0..edges.len()).filter(|&edge| !is_next[edge]);
    for first in begins.chain(0..edges.len()) {
        if is_walked[first] {
            continue;
        }
        first_edges.push(first);
        let mut walk = Some(first);
        while let Some(edge) = walk.filter(|&edge| !is_walked[edge]) {
            is_walked[edge] = true;
            walk = next[edge];
        }
    }
    first_edges
}

/// The edges in a plane, as the light sees them, each point less than `margin` from its exact position along both axes.
struct Flat {
    edges: Vec<[[f64; 2]; 2]>,
    margin: f64,
}

/// The most by which the plane's points may be farther from each other than those in space. With it, all rounding errors are
/// far below the margin.
const MOST_SCALE: f64 = 1024.0;
/// The ranges of an edge along both axes, with the margin.
struct EdgeRanges {
    sweep: [f64; 2],
    other: [f64; 2],
    edge: usize,
}

/// The margin, as a part of the size and the square of the scale.
const MARGIN: f64 = 1.0 / (1 << 30) as f64;

impl Flat {
    /// Seen from the light, points move onto the plane through the middle of the boundary. `None` if some are not well in
    /// front of the light.
    fn new(edges: &[Edge], light: [f32; 4]) -> Option<Self> {
        let points = || edges.iter().flatten().map(|point| point.map(f64::from));
        let (low, high) = points().fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(low, high), point| {
            ([0, 1, 2].map(|i| low[i].min(point[i])), [0, 1, 2].map(|i| high[i].max(point[i])))
        });
        let middle = [0, 1, 2].map(|i| 0.5 * (low[i] + high[i]));
        let [x, y, z, w] = light.map(f64::from);
        let towards = to_light(middle, [x, y, z], w);
        let length = dot(towards, towards).sqrt();
        // Not where much is lost in the difference.
        if length * MOST_SCALE < sum_of_sizes([x, y, z]) + w.abs() * sum_of_sizes(middle) || length == 0.0 {
            return None;
        }
        let unit = |v: [f64; 3]| {
            let length = dot(v, v).sqrt();
            v.map(|c| c / length)
        };
        let axis = towards.map(|c| c / length);
        let least = (0..3).min_by(|&i, &j| axis[i].abs().total_cmp(&axis[j].abs())).unwrap_or(0);
        let mut other = [0.0; 3];
        other[least] = 1.0;
        let right = unit(cross(axis, other));
        let up = cross(axis, right);
        let size = sum_of_sizes(difference(high, low));
        let mut scale: f64 = 1.0;
        let mut flat = |point: [f32; 3]| {
            let from_middle = difference(point.map(f64::from), middle);
            // One over how far the light is from the point, of how far it is from the middle.
            let nearness = length / (length - w * dot(from_middle, axis));
            scale = if nearness > 0.0 { scale.max(nearness) } else { f64::INFINITY };
            [right, up].map(|axis| dot(from_middle, axis) * nearness)
        };
        let edges = edges.iter().map(|edge| edge.map(&mut flat)).collect();
        (scale <= MOST_SCALE).then_some(Self { edges, margin: MARGIN * size * scale * scale })
    }

    /// Whether one of the pairs that may have a point in common is `found`.
    fn any_close_pair(&self, mut found: impl FnMut(usize, usize) -> bool) -> bool {
        let range = |edge: usize, axis: usize| {
            let [p, q] = self.edges[edge].map(|point| point[axis]);
            [p.min(q) - self.margin, p.max(q) + self.margin]
        };
        // Along the axis on which edges are short, few lie beside each other.
        let lengths =
            [0, 1].map(|axis| (0..self.edges.len()).map(|e| range(e, axis)[1] - range(e, axis)[0]).sum::<f64>());
        let [sweep, other] = if lengths[0] <= lengths[1] { [0, 1] } else { [1, 0] };
        let ranges = |edge: usize| EdgeRanges { sweep: range(edge, sweep), other: range(edge, other), edge };
        let mut ranges: Vec<EdgeRanges> = (0..self.edges.len()).map(ranges).collect();
        ranges.sort_unstable_by(|one, other| one.sweep[0].total_cmp(&other.sweep[0]));
        ranges.iter().enumerate().any(|(at, &EdgeRanges { sweep: [_, end], other: [low, high], edge: e })| {
            let beside = ranges[at + 1..].iter().take_while(|range| range.sweep[0] <= end);
            let mut close =
                beside.filter(|range| range.other[0] <= high && low <= range.other[1]).map(|range| range.edge);
            close.any(|f| !self.are_apart(e, f) && !self.are_apart(f, e) && found(e.min(f), e.max(f)))
        })
    }

    /// Whether all of edge `f` is certainly on one side of the line through `e`: the turns from `e` to its ends are equal and
    /// not 0.
    fn are_apart(&self, e: usize, f: usize) -> bool {
        let minus = |p: [f64; 2], q: [f64; 2]| [p[0] - q[0], p[1] - q[1]];
        let size = |v: [f64; 2]| v[0].abs() + v[1].abs();
        let ([a, b], ends) = (self.edges[e], self.edges[f]);
        let along = minus(b, a);
        let sides = ends.map(|end| {
            let to_end = minus(end, a);
            let side = along[0] * to_end[1] - along[1] * to_end[0];
            let error = 8.0 * self.margin * (size(along) + size(to_end) + self.margin);
            i32::from(side > error) - i32::from(side < -error)
        });
        sides[0] * sides[1] > 0
    }
}
