//! `cargo bench --bench clusters`: how long clusters take to build beside the topology, with the mesh in their order, and
//! how much memory they take. `--quick` for small meshes, `--large` for up to 16 million faces.

use std::hint::black_box;

use rimline::Mesh;
use rimline::internals::clusters::{Arranged, Clusters};
use rimline::internals::cpu::Threads;
use rimline_bench::Error;
use rimline_bench::engine::{Contender, Rounds, clock, times};
use rimline_bench::row::compare;
use rimline_bench::shapes::{Shape, blob, sphere, torus};

/// Runs of each method, in turn.
const ROUNDS: usize = 11;

fn main() -> Result<(), Error> {
    let has = |wanted: &str| std::env::args().any(|argument| argument == wanted);
    let sizes: &[u32] = match (has("--quick"), has("--large")) {
        (true, _) => &[32, 64],
        (_, true) => &[90, 181, 362, 724, 1448],
        _ => &[90, 181, 362],
    };
    println!("the topology on one thread; median of {ROUNDS} runs, milliseconds");
    println!("| mesh | faces | topology | clusters, one thread | all | ratio | bytes a face |");
    println!("|---|---:|---:|---:|---:|---:|---:|");
    for &size in sizes {
        let blob = blob(size, 0.4, 1);
        let shapes = [("sphere", sphere(size)), ("torus", torus(2 * size, 2 * size, 1.0, 0.4))];
        for (name, shape) in shapes.iter().chain(&[("blob, shuffled", blob.shuffled(1)), ("blob", blob)]) {
            measure(name, shape)?;
        }
    }
    Ok(())
}

fn measure(name: &str, shape: &Shape) -> Result<(), Error> {
    let mesh = &shape.mesh()?;
    let topology = || {
        let faces = shape.faces.clone();
        Ok(times([("time", clock(|| drop(black_box(Mesh::from_faces(shape.positions.len(), faces)))))]))
    };
    let building = |threads: Threads| -> Contender<'_> {
        Box::new(move || {
            let ms = clock(|| {
                let clusters = Clusters::new(mesh, &shape.positions, threads);
                drop(black_box((Arranged::new(mesh, &clusters, threads), clusters)));
            });
            Ok(times([("time", ms)]))
        })
    };
    let contenders: Vec<(&str, Contender<'_>)> = vec![
        ("topology", Box::new(topology)),
        ("one thread", building(Threads::ONE)),
        ("all", building(Threads::all())),
    ];
    let entries = compare(Rounds::exactly(ROUNDS), contenders, &())?;
    let [topology, alone, all] = [0, 1, 2].map(|at| entries[at].ms("time"));
    let faces = shape.faces.len();
    let bytes = Clusters::new(mesh, &shape.positions, Threads::all()).bytes() as f64 / faces as f64;
    let ratio = all / topology;
    println!("| {name} | {faces} | {topology:.1} | {alone:.1} | {all:.1} | {ratio:.2} | {bytes:.1} |");
    Ok(())
}
