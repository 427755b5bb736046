//! `cargo bench --bench polygons`: a torus of quadrilaterals beside its triangles. How long the mesh takes to build, how
//! long the CPU takes to extract silhouettes, and how many faces and records there are. `--quick` for small meshes, `--stages` for the stages on the
//! GPU, `--gpu` for the GPU alone.

mod on_gpu;

use std::hint::black_box;
use std::time::Instant;

use rimline::mesh::Weld;
use rimline::reference::cpu::{Extraction, Threads};
use rimline::{Light, Mesh, Predicate};
use rimline_testkit::polygons::{PolygonSet, quad_torus};
use rimline_testkit::random::Random;

/// Runs of each. They take turns, so that a slow spell of the machine hits all of them.
pub(crate) const ROUNDS: usize = 5;
pub(crate) const SEED: u64 = 15;

fn main() {
    let is_quick = std::env::args().any(|argument| argument == "--quick");
    let sizes: &[u32] = if is_quick { &[32, 64] } else { &[128, 707] };
    if std::env::args().any(|argument| argument == "--gpu") {
        return on_gpu::measure(sizes).expect("a GPU");
    }
    println!("seed {SEED}; one thread; least of {ROUNDS} runs, milliseconds");
    println!(
        "| quadrilaterals | bump | records | of triangles | build | of triangles | 1 light | of triangles | 8 lights | of triangles | by pairs, % | twisted, % |"
    );
    println!("|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    for &size in sizes {
        for bump in [0.0, 0.001] {
            measure(&quad_torus(&mut Random::new(SEED), size, size, bump), bump);
        }
    }
    on_gpu::measure(sizes).expect("a GPU");
}

fn measure(set: &PolygonSet, bump: f32) {
    let mesh = set.mesh(Weld::Keep).expect("a mesh");
    let faces = mesh.faces().to_vec();
    let triangles = Mesh::new(&set.positions, &faces, Weld::Keep).expect("a mesh");
    let mut random = Random::new(SEED);
    let lights: Vec<Light> = (0..8).map(|_| Light::point(random.direction().map(|c| 6.0 * c))).collect();
    let mut least = [f64::INFINITY; 6];
    let (mut found, mut of_triangles) = (Extraction::default(), Extraction::default());
    for _ in 0..ROUNDS {
        let times = [
            time(|| drop(black_box(set.mesh(Weld::Keep)))),
            time(|| drop(black_box(Mesh::new(&set.positions, &faces, Weld::Keep)))),
            time(|| extract(&mut found, set, &mesh, &lights[..1])),
            time(|| extract(&mut of_triangles, set, &triangles, &lights[..1])),
            time(|| extract(&mut found, set, &mesh, &lights)),
            time(|| extract(&mut of_triangles, set, &triangles, &lights)),
        ];
        least.iter_mut().zip(times).for_each(|(least, time)| *least = least.min(time));
    }
    let twisted: u32 = found.twisted.iter().map(|mask| mask.count_ones()).sum();
    let pairs = (8 * mesh.face_count()) as f64;
    let times: Vec<String> = least.iter().map(|time| format!("{time:.1}")).collect();
    println!(
        "| {} | {bump} | {} | {} | {} | {:.2} | {:.2} |",
        mesh.face_count(),
        mesh.edges().len(),
        triangles.edges().len(),
        times.join(" | "),
        100.0 * f64::from(found.statistics.undecided_pairs) / pairs,
        100.0 * f64::from(twisted) / pairs,
    );
}

fn extract(found: &mut Extraction, set: &PolygonSet, mesh: &Mesh, lights: &[Light]) {
    found.update(&set.positions, mesh, lights, Predicate::Exact, Threads::ONE).expect("good lights");
}

fn time(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64() * 1e3
}
