//! Cones of directions, each of which is searched by itself. Any planes through the light are right.

use glam::DVec3;

use super::plane::Plane;
use super::tree::Face;
use crate::light::Light;

/// The most faces of a cone that is not split.
const SMALL: usize = 2048;

/// The directions on one side of each of some planes through the light.
pub(crate) struct Cone {
    pub(crate) planes: Vec<(Plane, i32)>,
    /// The faces that may be in it, in their order.
    pub(crate) faces: Vec<usize>,
}

/// Cones that together contain all directions. A face is listed in each cone that it may be in, in the order of `order`.
pub(crate) fn cones(faces: &[Face], order: Vec<usize>, light: Light) -> Vec<Cone> {
    let middles: Vec<DVec3> = faces.iter().map(|face| direction_key(middle(face), light)).collect();
    let (mut waiting, mut cones) = (vec![Cone { planes: Vec::new(), faces: order }], Vec::new());
    while let Some(cone) = waiting.pop() {
        match split(faces, &middles, &cone, light) {
            Some(parts) => waiting.extend(parts),
            None => cones.push(cone),
        }
    }
    cones
}

fn middle(face: &Face) -> DVec3 {
    face.corners.iter().map(|corner| DVec3::from(corner.map(f64::from))).sum::<DVec3>() / 3.0
}

/// The coordinates by which directions to points are compared: the direction. A light at infinity takes the point along two
/// axes.
fn direction_key(point: DVec3, light: Light) -> DVec3 {
    let (l, w) = (DVec3::from(light.xyz.map(f64::from)), f64::from(light.w));
    if w > 0.0 { (point - l / w).normalize_or_zero() } else { point - point.dot(l) / l.length_squared() * l }
}

/// The parts of a cone on both sides of a plane, if they are smaller.
fn split(faces: &[Face], middles: &[DVec3], Cone { planes, faces: cone }: &Cone, light: Light) -> Option<[Cone; 2]> {
    if cone.len() <= SMALL {
        return None;
    }
    let finite = || cone.iter().copied().filter(|&face| middles.get(face).is_some_and(|middle| middle.is_finite()));
    let of = |face: usize| middles.get(face).copied().unwrap_or_default();
    let far = DVec3::splat(f64::MAX);
    let (low, high) = finite().fold((far, -far), |(low, high), face| (low.min(of(face)), high.max(of(face))));
    let spread = high - low;
    let axis = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().max_by(|a, b| a.dot(spread).total_cmp(&b.dot(spread)))?;
    let mut sorted: Vec<usize> = finite().collect();
    sorted.sort_unstable_by(|&a, &b| of(a).dot(axis).total_cmp(&of(b).dot(axis)));
    let &pivot = sorted.get(sorted.len() / 2)?;
    let plane = through(middle(faces.get(pivot)?), axis, light)?;
    let mut parts = [Vec::new(), Vec::new()];
    for &face in cone {
        let sides = faces.get(face).map_or([0; 3], |face| face.corners.map(|corner| plane.side(corner)));
        // Rounding may have left no plane. Then all is on both sides.
        let is_flat = sides == [0; 3];
        for (part, side) in parts.iter_mut().zip([1, -1]) {
            if is_flat || sides.contains(&side) {
                part.push(face);
            }
        }
    }
    let most = cone.len() - cone.len() / 4;
    let part = |faces: Vec<usize>, side: i32| {
        let planes = planes.iter().copied().chain([(plane, side)]).collect();
        Cone { planes, faces }
    };
    let [above, below] = parts;
    (above.len() <= most && below.len() <= most).then(|| [part(above, 1), part(below, -1)])
}

/// About the plane through the light and a point whose normal is nearest to an axis.
fn through(point: DVec3, axis: DVec3, light: Light) -> Option<Plane> {
    let (l, w) = (DVec3::from(light.xyz.map(f64::from)), f64::from(light.w));
    let away = if w > 0.0 { point - l / w } else { l };
    let other = point + away.cross(axis) * if w > 0.0 { 1.0 } else { point.length().max(1e-30) / l.length_squared() };
    let [a, b] = [point, other].map(|point| point.to_array().map(|c| c as f32));
    a.into_iter().chain(b).all(f32::is_finite).then(|| Plane::of_edge(a, b, light))
}
