//! Loops close at every vertex, and nothing depends on the order of faces and vertices.

use std::collections::{BTreeMap, BTreeSet};

use rimline::gpu::ExtractorOptions;
use rimline::{Light, Mesh};
use rimline_testkit::shapes::{self, Shape};

use rimline_testkit::cases::{Case, case, hard_positions, random_soup, topologies};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{Found, extract};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, lights, oracle};

pub(crate) const TESTS: &[Test] = &[
    ("masks_close_and_agree_with_faces_alone", closes),
    ("shuffled_faces_and_vertices_give_the_same_edges", shuffled),
];

fn masks(gpu: &Gpu, positions: &[[f32; 3]], mesh: &Mesh, lights: &[Light]) -> Result<Found, String> {
    let options = ExtractorOptions { max_lights: lights.len(), masks: true, lists: None, ..Default::default() };
    extract(gpu, positions, mesh, lights, options)
}

fn closes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(33);
    let soups = 0..if is_long() { 400 } else { 12 };
    let soups: Vec<_> = soups.map(|index| case(format!("soup {index}"), random_soup(&mut random))).collect();
    let ordinary = topologies().into_iter().chain(soups).map(|case| (case, lights(&mut random, 100)));
    let hard = hard_positions(&mut Random::new(31)).into_iter().map(|(_, case, lights)| (case, lights));
    for ((name, positions, mesh), lights) in ordinary.chain(hard) {
        let found = masks(gpu, &positions, &mesh, &lights)?;
        oracle::check_masks(&name, &mesh, &found.facing, &found.masks, lights.len())?;
    }
    Ok(())
}

/// An edge by the bits of its positions, which no renumbering changes, lower end first.
type EdgeKey = ([u32; 3], [u32; 3]);
/// Summed multiplicities from the lower end to the upper, and silhouettes where an edge has at most two faces.
type ByKey = (BTreeMap<EdgeKey, i64>, BTreeSet<EdgeKey>);

fn by_key(positions: &[[f32; 3]], mesh: &Mesh, found: &Found, light: usize) -> ByKey {
    let at = |v: u32| positions[v as usize].map(f32::to_bits);
    let ends = |(low, high): (u32, u32)| {
        let (p, q) = (at(low), at(high));
        ((p.min(q), p.max(q)), if p < q { 1 } else { -1 })
    };
    let sums = oracle::record_multiplicities(mesh, &found.masks, light);
    let signed = sums.into_iter().map(|(key, sum)| {
        let (ends, sign) = ends(key);
        (ends, sign * sum)
    });
    let edges = oracle::edge_faces(mesh.faces());
    let silhouettes = oracle::record_silhouettes(mesh, &edges, &found.masks, light);
    (signed.collect(), silhouettes.into_iter().map(|key| ends(key).0).collect())
}

fn shuffled() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(34);
    let mut cases: Vec<Case> = topologies();
    // Vertices with equal positions would be renumbered to different ones; every case here is welded.
    cases.push(case("random soup", random_soup(&mut random)));
    for (name, positions, mesh) in cases {
        let lights = lights(&mut random, 33);
        let found = masks(gpu, &positions, &mesh, &lights)?;
        for seed in [1, 2] {
            let shape = Shape { positions: positions.clone(), faces: mesh.faces().to_vec() };
            // Each face keeps its first corner, so its facing is computed with the same bits.
            let (_, moved, other) = case(name.clone(), shape.shuffled(seed));
            let again = masks(gpu, &moved, &other, &lights)?;
            for light in 0..lights.len() {
                let before = by_key(&positions, &mesh, &found, light);
                let mut after = by_key(&moved, &other, &again, light);
                if before != after {
                    return Err(format!("{name}, seed {seed}, light {light}: edges differ after shuffling"));
                }
                if let Some(sum) = after.0.values_mut().next() {
                    *sum += 1;
                }
                if before == after {
                    return Err("negative control: a changed multiplicity went unnoticed".to_owned());
                }
            }
        }
    }
    // The comparison has something to compare.
    let (_, positions, mesh) = case("cube", shapes::cube());
    let found = masks(gpu, &positions, &mesh, &[Light::directional([1.0, 2.0, 3.0])])?;
    match by_key(&positions, &mesh, &found, 0).1.len() {
        6 => Ok(()),
        edges => Err(format!("a cube's silhouette has {edges} edges, expected 6")),
    }
}
