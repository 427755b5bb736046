//! Shading normals: smooth where the surface bends gently, split where it has a crease.

use std::collections::HashMap;
use std::ops::Range;

use glam::{Vec2, Vec3};

/// Faces that meet at more than this angle, in degrees, keep their own normals.
const CREASE: f32 = 60.0;

/// At a vertex of more faces, neighbours go by rounded normals, of which there are few: else a fan would take the square of its
/// faces.
const MANY: usize = 1024;

/// A normal a corner of `faces`, folded onto an octahedron as two 16-bit signed fractions. Neighbours count by area.
pub fn corner_normals(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Vec<u32> {
    let near = Neighbours::new(positions, faces, None);
    let sum = |face: usize, vertex: u32| near.of(face, vertex).map(|other| near.areas[other]).sum::<Vec3>();
    let mut shared = HashMap::new();
    let normal = |(face, vertex): (usize, u32)| {
        let sum = match near.rounded(face, vertex) {
            Some(rounded) => *shared.entry((vertex, rounded)).or_insert_with(|| sum(face, vertex)),
            None => sum(face, vertex),
        };
        sum.try_normalize().unwrap_or(near.units[face])
    };
    let corners = faces.iter().enumerate().flat_map(|(face, corners)| corners.map(|v| (face, v)));
    corners.map(normal).map(fold).collect()
}

/// Faces around vertices that smooth into each other.
pub(crate) struct Neighbours {
    /// Normals of faces, as long as their area times one factor for all; and of length 1, or 0 without an area.
    areas: Vec<Vec3>,
    units: Vec<Vec3>,
    around: Around,
    cosine: f32,
}

impl Neighbours {
    /// `same` tells the first of the vertices at a position, where they are one. Only the first then has neighbours.
    pub(crate) fn new(positions: &[[f32; 3]], faces: &[[u32; 3]], same: Option<&[u32]>) -> Self {
        let position = |v: u32| Vec3::from(positions[v as usize]);
        // Neither tiny nor huge models leave the range of floats.
        let extent = positions.iter().flatten().filter(|c| c.is_finite()).fold(0.0_f32, |a, c| a.max(c.abs()));
        let scale = if extent > 0.0 { extent.recip() } else { 1.0 };
        let areas: Vec<Vec3> = faces
            .iter()
            .map(|&[a, b, c]| ((position(b) - position(a)) * scale).cross((position(c) - position(a)) * scale))
            .collect();
        let units: Vec<Vec3> = areas.iter().map(|area| area.normalize_or_zero()).collect();
        let around = Around::new(positions.len(), faces, |vertex| same.map_or(vertex, |same| same[vertex as usize]));
        Self { areas, units, around, cosine: CREASE.to_radians().cos() }
    }

    /// The neighbours of a face at one of its vertices, the first of its position. The face is among them unless it has no
    /// area.
    pub(crate) fn of(&self, face: usize, vertex: u32) -> impl Iterator<Item = usize> + '_ {
        let has_many = self.around.range(vertex).len() > MANY;
        let direction = move |face: usize| {
            let unit = self.units[face];
            if has_many { Vec3::from(rounded(unit).map(f32::from)).normalize_or_zero() } else { unit }
        };
        let normal = direction(face);
        self.around.faces(vertex).filter(move |&other| direction(other).dot(normal) > self.cosine)
    }

    /// The rounded normal of a face at a vertex of many faces, the first of its position: faces with the same one have the same
    /// neighbours there.
    pub(crate) fn rounded(&self, face: usize, vertex: u32) -> Option<[i8; 3]> {
        (self.around.range(vertex).len() > MANY).then(|| rounded(self.units[face]))
    }
}

/// A unit vector in eighths, by at most 6.3° beside it: one of about a thousand.
fn rounded(unit: Vec3) -> [i8; 3] {
    unit.to_array().map(|c| (8.0 * c).round() as i8)
}

/// The faces around each vertex.
struct Around {
    starts: Vec<u32>,
    faces: Vec<u32>,
}

impl Around {
    /// The neighbours of faces whose vertices stand for others.
    fn new(vertices: usize, faces: &[[u32; 3]], stands_for: impl Fn(u32) -> u32) -> Self {
        let mut starts = vec![0_u32; vertices + 1];
        for &v in faces.iter().flatten() {
            starts[stands_for(v) as usize + 1] += 1;
        }
        for v in 0..vertices {
            starts[v + 1] += starts[v];
        }
        let mut next = starts.clone();
        let mut around = vec![0; 3 * faces.len()];
        for (face, corners) in faces.iter().enumerate() {
            for v in corners.map(&stands_for) {
                around[next[v as usize] as usize] = face as u32;
                next[v as usize] += 1;
            }
        }
        Self { starts, faces: around }
    }

    fn faces(&self, vertex: u32) -> impl Iterator<Item = usize> + '_ {
        self.faces[self.range(vertex)].iter().map(|&face| face as usize)
    }

    fn range(&self, vertex: u32) -> Range<usize> {
        self.starts[vertex as usize] as usize..self.starts[vertex as usize + 1] as usize
    }
}

/// The octahedron's lower half is folded over its upper half, seen from +Z.
fn fold(normal: Vec3) -> u32 {
    let flat = normal / (normal.abs().element_sum()).max(f32::MIN_POSITIVE);
    let mut at = Vec2::new(flat.x, flat.y);
    if flat.z < 0.0 {
        at = (Vec2::ONE - Vec2::new(at.y, at.x).abs()) * Vec2::ONE.copysign(at);
    }
    let [x, y] = at.to_array().map(|c| u32::from((c.clamp(-1.0, 1.0) * 32767.0).round() as i16 as u16));
    x | y << 16
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    fn unfold(word: u32) -> Vec3 {
        let [x, y] = [word as u16, (word >> 16) as u16].map(|bits| f32::from(bits as i16) / 32767.0);
        let z = 1.0 - x.abs() - y.abs();
        let t = (-z).max(0.0);
        Vec3::new(x - t.copysign(x), y - t.copysign(y), z).normalize()
    }

    #[test]
    fn folding_keeps_directions() {
        for i in 0..500 {
            let a = i as f32;
            let normal = Vec3::new(a.sin(), (2.3 * a).cos(), (0.7 * a).sin()).normalize();
            assert!(unfold(fold(normal)).dot(normal) > 0.999_999, "{normal}");
        }
    }

    /// A fan around its tip at this height over a ring of radius 1.
    pub(crate) fn fan(sides: u32, height: f32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let ring = (0..sides).map(|side| (side as f32 * std::f32::consts::TAU / sides as f32).sin_cos());
        let positions = std::iter::once([0.0, height, 0.0]).chain(ring.map(|(x, z)| [x, 0.0, z]));
        (positions.collect(), (0..sides).map(|side| [0, side + 1, (side + 1) % sides + 1]).collect())
    }

    #[test]
    fn a_large_fan_takes_no_square_of_its_faces() {
        let (positions, faces) = fan(300_000, 0.0);
        let normals = corner_normals(&positions, &faces);
        assert!(normals.into_iter().all(|normal| unfold(normal).dot(Vec3::Y) > 0.999));
    }

    #[test]
    fn rounded_normals_of_a_fan_are_close_to_those_of_all_pairs() {
        let (positions, faces) = fan(2 * MANY as u32, 1.5);
        let near = Neighbours::new(&positions, &faces, None);
        for (face, normals) in corner_normals(&positions, &faces).chunks(3).enumerate().step_by(7) {
            let is_near = |other: &usize| near.units[*other].dot(near.units[face]) > near.cosine;
            let sum: Vec3 = (0..faces.len()).filter(is_near).map(|other| near.areas[other]).sum();
            assert!(unfold(normals[0]).dot(sum.normalize()) > 0.98, "face {face}");
        }
    }

    #[test]
    fn a_crease_splits_and_a_bend_does_not() {
        let bend = |height: f32| {
            let positions = [[0.0; 3], [0.0, 0.0, 1.0], [-1.0, height, 0.0], [1.0, height, 0.0]];
            corner_normals(&positions, &[[0, 2, 1], [0, 1, 3]]).into_iter().map(unfold).collect::<Vec<_>>()
        };
        let gentle = bend(0.1);
        assert!(gentle[0].dot(gentle[3]) > 0.999);
        let sharp = bend(2.0);
        assert!(sharp[0].dot(sharp[3]) < 0.5);
    }
}
