//! Depth surface: the vertices of the boundary between light and shadow, and where the near rectangle is in shadow.

use glam::{UVec2, Vec2, Vec3, Vec4};

use super::depth_cube::CubeSample;
use super::edge_code::Cell;
use super::samples::{Key, Samples};
use crate::layout::DepthMapView;

/// The depth difference to each side that is smaller, 0 where they have different signs or one of the three is far.
fn slope(samples: &Samples<'_>, own: Key, before: Key, after: Key) -> f32 {
    let (Key::Steps(own), Key::Steps(before), Key::Steps(after)) = (own, before, after) else { return 0.0 };
    let [own, before, after] = [own, before, after].map(|steps| samples.depth(steps));
    let (a, b) = (own - before, after - own);
    if (a > 0.0) == (b > 0.0) { a.abs().min(b.abs()) } else { 0.0 }
}

/// The slopes at a sample across and down. At the border of a map of a cube, those of the samples next to it.
fn slopes_in_map(samples: &Samples<'_>, at: [u32; 2]) -> f32 {
    let side = samples.shape.size[0];
    let inner = |at: u32| if samples.shape.faces > 1 { at - at % side + (at % side).clamp(1, side - 2) } else { at };
    let ([x, y], [inner_x, inner_y]) = (at, at.map(inner));
    slope_along(samples, [inner_x, y], [1, 0]) + slope_along(samples, [x, inner_y], [0, 1])
}

/// The depth difference to one side, to the next sample or from that to the second: the smaller, 0 where one of the three is far.
fn slope_to(samples: &Samples<'_>, keys: [Key; 3]) -> f32 {
    let [Key::Steps(own), Key::Steps(first), Key::Steps(second)] = keys else { return 0.0 };
    let [own, first, second] = [own, first, second].map(|steps| samples.depth(steps));
    (first - own).abs().min((second - first).abs())
}

/// The slope along one axis. Where the boundary is moved sideways, the larger of those to both sides counts.
fn slope_along(samples: &Samples<'_>, at: [u32; 2], step: [u32; 2]) -> f32 {
    let key = |steps: u32| {
        let place = [0, 1].map(|axis| at[axis].wrapping_add(step[axis].wrapping_mul(steps)));
        samples.at(place)
    };
    let [before, after] = [u32::MAX, 1];
    if samples.shape.spread == 1 {
        let side = |step: u32| slope_to(samples, [key(0), key(step), key(step.wrapping_mul(2))]);
        return side(before).max(side(after));
    }
    slope(samples, key(0), key(before), key(after))
}

/// The slopes at a sample: in a cube, the largest of all maps that have it.
fn slopes(samples: &Samples<'_>, at: [u32; 2]) -> f32 {
    if samples.shape.faces == 1 {
        return slopes_in_map(samples, at);
    }
    let side = samples.shape.size[0];
    let on_ray = CubeSample::in_texture(at, side).on_ray(side);
    on_ray.map(|sample| slopes_in_map(samples, sample.place(side))).fold(0.0, f32::max)
}

/// The depth of a sample that casts, moved away from the light.
fn moved_depth(samples: &Samples<'_>, view: &DepthMapView, at: [u32; 2], steps: u32) -> f32 {
    let own = samples.depth(steps);
    let (to_far, sign) = if samples.shape.is_reversed == 1 { (own, -1.0) } else { (1.0 - own, 1.0) };
    let [of_slope, of_depth, constant, _] = view.bias;
    own + sign * (of_slope * slopes(samples, at) + of_depth * own + constant).min(0.5 * to_far)
}

/// Twice the place of a sample from the middle of the lattice, and the map whose view it is taken with: the first that has it.
fn view_of(samples: &Samples<'_>, at: [u32; 2]) -> (Vec2, usize) {
    let side = samples.shape.size[0];
    let twice = |place: u32, size: u32| (2 * i64::from(place) - i64::from(size)) as f32;
    if samples.shape.faces == 1 {
        return (Vec2::new(twice(at[0], 1 + side), twice(at[1], 1 + samples.shape.size[1])), 0);
    }
    let own = CubeSample::in_texture(at, side);
    let first = own.on_ray(side).next().unwrap_or(own);
    (Vec2::from_array(first.at.map(|place| twice(place, side - 1))), first.face as usize)
}

/// The vertex at a sample, in the camera's clip space. There is a view for each map.
pub fn depth_surface(samples: &Samples<'_>, views: &[DepthMapView], at: [u32; 2]) -> Vec4 {
    let (place, map) = view_of(samples, at);
    let view = &views[map];
    let [across, down, depth, middle] = [view.across, view.down, view.depth, view.middle].map(Vec4::from_array);
    let [far_across, far_down, far] = [view.far_across, view.far_down, view.far_middle].map(Vec4::from_array);
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
pub fn is_behind(samples: &Samples<'_>, views: &[DepthMapView], place: Vec2) -> bool {
    let point = |view: &DepthMapView| {
        let [across, up, middle] = [view.near_across, view.near_up, view.near_middle].map(Vec4::from_array);
        across * place.x + up * place.y + middle
    };
    let (mut face, mut at_face) = (0, point(&views[0]));
    for (other, view) in (0..).zip(views) {
        let there = point(view);
        if there.w > at_face.w {
            (face, at_face) = (other, there);
        }
    }
    let (view, point) = (&views[face as usize], at_face);
    if point.w <= 0.0 {
        return false;
    }
    let mut lattice = Vec2::new(point.x, point.y) / point.w;
    let size = UVec2::from_array(samples.shape.size);
    let cell = if samples.shape.faces > 1 {
        lattice = lattice.clamp(Vec2::ZERO, (size - 1).as_vec2());
        lattice.floor().min((size - 2).as_vec2())
    } else if lattice.cmpge(Vec2::ZERO).all() && lattice.cmplt((size + 1).as_vec2()).all() {
        lattice.floor()
    } else {
        return false;
    };
    let part = lattice - cell;
    let local = [cell.x as u32, cell.y as u32];
    let at = if samples.shape.faces > 1 { CubeSample { face, at: local }.place(size.x) } else { local };
    let cell = Cell::at(samples, at);
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
                    let (place, map) = view_of(samples, at);
                    let [across, down, middle, _] = views[map].infinity;
                    Vec3::new(across, down, middle).dot(place.extend(1.0))
                }
                Key::Far => return false,
            };
    }
    let ahead = point.z / point.w - depth;
    if samples.shape.is_reversed == 1 { ahead < 0.0 } else { ahead > 0.0 }
}
