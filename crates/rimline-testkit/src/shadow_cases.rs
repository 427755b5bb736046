//! Meshes, points and lights for queries of occluder counts: ordinary ones, and ones that tie.

use crate::shapes::{self, Shape};
use rimline::Light;
use rimline::mesh::NO_FACE;

use super::cases::{hard_positions, random_soup, topologies};
use super::random::Random;

/// A query and what it is called.
#[derive(Clone, Debug)]
pub struct ShadowCase {
    pub name: String,
    pub shape: Shape,
    pub points: Vec<[f32; 3]>,
    pub lights: Vec<Light>,
}

/// A point at a vertex, on an edge, on a face or in its plane, as exactly as rounding lets it be.
fn on_face(random: &mut Random, shape: &Shape) -> [f32; 3] {
    let face = shape.faces[random.below(shape.faces.len())];
    let [a, b, c] = face.map(|v| shape.positions[v as usize]);
    let (s, t) = match random.below(5) {
        0 => (0.0, 0.0),
        1 => (0.5, 0.0),
        2 => (0.25, 0.5),
        3 => (random.between(0.0, 0.5), random.between(0.0, 0.5)),
        _ => (random.between(-2.0, 2.0), random.between(-2.0, 2.0)),
    };
    std::array::from_fn(|i| a[i] + s * (b[i] - a[i]) + t * (c[i] - a[i]))
}

/// Puts half of the points on faces, as rounding lets them be, and names a face for most: the one that the point is on,
/// or any.
pub fn put_on_faces(
    random: &mut Random,
    positions: &[[f32; 3]],
    faces: &[[u32; 3]],
    points: &mut [[f32; 3]],
) -> Vec<u32> {
    let mut name = |point: &mut [f32; 3]| {
        let kind = random.below(8);
        if kind == 0 {
            return NO_FACE;
        }
        let face = random.below(faces.len());
        if kind > 3 {
            *point = centre(faces[face].map(|vertex| positions[vertex as usize]));
        }
        face as u32
    };
    points.iter_mut().map(&mut name).collect()
}

/// The centre of a face in `f32`, which is seldom in it exactly.
#[must_use]
pub fn centre([a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    [0, 1, 2].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0)
}

/// Points and lights about a shape of size `scale` at `offset`, every other one on the shape.
fn around(random: &mut Random, name: &str, shape: Shape, scale: f32, offset: f32, counts: [usize; 2]) -> ShadowCase {
    let free = |random: &mut Random| random.direction().map(|c| c * random.between(0.0, 2.5) * scale + offset);
    let mut point = |index: usize| if index.is_multiple_of(2) { free(random) } else { on_face(random, &shape) };
    let points: Vec<_> = (0..counts[0]).map(&mut point).collect();
    let near: Vec<_> = (0..counts[1]).map(|index| point(index / 4)).collect();
    let lights = near.into_iter().enumerate().map(|(index, near)| match index % 4 {
        0 => Light::point(near),
        1 => Light::directional(near.map(|c| c - offset)),
        2 => Light::homogeneous([near[0] * 1.7, near[1] * 1.7, near[2] * 1.7, 1.7]),
        _ => Light::homogeneous([near[0] * 0.5, near[1] * 0.5, near[2] * 0.5, 0.5]),
    });
    let lights = lights.filter(|light| light.to_array() != [0.0; 4]).collect();
    ShadowCase { name: name.to_owned(), shape, points, lights }
}

/// Boxes with whole corners, some touching or equal, their sides cut into triangles, and the boxes.
pub fn boxes(random: &mut Random, count: usize) -> (Shape, Vec<[[i32; 3]; 2]>) {
    let corners: Vec<[[i32; 3]; 2]> = (0..count)
        .map(|_| {
            let low = [(); 3].map(|()| random.below(5) as i32 - 3);
            [low, low.map(|low| low + 1 + random.below(3) as i32)]
        })
        .collect();
    let placed = |[low, high]: &[[i32; 3]; 2]| {
        shapes::cube().placed(|p| [0, 1, 2].map(|axis| if p[axis] < 0.0 { low[axis] } else { high[axis] } as f32))
    };
    (Shape::joined(&corners.iter().map(placed).collect::<Vec<_>>()), corners)
}

/// Whole points and lights about [`boxes`]: segments run through edges and corners and along sides all the time.
pub fn lattice(random: &mut Random, counts: [usize; 3]) -> (ShadowCase, Vec<[[i32; 3]; 2]>) {
    let (shape, corners) = boxes(random, counts[0]);
    let whole = |random: &mut Random| -> [f32; 3] { std::array::from_fn(|_| random.below(11) as f32 - 5.0) };
    let points = (0..counts[1]).map(|_| whole(random)).collect();
    let lights = (0..counts[2]).map(|index| (index, whole(random)));
    let lights = lights.map(|(index, at)| match index % 3 {
        0 => Light::directional(at),
        1 => Light::homogeneous([2.0 * at[0], 2.0 * at[1], 2.0 * at[2], 2.0]),
        _ => Light::point(at),
    });
    let lights = lights.filter(|light| light.to_array() != [0.0; 4]).collect();
    (ShadowCase { name: "lattice".to_owned(), shape, points, lights }, corners)
}

/// Everything, `points` and up to `lights` a case.
pub fn shadow_cases(random: &mut Random, points: usize, lights: usize) -> Vec<ShadowCase> {
    let counts = [points, lights];
    let mut found = Vec::new();
    for (name, positions, mesh) in topologies() {
        let shape = Shape { positions, faces: mesh.faces().to_vec() };
        found.push(around(random, &name, shape, 1.0, 0.0, counts));
    }
    for scale in [1.0, 1e-15, 1e-40, 9e11, 1e20] {
        let mut soup = random_soup(random);
        soup.positions.iter_mut().flatten().for_each(|c| *c *= scale);
        found.push(around(random, &format!("soup by {scale}"), soup, scale, 0.0, counts));
    }
    for (name, (_, positions, mesh), _) in hard_positions(random) {
        let shape = Shape { positions, faces: mesh.faces().to_vec() };
        let middle = shape.positions[0][1].abs();
        let (scale, offset) = if name.starts_with("moved") { (1.0, middle) } else { (middle.max(1e-44), 0.0) };
        found.push(around(random, &name, shape, scale, offset, counts));
    }
    found.push(far_lights(random, counts));
    found.push(lattice(random, [6, points, lights]).0);
    found.push(any_magnitude(random, counts));
    found.push(not_finite(random, counts));
    found.push(grazing(random, counts));
    found
}

/// Faces far from the origin, each alone in a box, with a corner in the box's corner. Lights at infinity lie in the
/// directions of such corners as seen from the origin; points lie next to the origin, so near that the difference to a
/// corner is hardly any more, in `f32` or in `f64`. So segments pass the corners of boxes, through a face's tip or
/// beside it, by less than the roundings of a test for a box.
fn grazing(random: &mut Random, counts: [usize; 2]) -> ShadowCase {
    let mut shape = Shape { positions: vec![[0.0; 3]], faces: Vec::new() };
    let mut lights = Vec::new();
    // Faces a cluster, `CLUSTER` of src/cpu/query/shadow_boxes.rs; all but one name a vertex twice and so are in no box.
    let cluster = 32;
    for number in 0..16 {
        let corner: [f32; 3] = std::array::from_fn(|_| random.between(1e6, 2e6));
        // Along one pair of axes the corner is where the box is seen to end from the origin.
        let (low, high) = (number % 3, (number + 1) % 3);
        let first = shape.positions.len() as u32;
        shape.positions.push(corner);
        for _ in 0..2 {
            let mut other = corner;
            for (axis, at) in other.iter_mut().enumerate() {
                let by = random.between(100.0, 1e5);
                *at += if axis == low {
                    by
                } else if axis == high {
                    -by
                } else {
                    by * [1.0, -1.0][random.below(2)]
                };
            }
            shape.positions.push(other);
        }
        shape.faces.push([first, first + 1, first + 2]);
        shape.faces.extend(std::iter::repeat_n([0; 3], cluster - 1));
        lights.push(Light::directional(corner.map(|c| c / 1_048_576.0)));
    }
    // Some way towards a light, of a few units in the last place of its corner, and aside by a part of one.
    let mut point = |index: usize| -> [f32; 3] {
        let size = [1.0, 2e-9][index / lights.len() % 2];
        let (way, aside) = (random.between(-1.0, 1.0) * size, random.direction().map(|c| c * 0.03 * size));
        std::array::from_fn(|axis| way * lights[index % lights.len()].xyz[axis] + aside[axis])
    };
    let points = (0..8 * counts[0]).map(&mut point).collect();
    ShadowCase { name: "grazing".to_owned(), shape, points, lights }
}

/// Boxes so large, and lights so far away along their sides, that a w that is next to nothing, or lost, decides.
fn far_lights(random: &mut Random, counts: [usize; 2]) -> ShadowCase {
    let (mut case, _) = lattice(random, [6, counts[0], 1]);
    let scale = 2.0_f32.powi(36);
    case.shape.positions.iter_mut().chain(&mut case.points).flatten().for_each(|c| *c *= scale);
    case.lights = (0..counts[1])
        .map(|index| {
            let w = random.between(-149.0, -60.0).exp2();
            let mut light: [f32; 3] = std::array::from_fn(|_| random.below(5) as f32 * scale * w);
            light[index % 3] = if random.below(2) == 0 { 1.0 } else { -1.0 };
            Light::homogeneous([light[0], light[1], light[2], w])
        })
        .collect();
    ShadowCase { name: "far lights".to_owned(), ..case }
}

/// Coordinates of any exponent, or within a bit of another.
fn any_magnitude(random: &mut Random, counts: [usize; 2]) -> ShadowCase {
    let mut like = 1.0_f32;
    let mut number = |random: &mut Random| {
        like = match random.below(6) {
            0 => 0.0,
            1 => like,
            2 => f32::from_bits(like.to_bits() ^ 1),
            3 => f32::from_bits(random.next_u64() as u32 & 0x807f_ffff),
            4 => random.between(-1.0, 1.0),
            _ => f32::from_bits(random.next_u64() as u32),
        };
        like = if like.is_finite() { like } else { 1.0 };
        like
    };
    let mut vertex = |random: &mut Random| -> [f32; 3] { std::array::from_fn(|_| number(random)) };
    let positions: Vec<_> = (0..40).map(|_| vertex(random)).collect();
    let points =
        (0..counts[0]).map(|_| if random.below(3) == 0 { positions[random.below(40)] } else { vertex(random) });
    let points = points.collect();
    let faces = (0..150).map(|_| std::array::from_fn(|_| random.below(40) as u32)).collect();
    let lights = (0..counts[1]).map(|index| {
        let [x, y, z] = if index % 4 == 0 { positions[index % 40] } else { vertex(random) };
        let w = [1.0, 0.0, vertex(random)[0].abs(), 1e-30, 1e30][index % 5];
        Light::homogeneous([x, y, z, w])
    });
    let lights = lights.filter(|light| light.to_array() != [0.0; 4]).collect();
    ShadowCase { name: "any magnitude".to_owned(), shape: Shape { positions, faces }, points, lights }
}

/// Vertices and points that are infinite or NaN, here and there.
fn not_finite(random: &mut Random, counts: [usize; 2]) -> ShadowCase {
    let mut case = around(random, "not finite", shapes::torus(20, 14, 0.7, 0.3), 1.0, 0.0, counts);
    for (index, value) in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY].into_iter().enumerate() {
        let vertices = case.shape.positions.len();
        case.shape.positions[random.below(vertices)][index] = value;
        let points = case.points.len();
        case.points[random.below(points)][index] = value;
    }
    case
}
