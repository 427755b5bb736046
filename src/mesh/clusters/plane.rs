//! The planes of faces. They are computed in `f64`, and rounded.

use crate::cpu::common::positions::position;
use crate::mesh::is_degenerate;

/// Faces with a coordinate from 2¹²⁰ on make no bound, because sums could overflow: their clusters are not decided, unless
/// they name a vertex twice.
pub(super) const LARGE: f32 = f32::from_bits((127 + 120) << 23);
/// The normal must be at least this much of its terms, or cancellation has spoilt it: 2⁻²⁰.
const LEAST_NORMAL: f64 = 1.0 / 1_048_576.0;

/// The normal of a face, divided by its largest component, and corner 0. The largest component is 1 or −1. The others are
/// off by less than 2⁻²⁴.
///
/// The normal is 0 if the face names a vertex twice and is finite. Else it is NaN if no bound can be made of the face: a
/// vertex is not finite or is large, or the corners are nearly on a line.
pub(super) type Plane = [[f32; 3]; 2];

/// Kinds of planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Regular,
    /// The face names a vertex twice. It faces no light, and is excluded for none.
    Degenerate,
    Irregular,
}

impl Kind {
    pub(super) fn of(&[[x, y, z], _]: &Plane) -> Self {
        match x.abs() + y.abs() + z.abs() {
            0.0 => Self::Degenerate,
            size if size.is_nan() => Self::Irregular,
            _ => Self::Regular,
        }
    }
}

/// Faces at a time, so that the compiler can use a CPU's vector registers.
pub(super) const LANES: usize = 16;
type Lanes<T> = [T; LANES];

/// Faces, component by component.
pub(super) struct Batch {
    pub(super) normals: [Lanes<f32>; 3],
    /// The corners of each face, and their coordinates.
    pub(super) corners: [[Lanes<f32>; 3]; 3],
}

impl Batch {
    /// `faces` has at most [`LANES`] faces. Unused lanes have any value.
    #[inline]
    pub(super) fn new(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Self {
        let mut corners = [[[0.0; LANES]; 3]; 3];
        let mut is_degenerate_in = [false; LANES];
        for (lane, &face) in faces.iter().take(LANES).enumerate() {
            is_degenerate_in[lane] = is_degenerate(face);
            for (corner, vertex) in corners.iter_mut().zip(face) {
                let [x, y, z] = position(positions, vertex);
                (corner[0][lane], corner[1][lane], corner[2][lane]) = (x, y, z);
            }
        }
        let [a, b, c] = &corners;
        let [u, v] = [sides(a, b), sides(a, c)];
        let [(x, x_terms), (y, y_terms), (z, z_terms)] =
            [cross(&u, &v, 1, 2), cross(&u, &v, 2, 0), cross(&u, &v, 0, 1)];
        let mut scales = [f64::NAN; LANES];
        for lane in 0..LANES {
            // Compare bits, so that numbers that are not finite are large, too.
            let mut magnitude = 0;
            for coordinates in corners.as_flattened() {
                let bits = (coordinates[lane].to_bits() & 0x7fff_ffff) as i32;
                magnitude = if bits > magnitude { bits } else { magnitude };
            }
            let largest = larger(larger(x[lane].abs(), y[lane].abs()), z[lane].abs());
            let terms = larger(larger(x_terms[lane], y_terms[lane]), z_terms[lane]);
            if magnitude < LARGE.to_bits() as i32 && largest > LEAST_NORMAL * terms {
                scales[lane] = 1.0 / largest;
            } else if is_degenerate_in[lane] && magnitude < f32::INFINITY.to_bits() as i32 {
                scales[lane] = 0.0;
            }
        }
        let normals = [x, y, z].map(|component| std::array::from_fn(|lane| (component[lane] * scales[lane]) as f32));
        Self { normals, corners }
    }

    /// The plane of the face in a lane.
    #[inline]
    pub(super) fn plane(&self, lane: usize) -> Plane {
        let [x, y, z] = &self.normals;
        let [a_x, a_y, a_z] = &self.corners[0];
        [[x[lane], y[lane], z[lane]], [a_x[lane], a_y[lane], a_z[lane]]]
    }
}

/// The sides from a corner to another.
#[inline]
fn sides(from: &[Lanes<f32>; 3], to: &[Lanes<f32>; 3]) -> [Lanes<f64>; 3] {
    let mut sides = [[0.0; LANES]; 3];
    for axis in 0..3 {
        for lane in 0..LANES {
            sides[axis][lane] = f64::from(to[axis][lane]) - f64::from(from[axis][lane]);
        }
    }
    sides
}

/// A component of a cross product, and the size of its terms.
#[inline]
fn cross(u: &[Lanes<f64>; 3], v: &[Lanes<f64>; 3], second: usize, third: usize) -> (Lanes<f64>, Lanes<f64>) {
    let (mut component, mut terms) = ([0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        let [plus, minus] = [u[second][lane] * v[third][lane], u[third][lane] * v[second][lane]];
        component[lane] = plus - minus;
        terms[lane] = plus.abs() + minus.abs();
    }
    (component, terms)
}

#[inline]
fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}
