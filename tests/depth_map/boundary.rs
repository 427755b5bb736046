//! The boundary between light and shadow of a depth map, in `f64`, without code of the library. Segments cross its
//! triangles where determinants of homogeneous points say so.

use std::collections::HashMap;

use glam::{DMat4, DVec3, DVec4, Mat4};
use rimline::{DepthDirection, ShadowCamera};
use wgpu::TextureFormat;

use crate::cube::{Cube, merged, on_rays, parted};
use crate::maps::Map;
use crate::picture::{EVERY_CELL, differences};
use crate::rules::{CELL, Rule, TRIANGLES, cast, entries, is_split, rank};

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
    cast(map, x, y).map(f64::from)
}

/// The triangles of a map, and which of them are drawn if edges are marked where depths differ by more than the
/// threshold, or everywhere if it is negative. Without `has_border` the map is one of a cube.
fn triangles(
    map: &Map,
    (threshold, bits): (f32, usize),
    has_border: bool,
    vertex: &dyn Fn([i64; 2]) -> DVec4,
) -> Vec<Triangle> {
    let method = if threshold < 0.0 { EVERY_CELL } else { differences(threshold) };
    let rule = Rule::new(method, bits, map.is_reversed, TextureFormat::R32Float);
    let entries = entries(map, &[], &rule, has_border).0;
    let drawn: HashMap<_, _> = entries.into_iter().map(|entry| (entry & CELL, entry)).collect();
    let (border, [width, height]) = (i64::from(has_border), map.size.map(i64::from));
    let mut triangles = Vec::new();
    for [x, y] in (-border..height - 1 + border).flat_map(|y| (-border..width - 1 + border).map(move |x| [x, y])) {
        let corners = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]];
        let is_split = is_split(corners.map(|[x, y]| rank(map, cast(map, x, y))));
        let entry = drawn.get(&(((y + 1) * (width + 1) + x + 1) as u32)).copied().unwrap_or(0);
        let [a, b, c, d] = corners.map(vertex);
        let halves = if is_split { [[a, b, c], [b, d, c]] } else { [[a, b, d], [a, d, c]] };
        for (corners, bit) in halves.into_iter().zip(TRIANGLES) {
            if corners.iter().all(|corner| corner.w == 0.0) {
                continue;
            }
            let axis = |axis: DVec4| determinant(axis, corners[0], corners[1], corners[2]);
            let plane = DVec4::new(axis(DVec4::X), axis(DVec4::Y), axis(DVec4::Z), axis(DVec4::W));
            triangles.push(Triangle { corners, plane, is_drawn: entry & bit != 0 });
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
    /// The boundary of a map, moved by parts of a texel.
    pub(crate) fn edited(map: &Map, camera: &ShadowCamera, light: DVec4, threshold: f32, by: Option<[f64; 2]>) -> Self {
        let position = positions(camera, map.size, by.unwrap_or([0.0; 2]));
        let vertex = |at: [i64; 2]| {
            if let Some(depth) = sample(map, at[0], at[1]) {
                return position(at, depth).extend(1.0);
            }
            (position(at, 0.5) - position(at, near(camera))).normalize().extend(0.0)
        };
        Self { triangles: triangles(map, (threshold, 1 + usize::from(by.is_some())), true, &vertex), light }
    }

    /// The boundary of six maps around a light. Samples whose rays are the same are one: the nearest.
    pub(crate) fn cube(cube: &Cube, threshold: f32) -> Self {
        let (side, is_reversed) = (cube.side, cube.cameras[0].depth == DepthDirection::Reversed);
        let rays = on_rays(&cube.cameras, side);
        let of_face = |(face, depths): (u32, Vec<f32>)| {
            let map = Map { size: [side; 2], is_reversed, depths };
            let vertex = |[x, y]: [i64; 2]| {
                let (first, at) = rays[&(face, [x as u32, y as u32])][0];
                let camera = &cube.cameras[first as usize];
                let position = |depth| positions(camera, [side; 2], [0.0; 2])(at.map(i64::from), depth);
                let far = || (position(near(camera)) - cube.light).normalize().extend(0.0);
                sample(&map, x, y).map_or_else(far, |depth| position(depth).extend(1.0))
            };
            triangles(&map, (threshold, 1), false, &vertex)
        };
        let faces = parted(side, &merged(cube, &[]).0);
        Self { triangles: (0..).zip(faces).flat_map(of_face).collect(), light: cube.light.extend(1.0) }
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
