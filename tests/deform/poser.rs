//! Deform on the GPU and on the CPU against the plain `f64` poser, which knows nothing of either: random models, and
//! every good model file at several times of each of its animations.

use std::path::Path;

use libtest_mimic::Trial;
use rimline::ModelBounds;
use rimline::gltf::Asset;
use rimline::gpu::{Deformer, DeformerOptions};
use rimline::internals::cpu::{self, Threads};
use rimline::mesh::Weld;

use rimline_testkit::device::Gpu;
use rimline_testkit::harness::{Test, on_models};
use rimline_testkit::models::{random_model, random_pose};
use rimline_testkit::on_gpu::{check_deform, deformed, limited, text};
use rimline_testkit::poser::{self, Posed, corners, gltf::File};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, same};

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
/// Small limits, which take several dispatches and bindings, change no bit.
fn random_models() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let small = [(32 << 10, 64), (32 << 10, 2), (64 << 10, 1)];
    let small = small.map(|(binding, workgroups)| limited(binding, 1 << 20, workgroups));
    let small = small.into_iter().collect::<Result<Vec<_>, _>>()?;
    for seed in 261..if is_long() { 301 } else { 265 } {
        let mut random = Random::new(seed);
        // More than one workgroup of 256, and no multiple of it.
        let model = random_model(&mut random, [600, 1, 256, 2500][seed as usize % 4]);
        let deformer = |gpu: &Gpu| Deformer::new(&gpu.pipelines, &model, DeformerOptions::default()).map_err(text);
        let of_small = small.iter().map(deformer).collect::<Result<Vec<_>, _>>()?;
        let deformer = deformer(gpu)?;
        for _ in 0..3 {
            let pose = random_pose(&mut random, &model);
            let expected = poser::of_model(&model, &pose);
            let mut on_gpu = deformed(gpu, &deformer, &model, &pose)?;
            for (gpu, deformer) in small.iter().zip(&of_small) {
                same(&format!("seed {seed}, small limits"), &deformed(gpu, deformer, &model, &pose)?, &on_gpu)?;
            }
            let twin = cpu::deform(&model, &pose, 0.0, None, Threads::all()).map_err(text)?;
            let gpu_error = poser::compare(&format!("seed {seed}, GPU"), &on_gpu, &expected)?;
            let cpu_error = poser::compare(&format!("seed {seed}, CPU"), &twin, &expected)?;
            let differ = check_deform(&on_gpu, &model, &pose)?;
            println!("seed {seed}: {gpu_error:.3} and {cpu_error:.3} of the tolerance, {differ} coordinates differ");
            control(&on_gpu, &expected)?;
            let boxes = ModelBounds::new(&model).boxes(&pose, 0.0).map_err(text)?;
            poser::within_boxes(&model, &boxes, &on_gpu)?;
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

fn check(path: &Path) -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let asset = Asset::open(path, Weld::Data).map_err(text)?;
    let (model, file) = (asset.model(), File::open(path)?);
    let deformer = Deformer::new(&gpu.pipelines, model, DeformerOptions::default()).map_err(text)?;
    let bounds = ModelBounds::new(model);
    let mut most = 0.0_f64;
    for (moment, (animation, time_s)) in moments(&asset).into_iter().enumerate() {
        let pose = asset.pose(animation, time_s).map_err(text)?;
        let expected = file.corners(animation, time_s);
        let positions = deformed(gpu, &deformer, model, &pose)?;
        poser::within_boxes(model, &bounds.boxes(&pose, 0.0).map_err(text)?, &positions)?;
        let on_gpu = corners(model, &positions);
        let twin = corners(model, &cpu::deform(model, &pose, 0.0, None, Threads::all()).map_err(text)?);
        for (device, found) in [("GPU", &on_gpu), ("CPU", &twin)] {
            let what = format!("animation {animation:?} at {time_s} s, {device}");
            most = most.max(poser::compare(&what, found, &expected)?);
        }
        if moment == 0 {
            control(&on_gpu, &expected)?;
        }
    }
    println!("{}: {most:.3} of the tolerance", path.display());
    Ok(())
}
