//! The same on a GPU: the whole extraction with unordered lists, from submission to its end.

use std::time::Instant;

use rimline::gpu::{Extractor, ExtractorOptions, PositionBuffer, StageTimer};
use rimline::mesh::Weld;
use rimline::{Light, Mesh, wgpu};
use rimline_testkit::device::Gpu;
use rimline_testkit::polygons::{PolygonSet, quad_torus};
use rimline_testkit::random::Random;

use crate::{ROUNDS, SEED};

pub(crate) fn measure(sizes: &[u32]) -> Result<(), String> {
    let gpu = &Gpu::with(wgpu::Features::TIMESTAMP_QUERY, wgpu::Limits::default())?;
    println!("\n{}; least of {} runs, milliseconds", gpu.name, 4 * ROUNDS);
    println!("| quadrilaterals | bump | 1 light | of triangles | ratio | 8 lights | of triangles | ratio |");
    println!("|---:|---:|---:|---:|---:|---:|---:|---:|");
    for &size in sizes {
        for bump in [0.0, 0.0001, 0.001] {
            compare(gpu, &quad_torus(&mut Random::new(SEED), size, size, bump), bump)?;
        }
    }
    Ok(())
}

fn compare(gpu: &Gpu, set: &PolygonSet, bump: f32) -> Result<(), String> {
    let text = |error: &dyn std::fmt::Display| error.to_string();
    let mesh = set.mesh(Weld::Keep).map_err(|error| text(&error))?;
    let triangles = Mesh::new(&set.positions, mesh.faces(), Weld::Keep).map_err(|error| text(&error))?;
    let mut random = Random::new(SEED);
    let lights: Vec<Light> = (0..8).map(|_| Light::point(random.direction().map(|c| 6.0 * c))).collect();
    let buffer = gpu.storage(&set.positions);
    let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    let mut cells = Vec::new();
    for lights in [&lights[..1], &lights[..]] {
        let options = ExtractorOptions { max_lights: lights.len(), ..ExtractorOptions::default() };
        let make = |mesh| Extractor::new(&gpu.pipelines, mesh, options).map_err(|error| text(&error));
        let mut extractors = [make(&mesh)?, make(&triangles)?];
        let mut least = [f64::INFINITY; 2];
        // One more, in which shaders are compiled.
        for _ in 0..=4 * ROUNDS {
            for (extractor, least) in extractors.iter_mut().zip(&mut least) {
                let start = Instant::now();
                gpu.submit(|encoder| extractor.encode(encoder, positions, lights, None).map_err(|error| text(&error)))?;
                gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| text(&error))?;
                *least = least.min(start.elapsed().as_secs_f64() * 1e3);
            }
        }
        cells.push(format!("{:.2} | {:.2} | {:.2}", least[0], least[1], least[0] / least[1]));
    }
    println!("| {} | {bump} | {} |", mesh.face_count(), cells.join(" | "));
    if std::env::args().any(|argument| argument == "--stages") {
        stages(gpu, set, [&mesh, &triangles], &lights[..1])?;
        stages(gpu, set, [&mesh, &triangles], &lights)?;
    }
    Ok(())
}

/// The least time of each stage, of the polygons and of their triangles.
fn stages(gpu: &Gpu, set: &PolygonSet, meshes: [&Mesh; 2], lights: &[Light]) -> Result<(), String> {
    let text = |error: &dyn std::fmt::Display| error.to_string();
    let buffer = gpu.storage(&set.positions);
    let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    for mesh in meshes {
        let mut extractor = {
            let options = ExtractorOptions { max_lights: lights.len(), ..ExtractorOptions::default() };
            Extractor::new(&gpu.pipelines, mesh, options).map_err(|error| text(&error))?
        };
        let mut timer = StageTimer::new(&gpu.device, &gpu.queue).ok_or("no timestamps")?;
        let mut least: Vec<(&str, f64)> = Vec::new();
        for round in 0..=4 * ROUNDS {
            timer.clear();
            gpu.submit(|encoder| {
                extractor.encode(encoder, positions, lights, Some(&mut timer)).map_err(|error| text(&error))?;
                timer.resolve(encoder);
                Ok(())
            })?;
            let times = timer.read(&gpu.device, &gpu.queue).map_err(|error| text(&error))?;
            if round == 0 {
                least = times;
            } else {
                least.iter_mut().zip(times).for_each(|(least, time)| least.1 = least.1.min(time.1));
            }
        }
        let of_stage: Vec<_> = least.iter().map(|(name, time)| format!("{name} {time:.2}")).collect();
        println!("stages, milliseconds: {}", of_stage.join(", "));
    }
    Ok(())
}
