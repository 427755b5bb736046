//! Contour flaps: between a surface and a wall, volumes begin at the flap, not where the surface goes on.

use glam::Vec2;

use super::contour::{Map, RANGE, TEXEL};
use super::contour_walls::{Wall, WallVertex};

/// A vertex from a place on, in parts of a texel, and its device depth in the units of distances.
type FlapVertex = (Vec2, i32);

/// Whether the line between two places crosses that from the origin to the right.
fn crosses(a: Vec2, b: Vec2) -> bool {
    let (upper, lower) = if a.y < b.y { (a, b) } else { (b, a) };
    upper.y <= 0.0 && lower.y > 0.0 && upper.perp_dot(lower) > 0.0
}

/// The device depth of a triangle at the origin, in the units of distances, if it is there.
fn depth_of([(a, depth), (b, depth_b), (c, depth_c)]: [FlapVertex; 3]) -> Option<f32> {
    let is_in = crosses(a, b) ^ crosses(b, c) ^ crosses(c, a);
    let [of_a, of_b, of_c] = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
    let more = of_b * (depth_b - depth) as f32 + of_c * (depth_c - depth) as f32;
    is_in.then(|| depth as f32 + more / (of_a + of_b + of_c))
}

/// Whether an odd number of flaps at a place of a cell change whether a device depth there is behind what is there. It is not, or
/// `is_behind`, without them.
pub fn flaps_change(map: &Map<'_>, walls: &[Wall], cell: [i32; 2], part: Vec2, depth: f32, is_behind: bool) -> bool {
    let is_reversed = map.samples.shape.is_reversed == 1;
    let vertex = |[x, y, distance]: WallVertex| {
        let at = Vec2::new((x - cell[0] * TEXEL) as f32, (y - cell[1] * TEXEL) as f32);
        (at - part * TEXEL as f32, if is_reversed { RANGE - distance } else { distance })
    };
    let triangles = walls.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let changing = triangles.filter(|triangle| {
        let own = depth_of(triangle.map(vertex)).map(|own| own / RANGE as f32);
        own.is_some_and(|own| (if is_reversed { depth < own } else { depth > own }) != is_behind)
    });
    changing.count() % 2 == 1
}
