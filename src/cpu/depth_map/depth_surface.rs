//! Depth surface: the vertices of the boundary between light and shadow, and where the near rectangle is in shadow.

use glam::{UVec2, Vec2, Vec3, Vec4};

use super::edge_code::Cell;
use super::samples::{Key, Samples};
use crate::layout::DepthMapView;

/// The depth difference to each side that is smaller, 0 where they have different signs or a side is far.
fn slope(samples: &Samples<'_>, own: f32, before: Key, after: Key) -> f32 {
    let (Key::Steps(before), Key::Steps(after)) = (before, after) else { return 0.0 };
    let (a, b) = (own - samples.depth(before), samples.depth(after) - own);
    if (a > 0.0) == (b > 0.0) { a.abs().min(b.abs()) } else { 0.0 }
}

/// The depth of a sample that casts, moved away from the light.
fn moved_depth(samples: &Samples<'_>, view: &DepthMapView, [x, y]: [u32; 2], steps: u32) -> f32 {
    let own = samples.depth(steps);
    let across = slope(samples, own, samples.at([x - 1, y]), samples.at([x + 1, y]));
    let down = slope(samples, own, samples.at([x, y - 1]), samples.at([x, y + 1]));
    let (to_far, sign) = if samples.shape.is_reversed == 1 { (own, -1.0) } else { (1.0 - own, 1.0) };
    let [of_slope, of_depth, constant, _] = view.bias;
    own + sign * (of_slope * (across + down) + of_depth * own + constant).min(0.5 * to_far)
}

/// Twice the place of a sample from the middle of the lattice.
fn from_middle(samples: &Samples<'_>, at: [u32; 2]) -> Vec2 {
    let twice = |place: u32, size: u32| (2 * i64::from(place) - 1 - i64::from(size)) as f32;
    Vec2::new(twice(at[0], samples.shape.size[0]), twice(at[1], samples.shape.size[1]))
}

/// The vertex at a sample, in the camera's clip space.
pub fn depth_surface(samples: &Samples<'_>, view: &DepthMapView, at: [u32; 2]) -> Vec4 {
    let [across, down, depth, middle] = [view.across, view.down, view.depth, view.middle].map(Vec4::from_array);
    let [far_across, far_down, far] = [view.far_across, view.far_down, view.far_middle].map(Vec4::from_array);
    let place = from_middle(samples, at);
    match samples.at(at) {
        Key::Far => far_across * place.x + far_down * place.y + far,
        Key::Steps(steps) => across * place.x + down * place.y + depth * moved_depth(samples, view, at, steps) + middle,
    }
}

/// The places of the three vertices of the triangle that covers the near rectangle.
pub fn depth_near_cap(index: u32) -> Vec2 {
    [Vec2::new(-1.0, -1.0), Vec2::new(3.0, -1.0), Vec2::new(-1.0, 3.0)][index as usize % 3]
}

/// Whether a place on the near rectangle is behind the surface.
pub fn is_behind(samples: &Samples<'_>, view: &DepthMapView, place: Vec2) -> bool {
    let [across, up, middle] = [view.near_across, view.near_up, view.near_middle].map(Vec4::from_array);
    let point = across * place.x + up * place.y + middle;
    if point.w <= 0.0 {
        return false;
    }
    let lattice = Vec2::new(point.x, point.y) / point.w;
    let end = UVec2::from_array(samples.shape.size).as_vec2() + 1.0;
    if !(lattice.cmpge(Vec2::ZERO).all() && lattice.cmplt(end).all()) {
        return false;
    }
    let at = lattice.floor();
    let part = lattice - at;
    let at = [at.x as u32, at.y as u32];
    let cell = Cell::of(samples, at[1] * (samples.shape.size[0] + 1) + at[0]);
    let (x, y) = (part.x, part.y);
    // The corners and their shares.
    let second = if cell.is_split { x + y > 1.0 } else { x < y };
    let shares = match (cell.is_split, second) {
        (false, false) => [1.0 - x, x - y, y],
        (false, true) => [1.0 - y, x, y - x],
        (true, false) => [1.0 - x - y, x, y],
        (true, true) => [1.0 - y, x + y - 1.0, 1.0 - x],
    };
    let mut depth = 0.0;
    for (corner, share) in cell.triangles()[usize::from(second)].into_iter().zip(shares) {
        let at = [at[0] + corner[0], at[1] + corner[1]];
        if share <= 0.0 {
            continue;
        }
        depth += share
            * match samples.at(at) {
                Key::Steps(steps) => moved_depth(samples, view, at, steps),
                Key::Far if view.infinity[3] == 0.0 => {
                    let [across, down, middle, _] = view.infinity;
                    Vec3::new(across, down, middle).dot(from_middle(samples, at).extend(1.0))
                }
                Key::Far => return false,
            };
    }
    let ahead = point.z / point.w - depth;
    if samples.shape.is_reversed == 1 { ahead < 0.0 } else { ahead > 0.0 }
}
