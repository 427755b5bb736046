//! Rimline's topology build against meshoptimizer's adjacency generation, on the same meshes in the same run:
//! `cargo run --release -p rimline-bench-adjacency`.
//!
//! meshoptimizer's call welds by position inside, as [`Mesh::new`] does; [`Mesh::from_faces`] takes welded faces as
//! they are. Both are shown. All run on one thread. Making the inputs and freeing the results are not timed.

use std::hint::black_box;

use meshopt::VertexDataAdapter;
use rimline::Mesh;
use rimline::mesh::Weld;
use rimline_bench::engine::{Contender, Metric, Rounds, Sample, clock, times};
use rimline_bench::row::compare;
use rimline_bench::shapes::{Shape, torus};

/// Runs of each method on each mesh; the methods take turns, so that a slow spell of the machine hits all of them.
const RUNS: usize = 11;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let ordered = torus(1024, 512, 1.0, 0.25);
    let shuffled = ordered.shuffled(20_030_601);
    println!("{} faces, {RUNS} interleaved runs, one thread, milliseconds", ordered.faces.len());
    println!();
    println!("| mesh | method | median | least | most | meshoptimizer ÷ it |");
    println!("|---|---|---:|---:|---:|---:|");
    for (name, shape) in [("torus", &ordered), ("torus, shuffled", &shuffled)] {
        measure(name, shape)?;
    }
    Ok(())
}

fn measure(name: &str, shape: &Shape) -> Result<(), Box<dyn std::error::Error>> {
    let bytes = bytemuck::cast_slice(&shape.positions);
    let vertices = VertexDataAdapter::new(bytes, size_of::<[f32; 3]>(), 0)?;
    let indices: &[u32] = bytemuck::cast_slice(&shape.faces);
    let count = shape.positions.len();
    assert!(agree(shape, &meshopt::generate_adjacency_indices(indices, &vertices))?, "the methods disagree");

    let contenders: Vec<(&str, Contender<'_>)> = vec![
        (
            "meshopt_generateAdjacencyIndexBuffer",
            Box::new(|| Ok(time(|| meshopt::generate_adjacency_indices(black_box(indices), &vertices)))),
        ),
        (
            "Mesh::from_faces",
            Box::new(|| {
                let faces = shape.faces.clone();
                Ok(time(|| Mesh::from_faces(count, black_box(faces))))
            }),
        ),
        (
            "Mesh::new (welds too)",
            Box::new(|| Ok(time(|| Mesh::new(black_box(&shape.positions), &shape.faces, Weld::Data)))),
        ),
    ];
    let entries = compare(Rounds::exactly(RUNS), contenders, &())?;
    for entry in &entries {
        let Some(summary) = entry.summary(Metric::Time("time")) else { continue };
        let (median, [least, most]) = (summary.median, summary.range);
        let ratio = entries[0].ms("time") / median;
        println!("| {name} | {} | {median:.1} | {least:.1} | {most:.1} | {ratio:.2} |", entry.variant.name);
    }
    Ok(())
}

/// Milliseconds of some work, without the time to free its result.
fn time<T>(run: impl FnOnce() -> T) -> Sample {
    let mut result = None;
    let ms = clock(|| result = Some(black_box(run())));
    drop(result);
    times([("time", ms)])
}

/// Whether both found the same neighbour across every edge of a closed mesh: meshoptimizer gives, after each corner of
/// a face, the vertex opposite the edge that starts there.
fn agree(shape: &Shape, adjacency: &[u32]) -> Result<bool, rimline::MeshError> {
    let mesh = shape.mesh()?;
    let across = |face: u32, [a, b]: [u32; 2]| {
        let corners = shape.faces[face as usize];
        (0..3)
            .find(|&corner| [corners[corner], corners[(corner + 1) % 3]] == [a, b])
            .map(|corner| adjacency[face as usize * 6 + corner * 2 + 1])
    };
    let opposite = |face: u32, edge: [u32; 2]| shape.faces[face as usize].into_iter().find(|v| !edge.contains(v));
    Ok(mesh.is_closed()
        && mesh.edges().iter().all(|edge| {
            let [a, b] = edge.vertices;
            edge.face_1.is_some_and(|face_1| {
                across(edge.face_0, [a, b]) == opposite(face_1, [a, b])
                    && across(face_1, [b, a]) == opposite(edge.face_0, [a, b])
            })
        }))
}
