//! What tests share: a seeded generator, comparators, files.

#![allow(dead_code, reason = "each test binary uses its part")]

pub(crate) mod device;
pub(crate) mod oracle;
pub(crate) mod random;

use std::path::PathBuf;

use rimline::{Light, Mesh};

/// The folder of model files beside the checkout, if it is there.
pub(crate) fn assets() -> Option<PathBuf> {
    let folder = std::env::var_os("RIMLINE_ASSETS").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/assets"),
        PathBuf::from,
    );
    folder.is_dir().then_some(folder)
}

/// Fails with the first place at which two slices differ, and how many there are.
pub(crate) fn same<T: PartialEq + std::fmt::Debug>(what: &str, got: &[T], expected: &[T]) -> Result<(), String> {
    if got.len() != expected.len() {
        return Err(format!("{what}: {} items, expected {}", got.len(), expected.len()));
    }
    let mut different = (0..got.len()).filter(|&i| got[i] != expected[i]);
    match different.next() {
        None => Ok(()),
        Some(i) => Err(format!(
            "{what}: item {i} is {:?}, expected {:?}; {} of {} differ",
            got[i],
            expected[i],
            1 + different.count(),
            got.len()
        )),
    }
}

/// Vertices at which outgoing and incoming multiplicities of a light do not cancel, summed over lights.
pub(crate) fn unclosed(mesh: &Mesh, masks: &[rimline::layout::Masks], facing: &[u32], lights: usize) -> usize {
    let _ = masks;
    let mut open = 0;
    for light in 0..lights {
        let plane = &facing[light / 32 * mesh.faces().len()..];
        let sign = |face: u32| {
            if plane[face as usize] >> (light % 32) & 1 != 0 {
                1_i64
            } else {
                -1
            }
        };
        let mut balance = vec![0_i64; mesh.vertex_count() as usize];
        for edge in mesh.edges().iter() {
            let second = edge.face_1.map_or(0, |face| sign(face));
            let o = if edge.kind == rimline::mesh::EdgeKind::Consistent {
                -1
            } else {
                1
            };
            let multiplicity = sign(edge.face_0) + o * second;
            balance[edge.vertices[0] as usize] += multiplicity;
            balance[edge.vertices[1] as usize] -= multiplicity;
        }
        open += balance.iter().filter(|&&sum| sum != 0).count();
    }
    open
}

/// `count` lights around a mesh of about unit size: points near and far, directions, other weights.
pub(crate) fn lights(random: &mut random::Random, count: usize) -> Vec<Light> {
    (0..count)
        .map(|index| {
            let [x, y, z] = random.direction().map(|c| c * random.between(0.1, 6.0));
            match index % 4 {
                0 | 3 => Light::point([x, y, z]),
                1 => Light::directional([x, y, z]),
                _ => Light::homogeneous([x, y, z, random.between(0.2, 3.0)]),
            }
        })
        .collect()
}
