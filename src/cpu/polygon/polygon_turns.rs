//! Polygon turns: a fast test that decides most polygons.

use super::corner_turn::turn_as_given;
use super::orientation::Orientation;

/// The corners whose turns must be equal for a loop of `count` corners to be strictly convex. Three corners need one turn,
/// four need four; more corners also need those that show that the loop goes around once.
pub(crate) fn convex_turns(count: usize) -> impl Iterator<Item = [usize; 3]> {
    let next = move |corner: usize| if corner + 1 < count { corner + 1 } else { 0 };
    let corners = (0..if count == 3 { 1 } else { count }).map(move |corner| [corner, next(corner), next(next(corner))]);
    corners.chain((3..count.max(4) - 1).flat_map(|corner| [[0, 1, corner], [0, corner - 1, corner]]))
}

/// The side of one loop of corners that a light sees, if turns decide: for strictly convex loops, and for quadrilaterals
/// without a turn of 0.
pub fn polygon_turns(corners: &[[f32; 3]], light: [f32; 4]) -> Option<Orientation> {
    if corners.len() < 3 {
        return None;
    }
    let turn = |[i, j, k]: [usize; 3]| turn_as_given(corners[i], corners[j], corners[k], light);
    if corners.len() == 4 {
        let turns: Vec<i32> = convex_turns(4).map(turn).collect();
        return match turns.iter().sum() {
            _ if turns.contains(&0) => None,
            2.. => Some(Orientation::FrontFacing),
            ..=-2 => Some(Orientation::BackFacing),
            _ => Some(Orientation::Twisted),
        };
    }
    match convex(corners, light) {
        ..0 => Some(Orientation::BackFacing),
        0 => None,
        1.. => Some(Orientation::FrontFacing),
    }
}

/// The facing of one loop of corners, if it is strictly convex as seen from a light: 1 or −1. Otherwise 0.
pub(crate) fn convex(corners: &[[f32; 3]], light: [f32; 4]) -> i32 {
    if corners.len() < 3 {
        return 0;
    }
    let mut turns =
        convex_turns(corners.len()).map(|[i, j, k]| turn_as_given(corners[i], corners[j], corners[k], light));
    let sign = turns.next().unwrap_or(0);
    if turns.all(|turn| turn == sign) { sign } else { 0 }
}
