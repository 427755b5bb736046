//! Where the stress scenes' lights are.

use super::Scene;
use super::bodies::{LATTICE, on_lattice_plane, tilt};
use crate::random::Random;
use rimline::Light;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Placing {
    /// All around a point, about as far from it as said: points, directions of that length, other weights.
    Around {
        centre: [f32; 3],
        radius: f32,
    },
    /// Around the origin, and as much nearer to y = 0 as a body so thin.
    Flat {
        thickness: f32,
        radius: f32,
    },
    /// In the plane of the rounded plate, every so many; the others around it.
    OnTilted {
        every: usize,
    },
    /// In the plane of the plate on a lattice, exactly, every so many.
    OnLattice {
        every: usize,
    },
    /// In the planes of faces, exactly where they are on a lattice, but for every fourth.
    InFacePlanes,
    OnVertices,
    /// On edges: their middles, quarters and extensions, and their directions.
    OnEdges,
    OnFaces,
    /// w from 1e-30 to 1e30, of both signs.
    AnyWeight,
}

impl Placing {
    pub(crate) const fn around(radius: f32) -> Self {
        Self::Around { centre: [0.0; 3], radius }
    }

    pub(crate) fn light(self, scene: &Scene, index: usize) -> Light {
        let mut random = Random::new(0x51ed_270b ^ ((index as u64) << 32));
        let light = match self {
            Self::Around { centre, radius } => around(&mut random, index, centre, radius),
            Self::Flat { thickness, radius } => {
                let mut light = around(&mut random, index, [0.0; 3], radius);
                light.xyz[1] *= thickness;
                light
            }
            Self::OnTilted { every } if index.is_multiple_of(every) => {
                let [x, z] = [0; 2].map(|_: u32| 4.0 * random.between(-1.0, 1.0));
                weighted(index / every, tilt([x, 0.0, z]))
            }
            Self::OnLattice { every } if index.is_multiple_of(every) => {
                let [a, b] = [0; 2].map(|_: u32| (LATTICE * random.between(-1.0, 1.0)).round());
                let [x, y, z] = on_lattice_plane(a, b);
                // A weight that is a power of two rounds nothing.
                let kinds = [Light::point([x, y, z]), Light::directional([x, y, z])];
                *kinds.get(index / every % 3).unwrap_or(&Light::homogeneous([2.0 * x, 2.0 * y, 2.0 * z, 2.0]))
            }
            Self::OnTilted { .. } | Self::OnLattice { .. } => around(&mut random, index, [0.0; 3], 3.0),
            Self::InFacePlanes => in_face_plane(scene, &mut random, index),
            Self::OnVertices => {
                let [a, ..] = face(scene, &mut random);
                weighted(index % 2 * 2, a)
            }
            Self::OnEdges => on_edge(scene, &mut random, index),
            Self::OnFaces => {
                let [a, b, c] = face(scene, &mut random);
                let reach = if index.is_multiple_of(2) { 0.5 } else { 8.0 };
                let [s, t] = [0; 2].map(|_: u32| reach * random.between(-1.0, 1.0));
                let [s, t] = if reach < 1.0 { [s.abs(), t.abs()] } else { [s, t] };
                let on_plane: [f32; 3] = std::array::from_fn(|i| a[i] + s * (b[i] - a[i]) + t * (c[i] - a[i]));
                weighted(index / 2 % 2 * 2, on_plane)
            }
            Self::AnyWeight => {
                let [x, y, z] = random.direction().map(|c| 3.0 * c);
                let w = [1e-30, 1e-20, 1e-10, 1e-3, 0.1, 7.0, 1e10, 1e30][index % 8];
                Light::homogeneous([x, y, z, if (index / 8).is_multiple_of(2) { w } else { -w }])
            }
        };
        if light.to_array() == [0.0; 4] { Light::directional([0.0, 0.0, 1.0]) } else { light }
    }
}

/// A point as a light: with weight 1 twice in four, as a direction, and with another weight.
fn weighted(kind: usize, [x, y, z]: [f32; 3]) -> Light {
    match kind % 4 {
        1 => Light::directional([x, y, z]),
        2 => Light::homogeneous([3.0 * x, 3.0 * y, 3.0 * z, 3.0]),
        _ => Light::point([x, y, z]),
    }
}

fn around(random: &mut Random, index: usize, centre: [f32; 3], radius: f32) -> Light {
    let from_centre = random.direction().map(|c| c * radius * (1.0 + 0.5 * random.between(-1.0, 1.0)));
    if index % 4 == 1 {
        return Light::directional(from_centre);
    }
    weighted(index, std::array::from_fn(|axis| centre[axis] + from_centre[axis]))
}

/// In the plane of a face, so many times its sides from its corner: on a lattice nothing is rounded. Every fourth is
/// somewhere else.
fn in_face_plane(scene: &Scene, random: &mut Random, index: usize) -> Light {
    if index % 4 == 3 {
        return around(random, index, [0.0; 3], 3.0);
    }
    let [a, b, c] = face(scene, random);
    let [s, t] = [0; 2].map(|_: u32| random.below(81) as f32 - 40.0);
    weighted(index % 4 * 2, std::array::from_fn(|i| a[i] + s * (b[i] - a[i]) + t * (c[i] - a[i])))
}

fn on_edge(scene: &Scene, random: &mut Random, index: usize) -> Light {
    let [a, b, _] = face(scene, random);
    let along: [f32; 3] = std::array::from_fn(|i| b[i] - a[i]);
    if index % 4 == 3 {
        return Light::directional(along);
    }
    let part = [0.5, 0.25, 4.0][index % 4];
    weighted(index / 4 % 2 * 2, std::array::from_fn(|i| a[i] + part * along[i]))
}

fn face(scene: &Scene, random: &mut Random) -> [[f32; 3]; 3] {
    let corners = scene.faces.get(random.below(scene.faces.len())).copied().unwrap_or_default();
    corners.map(|v| scene.positions.get(v as usize).copied().unwrap_or_default())
}
