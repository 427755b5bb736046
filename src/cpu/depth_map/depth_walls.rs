//! Depth walls: the vertices of walls over contours.

use glam::Vec4;

use super::contour::{FAR, Map, RANGE, TEXEL};
use super::contour_walls::Wall;
use crate::layout::DepthMapView;

/// A vertex of a wall in the camera's clip space. Six make two triangles.
pub fn depth_walls(map: &Map<'_>, view: &DepthMapView, wall: &Wall, index: usize) -> Vec4 {
    let vertex = wall[[0, 1, 2, 0, 2, 3][index % 6]];
    let distance = vertex[2];
    let [x, y] =
        [0, 1].map(|axis| vertex[axis] as f32 / (TEXEL / 2) as f32 - map.samples.shape.size[axis] as f32 - 1.0);
    let column = |column: [f32; 4]| Vec4::from_array(column);
    if distance == FAR {
        return column(view.far_across) * x + column(view.far_down) * y + column(view.far_middle);
    }
    let depth = if map.samples.shape.is_reversed == 1 { RANGE - distance } else { distance };
    let depth = depth as f32 / RANGE as f32;
    column(view.across) * x + column(view.down) * y + column(view.depth) * depth + column(view.middle)
}
