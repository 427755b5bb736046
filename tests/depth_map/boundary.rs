//! The boundary between light and shadow of a depth map, in `f64`, written independently: no code and no constant of the
//! library. Segments cross its triangles where determinants of homogeneous points say so.

use std::collections::HashMap;

use glam::{DMat4, DVec3, DVec4, Mat4};
use rimline::{DepthDirection, ShadowCamera};

use crate::maps::Map;

struct Triangle {
    corners: [DVec4; 3],
    /// The plane: the sign of its product with a point is the side.
    plane: DVec4,
    is_drawn: bool,
}

pub(crate) struct Boundary {
    triangles: Vec<Triangle>,
    /// Homogeneous: a position, or the direction to a light at infinity.
    light: DVec4,
}

impl Triangle {
    fn is_crossed(&self, from: DVec4, to: DVec4) -> bool {
        let [a, b, c] = self.corners;
        if (self.plane.dot(from) > 0.0) == (self.plane.dot(to) > 0.0) {
            return false;
        }
        let side = |p, q| determinant(from, to, p, q) > 0.0;
        let first = side(a, b);
        side(b, c) == first && side(c, a) == first
    }
}

fn determinant(a: DVec4, b: DVec4, c: DVec4, d: DVec4) -> f64 {
    DMat4::from_cols(a, b, c, d).determinant()
}

/// The device depth of a sample, `None` where it casts nothing.
pub(crate) fn sample(map: &Map, x: i64, y: i64) -> Option<f64> {
    let [width, height] = map.size.map(i64::from);
    if x < 0 || y < 0 || x >= width || y >= height {
        return None;
    }
    let depth = f64::from(map.depths[(y * width + x) as usize]);
    let is_far = depth.is_nan() || if map.is_reversed { depth < f64::from(f32::MIN_POSITIVE) } else { depth >= 1.0 };
    (!is_far).then(|| depth.clamp(0.0, 1.0))
}

/// The triangles of cells, from their first corners. `spreads`: those with a depth beside a marked edge are drawn, too.
fn triangles(
    is_reversed: bool,
    threshold: f64,
    spreads: bool,
    positions: impl Iterator<Item = [i64; 2]>,
    sample: &dyn Fn([i64; 2]) -> Option<f64>,
    vertex: &dyn Fn([i64; 2]) -> DVec4,
) -> Vec<Triangle> {
    let is_marked = |a: [i64; 2], b: [i64; 2]| match (sample(a), sample(b)) {
        (None, None) => false,
        (Some(a), Some(b)) => (a - b).abs() > threshold,
        _ => true,
    };
    // How far apart two depths are among all numbers of 32 bits.
    let rank = |at: [i64; 2]| match sample(at) {
        Some(depth) => {
            let unit = if depth < f64::from(f32::MIN_POSITIVE) { 0 } else { i64::from((depth as f32).to_bits()) };
            if is_reversed { 0x3f80_0000 - unit } else { unit }
        }
        None => 0x7fff_ffff,
    };
    let mut triangles = Vec::new();
    for [x, y] in positions {
        let [a, b, c, d] = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]];
        let is_cut_from_b = (rank(a) - rank(d)).abs() > (rank(b) - rank(c)).abs();
        // The corner between the edges, and the two ends of the diagonal.
        // The half with b or, where that is on the cut, with a is the first.
        let halves = if is_cut_from_b { [[a, b, c], [d, b, c]] } else { [[b, a, d], [c, a, d]] };
        let is_beside_edge = |at: &[i64; 2]| {
            let [x, y] = *at;
            sample(*at).is_some()
                && [[x - 1, y], [x + 1, y], [x, y - 1], [x, y + 1]].iter().any(|&there| is_marked(*at, there))
        };
        let are_drawn = halves.map(|[between, p, q]| {
            is_marked(between, p) || is_marked(between, q) || spreads && [between, p, q].iter().any(is_beside_edge)
        });
        for ([between, p, q], is_drawn) in halves.into_iter().zip(are_drawn) {
            let corners = [between, p, q].map(vertex);
            if corners.iter().all(|corner| corner.w == 0.0) {
                continue;
            }
            let axis = |axis: DVec4| determinant(axis, corners[0], corners[1], corners[2]);
            let plane = DVec4::new(axis(DVec4::X), axis(DVec4::Y), axis(DVec4::Z), axis(DVec4::W));
            triangles.push(Triangle { corners, plane, is_drawn });
        }
    }
    triangles
}

fn near(camera: &ShadowCamera) -> f64 {
    if camera.depth == DepthDirection::Reversed { 1.0 } else { 0.0 }
}

/// The positions of a map's samples, moved by parts of a texel, at a depth.
pub(crate) fn positions(
    camera: &ShadowCamera,
    size: [u32; 2],
    [right, down]: [f64; 2],
) -> impl Fn([i64; 2], f64) -> DVec3 + use<> {
    let matrix = Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4().inverse();
    let origin = DVec3::from_array(camera.origin.map(f64::from));
    let [width, height] = size.map(f64::from);
    move |[x, y], depth| {
        let [x, y] = [(x as f64 + 0.5 + right) / width * 2.0 - 1.0, 1.0 - (y as f64 + 0.5 + down) / height * 2.0];
        let point = matrix * DVec4::new(x, y, depth, 1.0);
        point.truncate() / point.w + origin
    }
}

/// Names of the rays of samples of a cube's maps. Along the axes of the cube, with the largest component as many as
/// there are cells, all are near integers.
pub(crate) fn names(cameras: &[ShadowCamera; 6], side: u32) -> impl Fn(usize, [i64; 2]) -> [i64; 3] + use<> {
    let way = cameras.map(|camera| {
        let position = positions(&camera, [side; 2], [0.0; 2]);
        move |at| position(at, 0.5) - position(at, near(&camera))
    });
    let cells = f64::from(side) - 1.0;
    // The middle of a map is between its outermost samples.
    let middle = |face: usize| (way[face]([0, 0]) + way[face]([i64::from(side) - 1; 2])).normalize();
    let axes = [middle(0), middle(2), middle(4)];
    move |face, at| {
        let ray = DVec3::from_array(axes.map(|axis| axis.dot(way[face](at))));
        (ray / ray.abs().max_element() * cells).to_array().map(|part| part.round() as i64)
    }
}

impl Boundary {
    /// The boundary of a map, moved by parts of a texel. Edges are marked where depths differ by more than the
    /// threshold, or everywhere if it is negative.
    pub(crate) fn edited(map: &Map, camera: &ShadowCamera, light: DVec4, threshold: f64, by: Option<[f64; 2]>) -> Self {
        let [right, down] = by.unwrap_or([0.0; 2]);
        let position = positions(camera, map.size, [right, down]);
        let vertex = |at: [i64; 2]| {
            if let Some(depth) = sample(map, at[0], at[1]) {
                return position(at, depth).extend(1.0);
            }
            (position(at, 0.5) - position(at, near(camera))).normalize().extend(0.0)
        };
        let [width, height] = map.size.map(i64::from);
        let cells = (-1..height).flat_map(|y| (-1..width).map(move |x| [x, y]));
        let sample = |[x, y]: [i64; 2]| sample(map, x, y);
        let triangles = triangles(map.is_reversed, threshold, by.is_some(), cells, &sample, &vertex);
        Self { triangles, light }
    }

    /// The boundary of six maps around a light. Samples whose rays are the same are one.
    pub(crate) fn cube(maps: &[Option<Map>; 6], cameras: &[ShadowCamera; 6], light: DVec3, threshold: f64) -> Self {
        let side = maps.iter().flatten().map(|map| map.size[0]).max().unwrap_or(3);
        let is_reversed = cameras[0].depth == DepthDirection::Reversed;
        let position = cameras.each_ref().map(|camera| positions(camera, [side; 2], [0.0; 2]));
        let name = names(cameras, side);
        // The nearest depth of each ray, and the first sample that it has.
        let mut rays: HashMap<[i64; 3], (Option<f64>, DVec4)> = HashMap::new();
        let side = i64::from(side);
        let all = || (0..6).flat_map(move |face| (0..side * side).map(move |at| (face, [at % side, at / side])));
        for (face, at) in all() {
            let depth = maps[face].as_ref().and_then(|map| sample(map, at[0], at[1]));
            let there = rays.entry(name(face, at)).or_insert((depth, DVec4::ZERO));
            there.0 = match (there.0, depth) {
                (Some(a), Some(b)) => Some(if is_reversed { a.max(b) } else { a.min(b) }),
                (a, b) => a.or(b),
            };
        }
        for (face, at) in all() {
            if let Some((depth, vertex)) = rays.get_mut(&name(face, at)).filter(|ray| ray.1 == DVec4::ZERO) {
                let far = || (position[face](at, near(&cameras[face])) - light).normalize().extend(0.0);
                *vertex = depth.map_or_else(far, |depth| position[face](at, depth).extend(1.0));
            }
        }
        let of_face = |face: usize| {
            let cells = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| [x, y]));
            let ray = |at: [i64; 2]| rays[&name(face, at)];
            triangles(is_reversed, threshold, false, cells, &|at| ray(at).0, &|at| ray(at).1)
        };
        Self { triangles: (0..6).flat_map(of_face).collect(), light: light.extend(1.0) }
    }

    fn is_odd(&self, from: DVec4, to: DVec4, drawn_only: bool) -> bool {
        let counted = self.triangles.iter().filter(|triangle| triangle.is_drawn || !drawn_only);
        counted.filter(|triangle| triangle.is_crossed(from, to)).count() % 2 == 1
    }

    /// Whether the way to the light crosses the boundary.
    pub(crate) fn is_dark(&self, point: DVec3) -> bool {
        self.is_odd(point.extend(1.0), self.light, false)
    }

    /// The parity that a ray sees from a point of the near rectangle on.
    pub(crate) fn parity(&self, from: DVec3, to: DVec3) -> bool {
        self.is_odd(from.extend(1.0), to.extend(1.0), true) ^ self.is_dark(from)
    }
}
