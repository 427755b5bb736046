//! Loops close at every vertex, and nothing depends on the order of faces and vertices.

use std::collections::{BTreeMap, BTreeSet};

use rimline::gpu::ExtractorOptions;
use rimline::internals::cpu::{self, Threads};
use rimline::{Light, Mesh};
use rimline_testkit::shapes::{self, Shape};

use rimline_testkit::cases::{Case, case, hard_positions, random_soup, topologies};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{Found, extract};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, lights, oracle};

pub(crate) const TESTS: &[Test] = &[
    ("every_vertex_closes_for_every_light", closes),
    ("one_flipped_bit_opens_a_vertex", flipped),
    ("random_soups_close_and_agree_with_faces_alone", soups),
    ("shuffled_faces_and_vertices_give_the_same_edges", shuffled),
];

fn masks(gpu: &Gpu, positions: &[[f32; 3]], mesh: &Mesh, lights: &[Light]) -> Result<Found, String> {
    let options = ExtractorOptions { max_lights: lights.len(), masks: true, lists: None, ..Default::default() };
    extract(gpu, positions, mesh, lights, options)
}

fn closes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let seed = 31;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let ordinary = topologies().into_iter().map(|case| (case, lights(&mut random, 100)));
    let hard = hard_positions(&mut Random::new(seed)).into_iter();
    for ((name, positions, mesh), lights) in ordinary.chain(hard.map(|(_, case, lights)| (case, lights))) {
        let found = masks(gpu, &positions, &mesh, &lights)?;
        let open = oracle::unclosed(&mesh, &found.masks, lights.len());
        if open != 0 {
            return Err(format!("{name}: {open} vertices unclosed"));
        }
    }
    Ok(())
}

/// The negative control: one bit of one edge, then one face's bit as seen by one of its edges only.
fn flipped() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(32);
    for (name, positions, mesh) in topologies() {
        let lights = lights(&mut random, 5);
        let found = masks(gpu, &positions, &mesh, &lights)?;
        for light in 0..lights.len() {
            let mut wrong = found.masks.clone();
            let edge = random.below(wrong.len());
            wrong[edge].silhouette ^= 1 << light;
            if oracle::unclosed(&mesh, &wrong, lights.len()) == 0 {
                return Err(format!("{name}: a flipped silhouette bit went unnoticed"));
            }
            let mut facing = found.facing.clone();
            let record = mesh.edges().get(edge).ok_or("no record")?;
            facing[record.face_0 as usize] ^= 1 << light;
            let other = cpu::edges(mesh.edges(), &facing, mesh.faces().len(), lights.len(), Threads::ONE);
            let mut wrong = found.masks.clone();
            wrong[edge] = other[edge];
            if oracle::unclosed(&mesh, &wrong, lights.len()) == 0 {
                return Err(format!("{name}: a facing bit flipped at one edge went unnoticed"));
            }
        }
    }
    Ok(())
}

fn soups() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let seed = 33;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    for index in 0..if is_long() { 400 } else { 12 } {
        let (name, positions, mesh) = case(format!("soup {index}"), random_soup(&mut random));
        let lights = lights(&mut random, 33);
        let found = masks(gpu, &positions, &mesh, &lights)?;
        let edges = oracle::edge_faces(mesh.faces());
        for light in 0..lights.len() {
            let expected = oracle::multiplicities(&edges, &found.facing, mesh.faces().len(), light);
            if oracle::record_multiplicities(&mesh, &found.masks, light) != expected {
                return Err(format!("{name}, light {light}: multiplicities differ from the faces' own"));
            }
            let expected = oracle::plain_silhouettes(&edges, &found.facing, mesh.faces().len(), light);
            if oracle::record_silhouettes(&mesh, &edges, &found.masks, light) != expected {
                return Err(format!("{name}, light {light}: silhouettes differ from the faces' own"));
            }
        }
        let open = oracle::unclosed(&mesh, &found.masks, lights.len());
        if open != 0 {
            return Err(format!("{name}: {open} vertices unclosed"));
        }
    }
    Ok(())
}

/// An edge by the bits of its positions, which no renumbering changes, lower end first.
type Place = ([u32; 3], [u32; 3]);
/// Summed multiplicities from the lower end to the upper, and silhouettes where an edge has at most two faces.
type ByPlace = (BTreeMap<Place, i64>, BTreeSet<Place>);

fn by_place(positions: &[[f32; 3]], mesh: &Mesh, found: &Found, light: usize) -> ByPlace {
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
            // Each face keeps its first corner, so its facing is computed alike to the last bit.
            let (_, moved, other) = case(name.clone(), shape.shuffled(seed));
            let again = masks(gpu, &moved, &other, &lights)?;
            for light in 0..lights.len() {
                let before = by_place(&positions, &mesh, &found, light);
                let mut after = by_place(&moved, &other, &again, light);
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
    match by_place(&positions, &mesh, &found, 0).1.len() {
        6 => Ok(()),
        edges => Err(format!("a cube's silhouette has {edges} edges, expected 6")),
    }
}
