//! Normals that the device computes, against those of the CPU.

use std::f32::consts::FRAC_PI_2;

use glam::Vec3;
use rimline_picture::{NormalPipeline, Resources, Smoothing, corner_normals};
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::Dispatch;
use rimline_testkit::harness::Test;

use crate::support::Outcome;

pub(crate) const TESTS: [Test; 1] = [("a fan of very many faces has the normal of all of them", of_a_fan)];

/// Faces of both parts of the fan. llvmpipe ends the loops of an invocation after 65,535 turns.
const FACES: [u32; 2] = [66_000, 4000];

const COPY: &str = "
@group(0) @binding(0) var<storage, read> words: array<u32>;
@group(0) @binding(1) var<storage, read_write> copy: array<u32>;
@compute @workgroup_size(64) fn copied(@builtin(global_invocation_id) id: vec3<u32>) {
  if (id.x < arrayLength(&copy)) { copy[id.x] = words[id.x]; }
}
";

/// A quarter of a circle in a plane, and a larger one that is tilted against it, whose faces come last.
fn of_a_fan() -> Outcome {
    let gpu = &*Gpu::shared()?;
    let quarter = |faces: u32, [from, to]: [Vec3; 2]| {
        (0..=faces).map(move |at| {
            let (sine, cosine) = (at as f32 / faces as f32 * FRAC_PI_2).sin_cos();
            (cosine * from + sine * to).to_array()
        })
    };
    let flat = quarter(FACES[0], [Vec3::Z, Vec3::X]);
    let tilted = quarter(FACES[1], [10.0 * Vec3::X, Vec3::new(0.0, 5.0, -8.66)]);
    let positions: Vec<[f32; 3]> = std::iter::once([0.0; 3]).chain(flat).chain(tilted).collect();
    let second = FACES[0] + 2;
    let edges = (1..=FACES[0]).chain(second..second + FACES[1]);
    let faces: Vec<[u32; 3]> = edges.map(|at| [0, at, at + 1]).collect();
    let (resources, pipeline) = (Resources::new((&gpu.device, &gpu.queue), 1), NormalPipeline::new(&gpu.device));
    let buffers = [&gpu.storage(&positions), &gpu.storage(&faces)];
    let normals = pipeline.normals(&resources.factory, &Smoothing::of(&positions, &faces), buffers);
    gpu.submit(|encoder| {
        pipeline.encode(encoder, [&normals]);
        Ok(())
    })?;
    let copy = gpu.storage(&vec![0_u32; 3 * faces.len()]);
    let workgroups = (3 * faces.len()).div_ceil(64) as u32;
    Dispatch::new(gpu, COPY, "copied").run(gpu, &[&normals.buffer, &copy], workgroups)?;
    let found: Vec<u32> = gpu.read(&copy, usize::MAX)?;
    let expected = corner_normals(&positions, &faces);
    let is_near = |a: u32, b: u32| [0, 16].into_iter().all(|at| ((a >> at) as i16).abs_diff((b >> at) as i16) < 300);
    match found.iter().zip(&expected).position(|(a, b)| !is_near(*a, *b)) {
        Some(at) => Err(format!("corner {at}: {:08x}, expected {:08x}", found[at], expected[at])),
        None => Ok(()),
    }
}
