//! `cargo bench --bench polygons`: a torus of quadrilaterals beside its triangles. How long the mesh takes to build, how
//! long CPU and GPU take to extract silhouettes, and how many records there are. `--quick` for small meshes.

use rimline::gpu::ExtractorOptions;
use rimline::internals::cpu::{Extraction, Threads};
use rimline::mesh::{MeshError, Weld};
use rimline::{Light, Mesh, Predicate};
use rimline_bench::Error;
use rimline_bench::engine::{Contender, Rounds, clock, times};
use rimline_bench::gpu::{Gpu, Stopwatch};
use rimline_bench::record::ExtractorRecorder;
use rimline_bench::row::compare;
use rimline_testkit::polygons::{PolygonSet, quad_torus};
use rimline_testkit::random::Random;

const ROUNDS: usize = 9;
const SEED: u64 = 15;

fn main() -> Result<(), Error> {
    let is_quick = std::env::args().any(|argument| argument == "--quick");
    let sizes: &[u32] = if is_quick { &[32, 64] } else { &[128, 707] };
    let (gpu, name) = Gpu::first(wgpu::Features::empty())?;
    println!("{name}; seed {SEED}; CPU on one thread; medians of {ROUNDS} runs in turn, milliseconds");
    println!("| quadrilaterals | bump | records | of triangles | twisted, % | what | polygons | triangles | ratio |");
    println!("|---:|---:|---:|---:|---:|---|---:|---:|---:|");
    for &size in sizes {
        for bump in [0.0, 0.0001, 0.001] {
            measure(&gpu, &quad_torus(&mut Random::new(SEED), size, size, bump), bump)?;
        }
    }
    Ok(())
}

fn measure(gpu: &Gpu, set: &PolygonSet, bump: f32) -> Result<(), Error> {
    let polygons = set.mesh(Weld::Keep)?;
    let triangles = Mesh::new(&set.positions, polygons.faces(), Weld::Keep)?;
    let mut random = Random::new(SEED);
    let lights: Vec<Light> = (0..8).map(|_| Light::point(random.direction().map(|c| 6.0 * c))).collect();
    let mut found = Extraction::default();
    found.update(&set.positions, &polygons, &lights, Predicate::Exact, Threads::ONE).expect("good lights");
    let twisted: Vec<u32> = polygons.polygons().map_or_else(Vec::new, |polygons| polygons.masks_of(&found.twisted));
    let twisted: u32 = twisted.iter().map(|mask| mask.count_ones()).sum();
    let twisted = 100.0 * f64::from(twisted) / (8 * polygons.face_count()) as f64;
    let facts = format!(
        "{} | {bump} | {} | {} | {twisted:.2}",
        polygons.face_count(),
        polygons.edges().len(),
        triangles.edges().len()
    );
    let build = |make: &dyn Fn() -> Result<Mesh, MeshError>| Ok(times([("time", clock(|| drop(make())))]));
    let from_triangles = || Mesh::new(&set.positions, polygons.faces(), Weld::Keep);
    let mut contenders: Vec<(&str, Contender<'_>)> =
        vec![("build", Box::new(|| build(&|| set.mesh(Weld::Keep)))), ("build", Box::new(|| build(&from_triangles)))];
    for (name, lights) in [("1 light", &lights[..1]), ("8 lights", &lights[..])] {
        for mesh in [&polygons, &triangles] {
            let mut found = Extraction::default();
            let update = move || {
                let ms = clock(|| {
                    found.update(&set.positions, mesh, lights, Predicate::Exact, Threads::ONE).expect("good lights");
                });
                Ok(times([("time", ms)]))
            };
            contenders.push((name, Box::new(update)));
        }
    }
    for (name, lights) in [("GPU, 1 light", &lights[..1]), ("GPU, 8 lights", &lights[..])] {
        for mesh in [&polygons, &triangles] {
            let options = ExtractorOptions { max_lights: lights.len(), ..ExtractorOptions::default() };
            let mut recorder = ExtractorRecorder::new(gpu, options, mesh, &set.positions, lights)?;
            let stopwatch = Stopwatch::new(gpu);
            let run = move || {
                let [recording, running] = stopwatch.by_clock(|encoder| recorder.encode(encoder, None))?;
                Ok(times([("time", recording + running)]))
            };
            contenders.push((name, Box::new(run)));
        }
    }
    let entries = compare(Rounds::exactly(ROUNDS), contenders, &())?;
    for pair in entries.chunks(2) {
        let [of, to] = [0, 1].map(|at| pair[at].ms("time"));
        println!("| {facts} | {} | {of:.2} | {to:.2} | {:.2} |", pair[0].variant.name, of / to);
    }
    Ok(())
}
