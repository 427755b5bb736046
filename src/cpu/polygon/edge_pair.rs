//! Edge pair: whether two edges of a boundary meet as seen from a light, and where each passes the other's line.

use super::corner_turn::turn;

/// A directed edge.
pub(crate) type Edge = [[f32; 3]; 2];

/// How two edges `e` and `f` lie to each other as seen from a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgePair {
    /// Whether they cross, or touch elsewhere than at an end that they share.
    pub meets: bool,
    /// The part of `f` in the winding number on the left of `e`: 1, 0 or −1.
    pub left_of_e: i32,
    /// The part of `e` in the winding number on the left of `f`.
    pub left_of_f: i32,
}

/// Two edges `(a, b)` and `(c, d)` of a boundary that fits an open half-space of directions. Neither has length 0.
pub fn edge_pair([a, b]: Edge, [c, d]: Edge, light: [f32; 4]) -> EdgePair {
    let of_e = [turn(a, b, c, light), turn(a, b, d, light)];
    let of_f = [turn(c, d, a, light), turn(c, d, b, light)];
    EdgePair {
        meets: meets([a, b], [c, d], of_e, of_f),
        left_of_e: passes(of_e, of_f[1]),
        left_of_f: passes(of_f, of_e[1]),
    }
}

/// `of_e` are the turns from `(a, b)` to `c` and `d`, and `of_f` those from `(c, d)` to `a` and `b`.
fn meets([a, b]: Edge, [c, d]: Edge, of_e: [i32; 2], of_f: [i32; 2]) -> bool {
    let shared = [(a, b, c, d), (a, b, d, c), (b, a, c, d), (b, a, d, c)].into_iter().find(|(p, _, q, _)| p == q);
    if let Some((from, end, _, other_end)) = shared {
        // All four are 0 only if the edges are in line.
        return of_e == [0, 0] && of_f == [0, 0] && !is_between(end, from, other_end);
    }
    if of_e == [0, 0] && of_f == [0, 0] {
        return overlaps([a, b], [c, d]);
    }
    let (apart_from_e, apart_from_f) = (of_e[0] * of_e[1], of_f[0] * of_f[1]);
    match (apart_from_e, apart_from_f) {
        // Four signs of one sense. With the other sense one edge crosses the other's opposite directions.
        (-1, -1) => of_e[0] == of_f[1],
        // An end of one lies on the other, in space.
        (0, -1) | (-1, 0) => true,
        _ => false,
    }
}

/// The part of an edge `(c, d)` in the winding number on the left of an edge `(a, b)`. It is counted along the line through
/// `a` and `b`, beyond the point where `b` was. The line is moved to the left by next to nothing, so points on it, `a` and
/// `b` among them, are on its right. `sides` are the turns from `(a, b)` to `c` and `d`. `b_of_f` is the turn from `(c, d)`
/// to `b`; where it is 0, the edge begins or ends at `b`, and passes beyond.
fn passes(sides: [i32; 2], b_of_f: i32) -> i32 {
    match sides.map(|side| side > 0) {
        [false, true] => i32::from(b_of_f >= 0),
        [true, false] => -i32::from(b_of_f <= 0),
        _ => 0,
    }
}

/// Whether `middle`, which is on the line through the others, is strictly between them.
fn is_between(p: [f32; 3], middle: [f32; 3], q: [f32; 3]) -> bool {
    (0..3).any(|axis| {
        (p[axis] < middle[axis]) != (q[axis] < middle[axis]) && p[axis] != middle[axis] && q[axis] != middle[axis]
    })
}

/// Whether two edges in line have a point in common. They share no end.
fn overlaps([a, b]: Edge, [c, d]: Edge) -> bool {
    is_between(a, c, b) || is_between(a, d, b) || is_between(c, a, d)
}
