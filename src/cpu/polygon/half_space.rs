//! Half-space: whether a boundary fits an open half-space of directions as seen from a light.

use super::corner_turn::turn;

/// Whether the corners fit an open half-space: then at least one of them is a corner of their hull.
pub fn fits_half_space(corners: &[[f32; 3]], light: [f32; 4]) -> bool {
    corners.iter().any(|&corner| is_hull_corner(corner, corners, light))
}

/// Whether some other corner has all corners on its left, or in line with it, as seen from this corner. There is a
/// plane through the light then that has all corners on one side.
fn is_hull_corner(corner: [f32; 3], corners: &[[f32; 3]], light: [f32; 4]) -> bool {
    let others = || corners.iter().copied().filter(|&other| other != corner);
    // If there is one, this finds it: around a corner of the hull, others are ordered.
    let Some(rightmost) =
        others().reduce(|best, other| if turn(corner, best, other, light) < 0 { other } else { best })
    else {
        return false;
    };
    let mut is_any_left = false;
    for other in others() {
        match turn(corner, rightmost, other, light) {
            ..0 => return false,
            0 => {}
            1.. => is_any_left = true,
        }
    }
    is_any_left
}
