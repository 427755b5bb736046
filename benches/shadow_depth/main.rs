//! `cargo bench --bench shadow_depth`: triples of point, light and face a second, on the GPU and on the CPU, with and
//! without skipping; points on the mesh and around it. `--quick` for a small mesh, `--large` for one of a million faces.

use rimline::Light;
use rimline::gpu::{PositionBuffer, ShadowQuery, ShadowQueryOptions};
use rimline::internals::cpu::{Threads, shadow_depth};
use rimline_bench::Error;
use rimline_bench::engine::{Contender, Rounds, clock, times};
use rimline_bench::gpu::{Gpu, Stopwatch};
use rimline_bench::row::compare;
use rimline_bench::shapes::{self, Shape};
use wgpu::BufferUsages;

const ROUNDS: usize = 5;

fn main() -> Result<(), Error> {
    let has = |wanted: &str| std::env::args().any(|argument| argument == wanted);
    let (shape, points) = match (has("--quick"), has("--large")) {
        (true, _) => (shapes::torus(64, 32, 1.0, 0.4), 1 << 12),
        (_, true) => (shapes::torus(1024, 512, 1.0, 0.4), 1 << 20),
        _ => (shapes::torus(256, 128, 1.0, 0.4), 1 << 16),
    };
    let (gpu, name) = Gpu::first(wgpu::Features::empty())?;
    println!("{} faces, {points} points, 1 light; median of {ROUNDS}; {name}", shape.faces.len());
    for (order, shape) in [("in order", shape.clone()), ("shuffled", shape.shuffled(1))] {
        let on_mesh: Vec<_> = (0..points).map(|index| on_face(&shape, index)).collect();
        let around: Vec<_> = on_mesh.iter().map(|p| p.map(|c| 1.3 * c + 0.01)).collect();
        for (title, points) in [("on the mesh", &on_mesh), ("around it", &around)] {
            println!("faces {order}, points {title}");
            // A part of the points is enough for what is slow.
            let of = |part: usize| &points[..points.len() / if order == "shuffled" { 16 } else { part }];
            measure(&gpu, &shape, [of(1), of(16)])?;
        }
    }
    Ok(())
}

/// All points on the GPU, few without skipping and on the CPU.
fn measure(gpu: &Gpu, shape: &Shape, [points, few]: [&[[f32; 3]]; 2]) -> Result<(), Error> {
    let (mesh, lights) = (shape.mesh()?, [Light::point([2.5, 1.5, 3.0])]);
    let on_gpu = |points: &[[f32; 3]], skip_by_boxes| -> Result<Contender<'_>, Error> {
        let (count, stopwatch) = (points.len() as u32, Stopwatch::new(gpu));
        let options = ShadowQueryOptions { max_points: count, skip_by_boxes, ..Default::default() };
        let mut query = ShadowQuery::new(&gpu.device, &mesh, options)?;
        let buffers = [&shape.positions[..], points].map(|points| gpu.buffer(BufferUsages::STORAGE, points));
        Ok(Box::new(move || {
            let [positions, points] = [0, 1].map(|at| PositionBuffer { buffer: &buffers[at], offset: 0, stride: 12 });
            let [recording, running] = stopwatch
                .by_clock(|encoder| Ok(query.encode_at(encoder, positions, points, count, &lights).map(drop)?))?;
            Ok(times([("time", recording + running)]))
        }))
    };
    let on_cpu = || {
        let depths = || drop(shadow_depth(&shape.positions, &mesh, few, &lights, Threads::all()).expect("good lights"));
        Ok(times([("time", clock(depths))]))
    };
    let contenders: Vec<(&str, Contender<'_>)> =
        vec![("GPU", on_gpu(points, true)?), ("GPU, no skipping", on_gpu(few, false)?), ("CPU", Box::new(on_cpu))];
    for (entry, points) in compare(Rounds::exactly(ROUNDS), contenders, &())?.iter().zip([points, few, few]) {
        let (name, ms, points) = (&entry.variant.name, entry.ms("time"), points.len() as f64);
        let seconds = ms / 1e3;
        let pairs = points * shape.faces.len() as f64;
        println!(
            "  {name:<18} {points:>8} points {ms:>10.2} ms {:>8.2} M points/s {:>9.2} G pairs of point and face/s",
            points / seconds / 1e6,
            pairs / seconds / 1e9
        );
    }
    Ok(())
}

/// A point on a face, spread over the mesh.
fn on_face(shape: &Shape, index: usize) -> [f32; 3] {
    let face = shape.faces[index.wrapping_mul(0x9e37_79b1) % shape.faces.len()];
    let [a, b, c] = face.map(|vertex| shape.positions[vertex as usize]);
    let (s, t) = (0.1 + 0.1 * (index % 4) as f32, 0.1 + 0.1 * (index % 5) as f32);
    std::array::from_fn(|axis| a[axis] + s * (b[axis] - a[axis]) + t * (c[axis] - a[axis]))
}
