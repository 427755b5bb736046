//! `cargo bench --bench clusters`: how long clusters take to build beside the topology, with the mesh in their order, how
//! much memory they take, and which part of the faces and edges is left to test one by one. `--quick` for small meshes,
//! `--large` for up to 16 million faces.

use std::hint::black_box;

use rimline::internals::clusters::{Arranged, CLUSTER_FACES, Clusters};
use rimline::internals::cpu::{self, Threads};
use rimline::{Light, Mesh, Predicate};
use rimline_bench::Error;
use rimline_bench::engine::{Contender, Metric, Rounds, clock, interleave};
use rimline_bench::random::Random;
use rimline_bench::row::{Entry, Variant};
use rimline_bench::shapes::{Shape, blob, sphere, torus};
use rimline_testkit::clusters::whole;

/// Runs of each method, in turn.
const ROUNDS: usize = 11;
/// Lights of each kind.
const LIGHTS: usize = 32;
const SEED: u64 = 14;

fn main() -> Result<(), Error> {
    let has = |wanted: &str| std::env::args().any(|argument| argument == wanted);
    let sizes: &[u32] = match (has("--quick"), has("--large")) {
        (true, _) => &[32, 64],
        (_, true) => &[90, 181, 362, 724, 1448],
        _ => &[90, 181, 362],
    };
    println!(
        "seed {SEED}; the topology on one thread; median of {ROUNDS} runs, milliseconds; {LIGHTS} lights of each kind"
    );
    println!(
        "| mesh | faces | topology | clusters, one thread | all | ratio | bytes a face | inner edges, % | faces left, %: far | near | at infinity | have to be: far | edges left, %: far |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    for &size in sizes {
        let shapes = [
            ("sphere", sphere(size)),
            ("torus", torus(2 * size, 2 * size, 1.0, 0.4)),
            ("blob", blob(size, 0.4, 1)),
            ("blob, shuffled", blob(size, 0.4, 1).shuffled(1)),
        ];
        for (name, shape) in &shapes {
            measure(name, shape)?;
        }
    }
    Ok(())
}

fn measure(name: &str, shape: &Shape) -> Result<(), Error> {
    const TIME: Metric = Metric::Time("time");
    let mesh = shape.mesh()?;
    let topology = || {
        let faces = shape.faces.clone();
        Ok(vec![(TIME, clock(|| drop(black_box(Mesh::from_faces(shape.positions.len(), faces)))))])
    };
    let mesh = &mesh;
    let building = |threads: Threads| -> Contender<'_> {
        Box::new(move || {
            let ms = clock(|| {
                let clusters = Clusters::new(mesh, &shape.positions, threads);
                drop(black_box((Arranged::new(mesh, &clusters, threads), clusters)));
            });
            Ok(vec![(TIME, ms)])
        })
    };
    let contenders = vec![Box::new(topology) as Contender<'_>, building(Threads::ONE), building(Threads::all())];
    let samples = interleave(Rounds::exactly(ROUNDS), contenders, &())?;
    let median = |at: usize| Entry::new(Variant::new("", "", 0, 0), &samples[at]).median(TIME).unwrap_or(f64::NAN);
    let [topology, alone, building] = [0, 1, 2].map(median);
    let found = Clusters::new(mesh, &shape.positions, Threads::all());
    let inner: usize = (0..found.bounds().len()).map(|cluster| found.edges().inner(cluster).len()).sum();
    let mut random = Random::new(SEED);
    let around = |random: &mut Random, distance: f32| Light::point(random.direction().map(|c| c * distance));
    let far: Vec<Light> = (0..LIGHTS).map(|_| around(&mut random, 6.0)).collect();
    let near: Vec<Light> = (0..LIGHTS).map(|_| around(&mut random, 1.6)).collect();
    let infinite: Vec<Light> = (0..LIGHTS).map(|_| Light::directional(random.direction())).collect();
    let least = mixed(&found, shape, &far);
    let [(far, edges), (near, _), (infinite, _)] = [far, near, infinite].map(|lights| left(&found, mesh, &lights));
    println!(
        "| {name} | {} | {:.1} | {:.1} | {:.1} | {:.2} | {:.1} | {:.1} | {far:.2} | {near:.2} | {infinite:.2} | {least:.2} | {edges:.2} |",
        shape.faces.len(),
        topology,
        alone,
        building,
        building / topology,
        found.bytes() as f64 / shape.faces.len() as f64,
        100.0 * inner as f64 / mesh.edges().len() as f64,
    );
    Ok(())
}

/// The part of the faces and of the edges that are left, in a hundred.
fn left(found: &Clusters, mesh: &Mesh, lights: &[Light]) -> (f64, f64) {
    let (mut faces, mut edges) = (0, 0);
    for light in lights {
        let decided: Vec<_> = found.bounds().iter().map(|bound| whole(bound, *light)).collect();
        let mut of_faces = vec![None; mesh.faces().len()];
        for (slot, &face) in found.faces().iter().enumerate() {
            of_faces[face as usize] = decided[slot / CLUSTER_FACES];
        }
        faces += of_faces.iter().filter(|whole| whole.is_none()).count();
        let is_left = |face_0: u32, face_1: Option<u32>| {
            let first = of_faces[face_0 as usize];
            first.is_none() || face_1.is_none_or(|face| of_faces[face as usize] != first)
        };
        edges += mesh.edges().iter().filter(|edge| is_left(edge.face_0, edge.face_1)).count();
    }
    let percent = |count: usize, all: usize| 100.0 * count as f64 / (lights.len() * all.max(1)) as f64;
    (percent(faces, mesh.faces().len()), percent(edges, mesh.edges().len()))
}

/// The part of the faces, in a hundred, whose clusters have faces on both sides. No bound can decide these.
fn mixed(found: &Clusters, shape: &Shape, lights: &[Light]) -> f64 {
    let facing = cpu::facing(&shape.positions, &shape.faces, lights, Predicate::Exact, Threads::all());
    let mixed = found.faces().chunks(CLUSTER_FACES).map(|slots| {
        let [all, any] = slots.iter().fold([u32::MAX, 0], |[all, any], &face| {
            let mask = facing[face as usize];
            [all & mask, any | mask]
        });
        slots.len() * (all ^ any).count_ones() as usize
    });
    100.0 * mixed.sum::<usize>() as f64 / (lights.len() * shape.faces.len()) as f64
}
