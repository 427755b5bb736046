//! Triangle meshes made by code, of any size: for tests, benches and first tries.
//!
//! Faces are counter-clockwise outside and vertices are welded already, so [`Mesh::from_faces`] serves. A count too
//! small for the shape is taken as the least that makes one, a count above [`MAX_COUNT`] as [`MAX_COUNT`].

use std::collections::HashMap;

use rimline::mesh::{Mesh, MeshError};

use crate::random::Random;

/// The most rings, segments, subdivisions and the like: with it in every direction, face and vertex indices still fit.
pub const MAX_COUNT: u32 = 1 << 13;

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// Vertex positions; no two are meant as the same point.
    pub positions: Vec<[f32; 3]>,
    pub faces: Vec<[u32; 3]>,
}

impl Shape {
    /// The shape's faces and edge records.
    pub fn mesh(&self) -> Result<Mesh, MeshError> {
        Mesh::from_faces(self.positions.len(), self.faces.clone())
    }

    /// The same shape with its vertices and its faces in a random order, which `seed` determines. Each face keeps its
    /// first corner and its orientation. Indices out of range stay as they are.
    #[must_use]
    pub fn shuffled(&self, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let new_index = permutation(self.positions.len(), &mut random);
        let mut positions = vec![[0.0; 3]; self.positions.len()];
        for (&position, &new) in self.positions.iter().zip(&new_index) {
            positions[new as usize] = position;
        }
        let order = permutation(self.faces.len(), &mut random);
        let renumbered = |v: u32| new_index.get(v as usize).copied().unwrap_or(v);
        let faces = order.iter().map(|&old| self.faces[old as usize].map(renumbered)).collect();
        Self { positions, faces }
    }

    pub fn joined<'a>(shapes: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut joined = Self::default();
        for shape in shapes {
            let first = joined.positions.len() as u32;
            joined.positions.extend(&shape.positions);
            joined.faces.extend(shape.faces.iter().map(|face| face.map(|vertex| vertex + first)));
        }
        joined
    }

    /// The same shape with other positions, in the same order.
    #[must_use]
    pub fn placed(mut self, transform: impl Fn([f32; 3]) -> [f32; 3]) -> Self {
        self.positions.iter_mut().for_each(|position| *position = transform(*position));
        self
    }

    fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.faces.extend([[a, b, c], [a, c, d]]);
    }
}

/// A random order of `0..count` (Fisher and Yates).
fn permutation(count: usize, random: &mut Random) -> Vec<u32> {
    let mut order: Vec<u32> = (0..count as u32).collect();
    for last in (1..count).rev() {
        // The high product word: a number below last + 1, near enough uniform for any mesh.
        let other = (u128::from(random.next_u64()) * (last as u128 + 1)) >> 64;
        order.swap(last, other as usize);
    }
    order
}

/// A closed torus around the Y axis: `rings` cross-sections of `segments` vertices each, at least 3 of both, and
/// `2·rings·segments` faces. `major` is the radius of the circle that the tube's centre runs along, `minor` the tube's.
pub fn torus(rings: u32, segments: u32, major: f32, minor: f32) -> Shape {
    let (rings, segments) = (rings.clamp(3, MAX_COUNT), segments.clamp(3, MAX_COUNT));
    let mut shape = Shape::default();
    for ring in 0..rings {
        let (sin_u, cos_u) = turn(ring, rings);
        for segment in 0..segments {
            let (sin_v, cos_v) = turn(segment, segments);
            let radius = major + minor * cos_v;
            shape.positions.push([radius * cos_u, minor * sin_v, radius * sin_u]);
        }
    }
    for ring in 0..rings {
        let (here, there) = (ring * segments, (ring + 1) % rings * segments);
        for v in 0..segments {
            let w = (v + 1) % segments;
            shape.quad([here + v, here + w, there + w, there + v]);
        }
    }
    shape
}

/// A closed unit sphere of meridians and parallels around the Z axis, as modelling tools make it: `2·segments·(rings −
/// 1)` faces, at least 3 segments and 2 rings.
pub fn globe(segments: u32, rings: u32) -> Shape {
    let (segments, rings) = (segments.clamp(3, MAX_COUNT), rings.clamp(2, MAX_COUNT));
    let mut shape = Shape { positions: vec![[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], faces: Vec::new() };
    for ring in 1..rings {
        let (sin_v, cos_v) = turn(ring, 2 * rings);
        for segment in 0..segments {
            let (sin_u, cos_u) = turn(segment, segments);
            shape.positions.push([sin_v * cos_u, sin_v * sin_u, cos_v]);
        }
    }
    for u in 0..segments {
        let w = (u + 1) % segments;
        let at = |ring: u32, segment: u32| 2 + (ring - 1) * segments + segment;
        shape.faces.push([0, at(1, u), at(1, w)]);
        for ring in 1..rings - 1 {
            shape.quad([at(ring, u), at(ring + 1, u), at(ring + 1, w), at(ring, w)]);
        }
        shape.faces.push([1, at(rings - 1, w), at(rings - 1, u)]);
    }
    shape
}

/// A closed unit sphere: an octahedron whose faces are split into `subdivisions²` triangles each (at least 1), moved
/// out to radius 1. `8·subdivisions²` faces of much the same size, and no poles.
pub fn sphere(subdivisions: u32) -> Shape {
    let n = subdivisions.clamp(1, MAX_COUNT) as i32;
    let (mut shape, mut known) = (Shape::default(), HashMap::new());
    // Points of the octahedron's surface, |x| + |y| + |z| = n, are numbered as they come up.
    let mut vertex = |shape: &mut Shape, point: [i32; 3]| {
        *known.entry(point).or_insert_with(|| {
            let [x, y, z] = point.map(|axis| axis as f32);
            let length = (x * x + y * y + z * z).sqrt();
            shape.positions.push([x / length, y / length, z / length]);
            shape.positions.len() as u32 - 1
        })
    };
    for octant in 0..8 {
        let [x, y, z] = [4, 2, 1].map(|bit| if octant & bit == 0 { 1 } else { -1 });
        // A face given counter-clockwise where x·y·z is positive, mirrored elsewhere.
        let mut face = |corners: [[i32; 2]; 3]| {
            let [a, b, c] = corners.map(|[i, j]| vertex(&mut shape, [x * (n - i - j), y * i, z * j]));
            shape.faces.push(if x * y * z < 0 { [a, c, b] } else { [a, b, c] });
        };
        for i in 0..n {
            for j in 0..n - i {
                face([[i, j], [i + 1, j], [i, j + 1]]);
                if i + j + 1 < n {
                    face([[i + 1, j], [i + 1, j + 1], [i, j + 1]]);
                }
            }
        }
    }
    shape
}

/// [`sphere`] with its vertices moved along their rays by smooth noise, so that radii lie between `1 − amplitude` and
/// `1 + amplitude`: a closed, lumpy body whose silhouettes have cusps and loops. `amplitude` is taken as at most 0.9,
/// a negative one or NaN as 0; `seed` chooses the lumps. No function of the platform's is called, so all platforms
/// give the same bits.
pub fn blob(subdivisions: u32, amplitude: f32, seed: u32) -> Shape {
    // Not clamp, which would keep a NaN.
    let amplitude = if amplitude > 0.0 { amplitude.min(0.9) } else { 0.0 };
    sphere(subdivisions).placed(|position| {
        let radius = 1.0 + amplitude * smooth(position, seed);
        position.map(|axis| axis * radius)
    })
}

/// A closed cube from −1 to 1 on each axis: 8 vertices, 12 faces.
pub fn cube() -> Shape {
    let sign = |vertex: u32, bit: u32| if vertex >> bit & 1 == 1 { 1.0 } else { -1.0 };
    let mut shape =
        Shape { positions: (0..8).map(|v| [sign(v, 0), sign(v, 1), sign(v, 2)]).collect(), faces: Vec::new() };
    // Vertex numbers have bit 0 for +X, bit 1 for +Y, bit 2 for +Z.
    for corners in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
        shape.quad(corners);
    }
    shape
}

/// An open square of two faces, from −1 to 1 on x and y, whose front is towards +z.
pub fn square() -> Shape {
    let positions = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    Shape { positions, faces: vec![[0, 1, 2], [0, 2, 3]] }
}

/// A closed cone whose apex and base centre are hubs of `n` faces each, at least 3: base radius 1 at y = 0, apex at
/// y = 1. `2·n` faces. The hubs are what adjacency by short lists per vertex stumbles over.
pub fn fan(n: u32) -> Shape {
    let n = n.clamp(3, MAX_COUNT * MAX_COUNT);
    let mut shape = Shape { positions: vec![[0.0, 1.0, 0.0], [0.0; 3]], faces: Vec::new() };
    for rim in 0..n {
        let (sin, cos) = turn(rim, n);
        shape.positions.push([cos, 0.0, sin]);
        let (here, next) = (2 + rim, 2 + (rim + 1) % n);
        shape.faces.extend([[0, next, here], [1, here, next]]);
    }
    shape
}

/// An open grid of `n` by `m` squares, at least 1 each, from −1 to 1 in X and Z at y = 0, facing +Y: `2·n·m` faces and
/// `2·(n + m)` boundary edges.
pub fn plane_grid(n: u32, m: u32) -> Shape {
    let (n, m) = (n.clamp(1, MAX_COUNT), m.clamp(1, MAX_COUNT));
    let coordinate = |step: u32, steps: u32| 2.0 * step as f32 / steps as f32 - 1.0;
    let mut shape = Shape::default();
    for i in 0..=n {
        shape.positions.extend((0..=m).map(|j| [coordinate(i, n), 0.0, coordinate(j, m)]));
    }
    for i in 0..n {
        let (here, there) = (i * (m + 1), (i + 1) * (m + 1));
        for j in 0..m {
            shape.quad([here + j, here + j + 1, there + j + 1, there + j]);
        }
    }
    shape
}

/// A Möbius strip of `segments` quads around (at least 3) and `strips` across (at least 1), centre line of radius 1
/// around the Y axis. It has one side and no consistent orientation: the `strips` edges across the seam are
/// inconsistent records, and `2·segments` edges are boundaries.
pub fn moebius(segments: u32, strips: u32) -> Shape {
    let (segments, strips) = (segments.clamp(3, MAX_COUNT), strips.clamp(1, MAX_COUNT));
    let row = strips + 1;
    let mut shape = Shape::default();
    for i in 0..segments {
        let (sin_u, cos_u) = turn(i, segments);
        // Half a turn of the cross-section on one way round.
        let (sin_half, cos_half) = turn(i, 2 * segments);
        for j in 0..row {
            let across = 0.8 * (j as f32 / strips as f32 - 0.5);
            let radius = 1.0 + across * cos_half;
            shape.positions.push([radius * cos_u, across * sin_half, radius * sin_u]);
        }
    }
    for i in 0..segments {
        // Past the seam a row meets the first one end for end.
        let next = |j: u32| {
            if i + 1 < segments { (i + 1) * row + j } else { strips - j }
        };
        for j in 0..strips {
            shape.quad([i * row + j, i * row + j + 1, next(j + 1), next(j)]);
        }
    }
    shape
}

/// Three sheets that meet on one line, the Y axis, of `segments` edges (at least 1): non-manifold. Two sheets run up
/// the line and one down, so each of its edges has one consistent and one boundary record. `6·segments` faces.
pub fn three_sheets(segments: u32) -> Shape {
    let segments = segments.clamp(1, MAX_COUNT);
    let row = segments + 1;
    let height = |step: u32| 2.0 * step as f32 / segments as f32 - 1.0;
    let mut shape = Shape { positions: (0..row).map(|step| [0.0, height(step), 0.0]).collect(), faces: Vec::new() };
    for sheet in 1..=3 {
        let (sin, cos) = turn(sheet, 3);
        shape.positions.extend((0..row).map(|step| [cos, height(step), sin]));
        for low in 0..segments {
            let far = sheet * row + low;
            if sheet == 3 {
                shape.quad([low, far, far + 1, low + 1]);
            } else {
                shape.quad([low, low + 1, far + 1, far]);
            }
        }
    }
    shape
}

/// Smooth noise between −1 and 1: two octaves of value noise, the coarse one with two lattice cells to the unit.
fn smooth(point: [f32; 3], seed: u32) -> f32 {
    let coarse = value(point.map(|axis| 2.0 * axis), seed);
    let fine = value(point.map(|axis| 4.0 * axis), seed.wrapping_add(1));
    (2.0 * coarse + fine) / 3.0
}

/// Random values at integer points, blended between them with first derivatives 0 there.
fn value(point: [f32; 3], seed: u32) -> f32 {
    let cell = point.map(f32::floor);
    let blend: [f32; 3] = std::array::from_fn(|axis| {
        let t = point[axis] - cell[axis];
        t * t * (3.0 - 2.0 * t)
    });
    let corner = |offset: [i32; 3]| at_lattice(std::array::from_fn(|axis| cell[axis] as i32 + offset[axis]), seed);
    let along_x = |y, z| mix(corner([0, y, z]), corner([1, y, z]), blend[0]);
    let along_y = |z| mix(along_x(0, z), along_x(1, z), blend[1]);
    mix(along_y(0), along_y(1), blend[2])
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a * (1.0 - t) + b * t
}

fn at_lattice(point: [i32; 3], seed: u32) -> f32 {
    let mix = |state: u64, axis: i32| Random::new(state).next_u64() ^ u64::from(axis as u32);
    Random::new(point.into_iter().fold(u64::from(seed), mix)).between(-1.0, 1.0)
}

/// Sine and cosine of `step` of `steps` to the full turn, `step` up to twice `steps`: by + − × ÷ in f64 alone and rounded
/// once, so all platforms give the same bits, and quarters of a turn are exact.
pub fn turn(step: u32, steps: u32) -> (f32, f32) {
    // The nearest quarter, and the rest of the angle: at most an eighth of a turn either way.
    let (step, steps) = (i64::from(step), i64::from(steps));
    let quarter = (8 * step + steps) / (2 * steps);
    let angle = std::f64::consts::FRAC_PI_2 * ((4 * step - quarter * steps) as f64 / steps as f64);
    let square = angle * angle;
    // Taylor's series, by Horner's rule; what is left out is below 1e-19.
    let series = |first: i32| {
        (0..9).rev().fold(1.0, |sum, term| {
            let below = f64::from((2 * term + first + 1) * (2 * term + first + 2));
            1.0 - sum * square / below
        })
    };
    let (sin, cos) = ((angle * series(1)) as f32, series(0) as f32);
    match quarter % 4 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}
