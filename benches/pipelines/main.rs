//! `cargo bench --bench pipelines`: milliseconds to make a further scene of one caster, and to use it first, where each has
//! pipelines of its own, where drawing ones are shared, and where all are. A driver's own cache on disk helps the
//! former; Mesa's is off with `MESA_SHADER_CACHE_DISABLE=true`.

use std::time::Instant;

use glam::Vec3;
use rimline::gpu::{Pipelines, PositionBuffer, ShadowFormat, ShadowPipelines};
use rimline::{Counting, Light};
use rimline_bench::engine::{Contender, Metric, Rounds, interleave};
use rimline_bench::gpu::Gpu;
use rimline_bench::record::{Camera, OneCaster, OneCasterOptions};
use rimline_bench::row::{Entry, Variant};
use rimline_bench::{Error, shapes};

const ROUNDS: usize = 15;
const MAKING: Metric = Metric::Time("making");
const USING: Metric = Metric::Time("first use");

fn main() -> Result<(), Error> {
    let (gpu, name) = Gpu::first()?;
    // Small, so that pipelines are what takes time.
    let shape = shapes::torus(24, 16, 1.0, 0.4);
    let mesh = shape.mesh()?;
    let positions = gpu.buffer(wgpu::BufferUsages::STORAGE, &shape.positions);
    let camera = Camera::level(Vec3::Z * 5.0, Vec3::NEG_Z, 1.0, 0.1).shadow();
    let drawing = |all: &Pipelines| ShadowPipelines::new(all, &ShadowFormat::default(), Counting::Auto);
    let (shared, shared_drawing) = (Pipelines::new(&gpu.device), drawing(&gpu.pipelines)?);
    // Makes a scene; then encodes, submits and waits for them once.
    let run = |shares_drawing: bool, shares_all: bool| {
        let begin = Instant::now();
        let all = if shares_all { shared.clone() } else { Pipelines::new(&gpu.device) };
        let new_drawing = if shares_drawing { None } else { Some(drawing(&all)?) };
        let drawing = new_drawing.as_ref().unwrap_or(&shared_drawing);
        let options = OneCasterOptions { counting: drawing.counting(), ..OneCasterOptions::default() };
        let mut caster = OneCaster::new(&all, &gpu.queue, &mesh, &options)?;
        let made = Instant::now();
        let positions = PositionBuffer { buffer: &positions, offset: 0, stride: 12 };
        let mut encoder = gpu.encoder();
        caster.encode(&mut encoder, positions, &[Light::point([0.0, 5.0, 2.0])], Some(&camera), None)?;
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        let times = [made.duration_since(begin), made.elapsed()].map(|time| time.as_secs_f64() * 1e3);
        Ok(vec![(MAKING, times[0]), (USING, times[1])])
    };
    let names = ["nothing shared", "one `ShadowPipelines`", "one `Pipelines`"];
    let contenders: Vec<Contender<'_>> =
        vec![Box::new(|| run(false, false)), Box::new(|| run(true, false)), Box::new(|| run(true, true))];
    println!("{name}; median of {ROUNDS}, milliseconds\n{:<26} {:>8} {:>10}", "", "making", "first use");
    for (name, samples) in names.into_iter().zip(interleave(Rounds::exactly(ROUNDS), contenders, &())?) {
        let entry = Entry::new(Variant::new(name, name, 0, 0), &samples);
        let [making, using] = [MAKING, USING].map(|metric| entry.median(metric).unwrap_or(f64::NAN));
        println!("{name:<26} {making:>8.2} {using:>10.2}");
    }
    Ok(())
}
