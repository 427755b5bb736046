//! Deform on the GPU and on the CPU against the plain `f64` poser, which knows nothing of either: random models, and
//! every good model file at several times of each of its animations.

use std::path::Path;

use libtest_mimic::Trial;
use rimline::gltf::Asset;
use rimline::gpu::{Deformer, DeformerOptions};
use rimline::internals::cpu::{self, Threads};
use rimline::mesh::Weld;
use rimline::{Model, ModelBounds, Pose, wgpu};

use rimline_testkit::device::Gpu;
use rimline_testkit::harness::{Test, on_models};
use rimline_testkit::models::{random_model, random_pose};
use rimline_testkit::on_gpu::{check_deform, deformed, text};
use rimline_testkit::poser::{self, Posed, gltf::File};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail};

pub(crate) const TESTS: &[Test] = &[("deform_equals_the_poser_on_random_models", random_models)];

/// A test a file.
pub(crate) fn trials() -> Vec<Trial> {
    let trials = on_models("deform_equals_the_poser_on ", check);
    trials.into_iter().map(|trial| trial.with_kind("gpu")).collect()
}

/// A coordinate that is not zero throughout, moved by twice its tolerance.
fn control(found: &[[f32; 3]], expected: &[Posed]) -> Result<(), String> {
    let coordinates = || (0..expected.len()).flat_map(|vertex| [0, 1, 2].map(|axis| (vertex, axis)));
    let (vertex, axis) = coordinates()
        .find(|&(vertex, axis)| expected[vertex].tolerance[axis] > 1e-30)
        .ok_or("every vertex is at the origin")?;
    let mut moved = found.to_vec();
    moved[vertex][axis] = (expected[vertex].position[axis] + 2.0 * expected[vertex].tolerance[axis]) as f32;
    must_fail("a moved vertex", &poser::compare("control", &moved, expected))
}

/// GPU and CPU reference agree with the poser, and with each other within the bound that docs/numerics/deform.md derives.
fn random_models() -> Result<(), String> {
    let shared = Gpu::shared()?;
    // Bindings of 256 vertices, so that there are several dispatches.
    let limits = wgpu::Limits { max_storage_buffer_binding_size: 1 << 15, ..wgpu::Limits::default() };
    let small = &Gpu::with(wgpu::Features::empty(), limits)?;
    let seeds = 261..if is_long() { 301 } else { 265 };
    for (gpu, seed) in seeds.flat_map(|seed| [(&*shared, seed), (small, seed)]) {
        let mut random = Random::new(seed);
        // More than one workgroup of 256, and no multiple of it.
        let model = random_model(&mut random, [600, 1, 256, 1111][seed as usize % 4]);
        let deformer = Deformer::new(&gpu.pipelines, &model, DeformerOptions::default()).map_err(text)?;
        for _ in 0..3 {
            let pose = random_pose(&mut random, &model);
            let expected = poser::of_model(&model, &pose);
            let mut on_gpu = deformed(gpu, &deformer, &model, &pose)?;
            let twin = cpu::deform(&model, &pose, 0.0, None, Threads::all()).map_err(text)?;
            let gpu_error = poser::compare(&format!("seed {seed}, GPU"), &on_gpu, &expected)?;
            let cpu_error = poser::compare(&format!("seed {seed}, CPU"), &twin, &expected)?;
            let differ = check_deform(&on_gpu, &model, &pose)?;
            println!("seed {seed}: {gpu_error:.3} and {cpu_error:.3} of the tolerance, {differ} coordinates differ");
            control(&on_gpu, &expected)?;
            within_boxes(&model, &pose, &on_gpu)?;
            let vertex = random.below(on_gpu.len());
            on_gpu[vertex][1] += 1e-4 * (1.0 + on_gpu[vertex][1].abs());
            must_fail("a moved vertex", &check_deform(&on_gpu, &model, &pose))?;
        }
    }
    Ok(())
}

/// At both ends of, before and within each animation; and the file as it stands.
fn moments(asset: &Asset) -> Vec<(Option<usize>, f32)> {
    let parts = [-0.5, 0.0, 0.13, 0.5, 0.71, 1.0];
    let animations = asset.animations().iter().enumerate();
    let times = animations.flat_map(|(index, of)| parts.map(|part| (Some(index), part * of.duration_s)));
    std::iter::once((None, 0.0)).chain(times).collect()
}

/// Positions of the corners of all faces.
fn corners(model: &Model, positions: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let (mut corners, mut first) = (Vec::new(), 0);
    for geometry in model.placed_geometries() {
        corners.extend(geometry.faces().as_flattened().iter().map(|&vertex| positions[first + vertex as usize]));
        first += geometry.positions().len();
    }
    corners
}

/// The largest extent of all corners along an axis, and the largest distance from their expected position.
fn size_and_error(found: &[[f32; 3]], expected: &[Posed]) -> (f64, f64) {
    let (mut size, mut error) = (0.0_f64, 0.0_f64);
    for axis in 0..3 {
        let coordinates = || expected.iter().map(|posed| posed.position[axis]);
        size = size.max(coordinates().fold(f64::MIN, f64::max) - coordinates().fold(f64::MAX, f64::min));
        let errors =
            found.iter().zip(coordinates()).map(|(found, coordinate)| (f64::from(found[axis]) - coordinate).abs());
        error = errors.fold(error, f64::max);
    }
    (size, error)
}

/// Fails where a vertex is outside of the box of its instance; returns the largest length of a box over that of its
/// vertices.
fn within_boxes(model: &Model, pose: &Pose, positions: &[[f32; 3]]) -> Result<f32, String> {
    let boxes = ModelBounds::new(model).boxes(pose, 0.0).map_err(text)?;
    let (mut rest, mut most) = (positions, 0.0_f32);
    for (instance, (geometry, bounds)) in model.placed_geometries().zip(boxes).enumerate() {
        let (instance_positions, others) = rest.split_at(geometry.positions().len());
        let [low, high] = bounds.ok_or_else(|| format!("instance {instance} has no box"))?;
        let ends = [f32::MAX, f32::MIN].map(|end| [end; 3]);
        let [least, greatest] = instance_positions.iter().fold(ends, |[least, greatest], p| {
            [[0, 1, 2].map(|axis| least[axis].min(p[axis])), [0, 1, 2].map(|axis| greatest[axis].max(p[axis]))]
        });
        if let Some(axis) = (0..3).find(|&axis| least[axis] < low[axis] || greatest[axis] > high[axis]) {
            return Err(format!("instance {instance}, axis {axis}: {least:?} {greatest:?} in {low:?} {high:?}"));
        }
        let largest = |[low, high]: [[f32; 3]; 2]| (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f32::max);
        most = most.max(largest([low, high]) / largest([least, greatest]));
        rest = others;
    }
    Ok(most)
}

fn check(path: &Path) -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let asset = Asset::open(path, Weld::Data).map_err(text)?;
    let (model, file) = (asset.model(), File::open(path)?);
    let deformer = Deformer::new(&gpu.pipelines, model, DeformerOptions::default()).map_err(text)?;
    let (mut most, mut relative, mut boxes) = (0.0_f64, 0.0_f64, 0.0_f32);
    for (moment, (animation, time_s)) in moments(&asset).into_iter().enumerate() {
        let pose = asset.pose(animation, time_s).map_err(text)?;
        let expected = file.corners(animation, time_s);
        let positions = deformed(gpu, &deformer, model, &pose)?;
        boxes = boxes.max(within_boxes(model, &pose, &positions)?);
        let on_gpu = corners(model, &positions);
        let twin = corners(model, &cpu::deform(model, &pose, 0.0, None, Threads::all()).map_err(text)?);
        for (device, found) in [("GPU", &on_gpu), ("CPU", &twin)] {
            let what = format!("animation {animation:?} at {time_s} s, {device}");
            most = most.max(poser::compare(&what, found, &expected)?);
            let (size, error) = size_and_error(found, &expected);
            relative = relative.max(error / size);
        }
        if moment == 0 {
            control(&on_gpu, &expected)?;
        }
    }
    println!("{}: {most:.3} of the tolerance, {relative:.1e} of the size", path.display());
    println!("boxes of instances are up to {boxes:.2} times as long as what they hold");
    Ok(())
}
