//! Brute force, written apart from `src/`: exact signs in big integers, silhouettes from faces alone. Slow, plain, and
//! sharing nothing with the code under test but its inputs and outputs.

use std::collections::BTreeMap;

use rimline::internals::layout::EdgeMasks;
use rimline::mesh::EdgeKind;
use rimline::{Light, Mesh};

use crate::shadow_oracle::{Homogeneous, Vector, cross, least, minus, scaled, sign};

/// A face's exact normal `(b − a) × (c − a)` and first corner, as integers; made once for all lights.
pub struct ExactFace {
    normal: Vector,
    a: Vector,
    scale: i32,
}

impl ExactFace {
    /// `None` for a face that faces nothing: it names a vertex twice, or a vertex is not finite.
    pub fn new(positions: &[[f32; 3]], face: [u32; 3]) -> Option<Self> {
        let [i, j, k] = face;
        let corners = face.map(|v| positions[v as usize]);
        if i == j || j == k || k == i || !corners.iter().flatten().all(|c| c.is_finite()) {
            return None;
        }
        let scale = -least(corners.into_iter().flatten());
        let [a, b, c] = corners.map(|corner| corner.map(|c| scaled(c, scale)));
        Some(Self { normal: cross(&minus(&b, &a), &minus(&c, &a)), a, scale })
    }

    /// The sign of `det[b − a, c − a, l − w·a]`: 1, 0 or −1.
    pub fn sign(&self, light: Light) -> i32 {
        let Homogeneous { xyz, w } = Homogeneous::light(light, self.scale);
        let term = |axis: usize| &self.normal[axis] * (&xyz[axis] - &w * &self.a[axis]);
        sign(&(term(0) + term(1) + term(2)))
    }
}

/// Facing masks in exact arithmetic, laid out as the library's.
pub fn facing(positions: &[[f32; 3]], faces: &[[u32; 3]], lights: &[Light]) -> Vec<u32> {
    masks(positions, faces, lights, |sign| sign > 0)
}

/// Masks of the lights for which a face is excluded, likewise: those in its plane, all where it is not finite, and none of a
/// finite face that names a vertex twice.
pub fn excluded(positions: &[[f32; 3]], faces: &[[u32; 3]], lights: &[Light]) -> Vec<u32> {
    let mut found = masks(positions, faces, lights, |sign| sign == 0);
    let is_finite = |face: &[u32; 3]| face.iter().all(|&v| positions[v as usize].iter().all(|c| c.is_finite()));
    for (lights, masks) in lights.chunks(32).zip(found.chunks_mut(faces.len().max(1))) {
        let all = (0..lights.len()).fold(0, |all, bit| all | 1 << bit);
        masks.iter_mut().zip(faces).filter(|(_, face)| !is_finite(face)).for_each(|(mask, _)| *mask = all);
    }
    found
}

fn masks(positions: &[[f32; 3]], faces: &[[u32; 3]], lights: &[Light], is_set: fn(i32) -> bool) -> Vec<u32> {
    let exact: Vec<_> = faces.iter().map(|&face| ExactFace::new(positions, face)).collect();
    let planes = lights.chunks(32).flat_map(|word| {
        exact.iter().map(move |face| {
            (0..).zip(word).fold(0, |mask, (bit, light)| {
                mask | u32::from(face.as_ref().is_some_and(|face| is_set(face.sign(*light)))) << bit
            })
        })
    });
    planes.collect()
}

/// For each undirected edge `(low, high)` its faces, each with whether it runs from low to high.
pub type EdgeFaces = BTreeMap<(u32, u32), Vec<(u32, bool)>>;

/// Which faces meet at each edge, from the faces alone; those that name a vertex twice have none.
pub fn edge_faces(faces: &[[u32; 3]]) -> EdgeFaces {
    let mut edges = EdgeFaces::new();
    for (index, &[a, b, c]) in (0..).zip(faces) {
        if a != b && b != c && c != a {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let key = (from.min(to), from.max(to));
                edges.entry(key).or_default().push((index, from < to));
            }
        }
    }
    edges
}

/// ±1 by facing.
pub fn side(facing: &[u32], face_count: usize, face: u32, light: usize) -> i64 {
    let mask = facing[light / 32 * face_count + face as usize];
    if mask >> (light % 32) & 1 != 0 { 1 } else { -1 }
}

/// The multiplicity of each undirected edge for a light, counted from low to high: by Bergeron's rule each face adds
/// its side in the direction in which it runs.
pub fn multiplicities(edges: &EdgeFaces, facing: &[u32], face_count: usize, light: usize) -> BTreeMap<(u32, u32), i64> {
    let of = |faces: &Vec<(u32, bool)>| {
        let sides = faces.iter().map(|&(face, forward)| {
            let side = side(facing, face_count, face, light);
            if forward { side } else { -side }
        });
        sides.sum()
    };
    edges.iter().map(|(&key, faces)| (key, of(faces))).collect()
}

/// The multiplicity that a record's kind, silhouette bit and winding bit say, in the record's own direction.
fn record_multiplicity(kind: EdgeKind, masks: EdgeMasks, bit: usize) -> i64 {
    let silhouette = masks.silhouette >> bit & 1 != 0;
    let winding = if masks.winding >> bit & 1 != 0 { 1 } else { -1 };
    match (kind, silhouette) {
        (EdgeKind::Boundary, true) => winding,
        (_, true) => 2 * winding,
        (_, false) => 0,
    }
}

/// The same multiplicities, summed up from a mesh's records and their masks.
fn record_multiplicities(mesh: &Mesh, masks: &[EdgeMasks], light: usize) -> BTreeMap<(u32, u32), i64> {
    let plane = &masks[light / 32 * mesh.edges().len()..][..mesh.edges().len()];
    let mut sums = BTreeMap::new();
    for (edge, &masks) in mesh.edges().iter().zip(plane) {
        let [a, b] = edge.vertices;
        let multiplicity = record_multiplicity(edge.kind, masks, light % 32);
        *sums.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { multiplicity } else { -multiplicity };
    }
    sums
}

/// The list of the light with this bit over one plane of masks: the silhouette edges in edge order, with the winding
/// bit as bit 31.
pub fn listed(plane: &[EdgeMasks], bit: u32) -> Vec<u32> {
    let edges = (0..).zip(plane).filter(|(_, masks)| masks.silhouette >> bit & 1 != 0);
    edges.map(|(edge, masks): (u32, _)| edge | (masks.winding >> bit & 1) << 31).collect()
}

/// Vertices at which outgoing and incoming multiplicities of a light do not cancel, summed over lights; from the masks,
/// as they lie in the buffers.
pub fn unclosed(mesh: &Mesh, masks: &[EdgeMasks], lights: usize) -> usize {
    let mut open = 0;
    for light in 0..lights {
        let plane = &masks[light / 32 * mesh.edges().len()..][..mesh.edges().len()];
        let mut balance = vec![0_i64; mesh.vertex_count() as usize];
        for (edge, &masks) in mesh.edges().iter().zip(plane) {
            let multiplicity = record_multiplicity(edge.kind, masks, light % 32);
            balance[edge.vertices[0] as usize] += multiplicity;
            balance[edge.vertices[1] as usize] -= multiplicity;
        }
        open += balance.iter().filter(|&&sum| sum != 0).count();
    }
    open
}

/// Records, silhouette bits and winding bits against the faces alone; nothing past the lights; closed at all vertices.
pub fn check_masks(name: &str, mesh: &Mesh, facing: &[u32], masks: &[EdgeMasks], lights: usize) -> Result<(), String> {
    let edges = edge_faces(mesh.faces());
    for light in 0..lights {
        let expected = multiplicities(&edges, facing, mesh.faces().len(), light);
        if record_multiplicities(mesh, masks, light) != expected {
            return Err(format!("{name}, light {light}: multiplicities differ"));
        }
        let plane = &masks[light / 32 * mesh.edges().len()..];
        for (edge, masks) in mesh.edges().iter().zip(plane) {
            let faces_light = side(facing, mesh.faces().len(), edge.face_0, light) > 0;
            if (masks.winding >> (light % 32) & 1 != 0) != faces_light {
                return Err(format!("{name}, light {light}: winding of {edge:?}"));
            }
        }
    }
    let past = |at: usize| u32::MAX.checked_shl((lights - 32 * (at / mesh.edges().len())) as u32).unwrap_or(0);
    let is_past = |(at, masks): (usize, &EdgeMasks)| (masks.silhouette | masks.winding) & past(at) != 0;
    match unclosed(mesh, masks, lights) {
        0 if !masks.iter().enumerate().any(is_past) => Ok(()),
        open => Err(format!("{name}: {open} vertices unclosed, or bits past the lights")),
    }
}
