//! Contour side: the surface that a place within a marked cell belongs to.

use glam::{IVec2, Vec2};

use super::contour::{FAR, Map, RANGE, TEXEL, TURN, edge_of_cell, parts, sum};
use super::contour_marks::{code_of_cell, is_marked_before};
use super::contour_places::place_of;
use super::contour_rim::surface;

/// The place on the edge of a cell, from the cell's first sample on.
fn point(map: &Map<'_>, places: &[u32], cell: [i32; 2], bit: usize) -> Vec2 {
    let edge = edge_of_cell(cell, bit);
    let [x, y] = edge.at;
    let word = places.get((y * map.lattice()[0] + x) as usize).copied().unwrap_or(0);
    let place = (word >> (16 * edge.axis) & 0xffff) as f32 / 65_536.0;
    let corner = IVec2::new(edge.at[0] - cell[0], edge.at[1] - cell[1]).as_vec2();
    corner + if edge.axis == 0 { Vec2::new(place, 0.0) } else { Vec2::new(0.0, place) }
}

/// The corner of a marked cell whose surface a place of the cell belongs to, in turn.
pub fn contour_side(map: &Map<'_>, marks: &[u32], places: &[u32], cell: [i32; 2], place: Vec2) -> usize {
    let code = code_of_cell(map, marks, cell);
    if code.count_ones() == 2 {
        let first = code.trailing_zeros() as usize;
        let second = 31 - code.leading_zeros() as usize;
        let from = point(map, places, cell, first);
        let is_left = (point(map, places, cell, second) - from).perp_dot(place - from) < 0.0;
        let is_between = |corner: usize| corner > first && corner <= second;
        let away = |corner: usize| (place - IVec2::from_array(TURN[corner]).as_vec2()).abs().element_sum();
        let near = (0..4).filter(|&corner| is_between(corner) == is_left);
        return near.min_by(|&a, &b| away(a).total_cmp(&away(b))).unwrap_or(0);
    }
    let ray = |bit: usize| {
        let edge = edge_of_cell(cell, bit);
        if code >> bit & 1 == 1 && place_of(map, places, edge) > 0 {
            point(map, places, cell, bit) - 0.5
        } else {
            let [from, to] = [bit, (bit + 1) % 4].map(|corner| IVec2::from_array(TURN[corner]).as_vec2());
            (from + to) / 2.0 - 0.5
        }
    };
    let own = place - 0.5;
    (0..4).find(|&corner| ray((corner + 3) % 4).perp_dot(own) >= 0.0 && own.perp_dot(ray(corner)) >= 0.0).unwrap_or(0)
}

/// The distance of the surface at a place of a marked cell: between samples of the same surface, and as it goes on from the last.
pub fn contour_distance(map: &Map<'_>, marks: &[u32], places: &[u32], cell: [i32; 2], place: Vec2) -> i32 {
    let corner = TURN[contour_side(map, marks, places, cell, place)];
    let at = sum(cell, corner);
    let own = map.moved(at);
    if own == FAR {
        return FAR;
    }
    let offset = (place - IVec2::from_array(corner).as_vec2()).abs() * TEXEL as f32;
    let further = |step: [i32; 2], offset: f32| {
        let beside = sum(at, step);
        if is_marked_before(map, marks, beside, step) {
            surface(map, marks, (at, step), offset as i32, 0) - own
        } else {
            parts(map.moved(beside) - own, offset as i32)
        }
    };
    let [across, down] = corner.map(|at| 1 - 2 * at);
    (own + further([across, 0], offset.x) + further([0, down], offset.y)).clamp(0, RANGE - 1)
}
