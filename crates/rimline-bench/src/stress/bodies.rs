//! The stress scenes' meshes.

use crate::random::Random;
use crate::shapes::{self, Shape, turn};

/// Subdivisions with which a sphere has about `faces` faces.
fn subdivisions(faces: usize) -> u32 {
    root(faces, 8)
}

/// The whole number whose square times `each` comes closest to `faces`, at least 1.
fn root(faces: usize, each: usize) -> u32 {
    let low = (faces / each).isqrt();
    let is_low = faces.saturating_sub(each * low * low) <= (each * (low + 1) * (low + 1)).saturating_sub(faces);
    (if is_low { low } else { low + 1 }).max(1) as u32
}

pub(crate) fn blob(faces: usize) -> Shape {
    shapes::blob(subdivisions(faces), 0.3, 5)
}

pub(crate) fn sphere(faces: usize) -> Shape {
    shapes::sphere(subdivisions(faces))
}

/// A lumpy body with a vertex at the origin.
pub(crate) fn through_origin(faces: usize) -> Shape {
    let body = blob(faces);
    let by = body.positions.get(body.positions.len() / 2).map_or([0.0; 3], |p| p.map(|c| -c));
    moved(body, by)
}

/// The tilted plate, its vertices moved off it at random, by up to `amplitude` or so.
pub(crate) fn rough_plate(faces: usize, amplitude: f32) -> Shape {
    let mut random = Random::new(11);
    let mut shape = tilted_plate(faces);
    for position in &mut shape.positions {
        let by = amplitude * random.between(-1.0, 1.0);
        let [x, y, z] = *position;
        *position = [x + 0.2 * by, y + by, z - 0.4 * by];
    }
    shape
}

/// A sphere squeezed in Y and Z, then tilted. The body and most of its faces are about `aspect` times as long as thick, so for
/// the largest aspects rounding moves vertices by more than the thickness.
pub(crate) fn needle(faces: usize, aspect: f32) -> Shape {
    stretched(sphere(faces), [1.0, 1.0 / aspect, 1.0 / aspect]).placed(|[x, y, z]| [x, y + 0.7 * x, z - 0.4 * x])
}

/// A lumpy body whose faces are split in three by a point over the middle of an edge, at `1/aspect` of the face's height.
/// The triangle at this edge is a sliver; rounding may turn it over.
pub(crate) fn slivers(faces: usize, aspect: f32) -> Shape {
    let mut shape = blob(faces / 3);
    let whole = std::mem::take(&mut shape.faces);
    for [a, b, c] in whole {
        let [p, q, r] = [a, b, c].map(|v| shape.positions.get(v as usize).copied().unwrap_or_default());
        let inside = std::array::from_fn(|axis| {
            let middle = 0.5 * (p[axis] + q[axis]);
            middle + (r[axis] - middle) / aspect
        });
        let d = shape.positions.len() as u32;
        shape.positions.push(inside);
        shape.faces.extend([[a, b, d], [b, c, d], [c, a, d]]);
    }
    shape
}

/// A flat parallelogram: [`tilt`] of a square of side 2. No edge is along an axis, and the points of the plane are rounded.
pub(crate) fn tilted_plate(faces: usize) -> Shape {
    let side = root(faces, 2);
    shapes::plane_grid(side, side).placed(tilt)
}

/// A point of the plane of [`tilted_plate`], rounded.
pub(crate) fn tilt([x, _, z]: [f32; 3]) -> [f32; 3] {
    [x + 0.1 * z, 0.3 * x - 0.7 * z, z - 0.2 * x]
}

/// A flat plate with cells of unequal size, of [`on_lattice_plane`]: every point is on the plane exactly, and determinants
/// need more bits than f64 has.
pub(crate) fn lattice_plate(faces: usize) -> Shape {
    let mut random = Random::new(13);
    let side = root(faces, 2);
    let step = 2.0 * LATTICE / side as f32;
    let mut plate = shapes::plane_grid(side, side);
    for position in &mut plate.positions {
        let [a, b] = [position[0], position[2]]
            .map(|c| (c * LATTICE + 0.25 * step * random.between(-1.0, 1.0)).clamp(-LATTICE, LATTICE).round());
        *position = on_lattice_plane(a, b);
    }
    plate
}

/// The coordinates of the lattice plate are whole numbers over this.
pub(crate) const LATTICE: f32 = 2_097_152.0;

/// A point of the lattice plate's plane. Nothing is rounded if both are whole numbers from −[`LATTICE`] to [`LATTICE`].
pub(crate) fn on_lattice_plane(a: f32, b: f32) -> [f32; 3] {
    [a + 2.0 * b, 3.0 * a - b, b - 2.0 * a].map(|c| c / LATTICE)
}

/// The least power of two that is at least `1/n`.
fn lattice_step(n: u32) -> f32 {
    1.0 / (1_u32 << n.max(1).ilog2()) as f32
}

/// A linear map by small multiples of 1/4, which rounds nothing on a lattice.
fn tilt_on_lattice([x, y, z]: [f32; 3]) -> [f32; 3] {
    [x + 0.5 * y - 0.25 * z, y + 0.75 * z - 0.5 * x, z + 0.25 * x - y]
}

/// A cube on a lattice, moved by `shift` of its edges along X, then sheared: each of its six sides is on a plane exactly.
/// Sides share no vertices; welding joins them.
pub(crate) fn lattice_box(faces: usize, shift: i32) -> Shape {
    let n = root(faces, 12);
    let step = lattice_step(n);
    let mut shape = Shape::default();
    for side in 0..6 {
        let axis = side / 2;
        let is_far = side % 2 == 1;
        let first = shape.positions.len() as u32;
        for i in 0..=n {
            for j in 0..=n {
                let mut lattice = [0; 3];
                lattice[axis] = if is_far { n as i32 } else { 0 };
                lattice[(axis + 1) % 3] = i as i32;
                lattice[(axis + 2) % 3] = j as i32;
                lattice[0] += shift * n as i32;
                shape.positions.push(tilt_on_lattice(lattice.map(|c| c as f32 * step)));
            }
        }
        for i in 0..n {
            for j in 0..n {
                let at = |i: u32, j: u32| first + i * (n + 1) + j;
                let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                shape.faces.extend(if is_far { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
            }
        }
    }
    shape
}

/// Two boxes of [`lattice_box`] that have a side in common, each with faces of its own there.
pub(crate) fn touching_boxes(faces: usize) -> Shape {
    Shape::joined([&lattice_box(faces / 2, 0), &lattice_box(faces / 2, 1)])
}

/// A capsule along Y, bent at its middle by `degrees`, like skinning by blended matrices: the inner side may fold over
/// itself.
pub(crate) fn bent_limb(faces: usize, degrees: u32) -> Shape {
    let segments = root(faces, 4).max(3);
    let rings = 2 * segments;
    let (sin, cos) = turn(degrees, 360);
    let mut shape = Shape::default();
    for ring in 0..=rings {
        let (radius, y) = capsule(ring, rings);
        for segment in 0..if ring == 0 || ring == rings { 1 } else { segments } {
            let (sin_u, cos_u) = turn(segment, segments);
            shape.positions.push(bend([radius * cos_u, y, radius * sin_u], sin, cos));
        }
    }
    let last = shape.positions.len() as u32 - 1;
    for segment in 0..segments {
        let next = (segment + 1) % segments;
        let top = last - segments;
        shape.faces.extend([[0, 1 + segment, 1 + next], [last, top + next, top + segment]]);
        for ring in 0..rings - 2 {
            let (low, high) = (1 + ring * segments, 1 + (ring + 1) * segments);
            let [a, b, c, d] = [low + segment, low + next, high + next, high + segment];
            shape.faces.extend([[a, c, b], [a, d, c]]);
        }
    }
    shape
}

/// Radius and height at a ring of a capsule of radius 0.5 that reaches from −2 to 2.
fn capsule(ring: u32, rings: u32) -> (f32, f32) {
    let quarter = rings / 4;
    let cap = |step: u32| turn(step, 4 * quarter.max(1));
    if ring <= quarter {
        let (sin, cos) = cap(ring);
        (0.5 * sin, -1.5 - 0.5 * cos)
    } else if ring >= rings - quarter {
        let (sin, cos) = cap(rings - ring);
        (0.5 * sin, 1.5 + 0.5 * cos)
    } else {
        (0.5, 3.0 * (ring - quarter) as f32 / (rings - 2 * quarter) as f32 - 1.5)
    }
}

/// Turns about Z what is above y = 0.5, keeps what is below y = −0.5, and blends the matrices between.
fn bend([x, y, z]: [f32; 3], sin: f32, cos: f32) -> [f32; 3] {
    let along = (y + 0.5).clamp(0.0, 1.0);
    let weight = along * along * (3.0 - 2.0 * along);
    let turned = [cos * x - sin * y, sin * x + cos * y];
    [x + weight * (turned[0] - x), y + weight * (turned[1] - y), z]
}

/// A torus with further faces, which name a vertex twice, have their corners on a line or at one position, or lie on a face
/// of the torus with the same or the opposite orientation.
pub(crate) fn with_degenerate_faces(faces: usize) -> Shape {
    let segments = root(faces * 5 / 6, 4).max(3);
    let mut shape = shapes::torus(2 * segments, segments, 1.0, 0.4);
    for (index, [a, b, c]) in shape.faces.clone().into_iter().enumerate().step_by(5) {
        let v = shape.positions.len() as u32;
        let p = shape.positions.get(a as usize).copied().unwrap_or_default();
        match index / 5 % 5 {
            0 => shape.faces.push([a, b, c]),
            1 => shape.faces.push([c, b, a]),
            2 => shape.faces.push([a, b, b]),
            // On a line through the origin: doubling rounds nothing.
            3 => {
                shape.positions.extend([p.map(|c| 2.0 * c), p.map(|c| 4.0 * c)]);
                shape.faces.push([a, v, v + 1]);
            }
            // Three vertices at one position, which welding makes one.
            _ => {
                shape.positions.extend([p; 2]);
                shape.faces.push([a, v, v + 1]);
            }
        }
    }
    shape
}

pub(crate) fn moebius(faces: usize) -> Shape {
    let strips = root(faces, 16);
    shapes::moebius(8 * strips, strips)
}

pub(crate) fn three_sheets(faces: usize) -> Shape {
    shapes::three_sheets((faces / 6).max(1) as u32)
}

pub(crate) fn moved(shape: Shape, by: [f32; 3]) -> Shape {
    shape.placed(|p| std::array::from_fn(|axis| p[axis] + by[axis]))
}

pub(crate) fn scaled(shape: Shape, by: f32) -> Shape {
    stretched(shape, [by; 3])
}

pub(crate) fn stretched(shape: Shape, by: [f32; 3]) -> Shape {
    shape.placed(|p| std::array::from_fn(|axis| p[axis] * by[axis]))
}
