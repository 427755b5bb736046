//! Convex: the cheap way to the facing of most outlines.

use super::turn::turn_as_given;

/// The facing of one loop of corners, if it is strictly convex as seen from a light: 1 or −1. Otherwise 0. Four corners
/// need four signs; more corners also need those that show that the loop turns around once.
pub fn convex(corners: &[[f32; 3]], light: [f32; 4]) -> i32 {
    let count = corners.len();
    if count < 3 {
        return 0;
    }
    let at = |corner: usize| corners[corner % count];
    let turns = |i: usize, j: usize, k: usize| turn_as_given(at(i), at(j), at(k), light);
    let sign = turns(0, 1, 2);
    let is_alike = sign != 0
        && (count == 3 || (1..count).all(|corner| turns(corner, corner + 1, corner + 2) == sign))
        && (3..count - 1).all(|corner| turns(0, 1, corner) == sign && turns(0, corner - 1, corner) == sign);
    if is_alike { sign } else { 0 }
}
