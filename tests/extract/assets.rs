//! Every good model file at several times of each of its animations: deformation within its bound of the CPU reference,
//! extraction equal to the CPU's bit for bit at the same positions, facing to big integers', and closed at every vertex
//! for every light.

use std::path::Path;

use libtest_mimic::Trial;
use rimline::gltf::Asset;
use rimline::gpu::{Deformer, DeformerOptions, Extractor, ExtractorOptions};
use rimline::internals::cpu::{self, Threads};
use rimline::mesh::Weld;
use rimline::{InstancePose, Light, Mesh, Model, Pose, Predicate};

use rimline_testkit::device::Gpu;
use rimline_testkit::harness::on_models;
use rimline_testkit::on_gpu::read;
use rimline_testkit::on_gpu::{check_deform, deformed, text};
use rimline_testkit::oracle::{self, unclosed};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, lights, must_fail, same};

const LIGHT_COUNTS: [usize; 6] = [1, 12, 31, 32, 33, 100];
/// The number of them for which big integers are asked, too; they are slow.
const BY_ORACLE: usize = 12;

/// A test a file.
pub(crate) fn trials() -> Vec<Trial> {
    on_models("file ", check).into_iter().map(|trial| trial.with_kind("gpu")).collect()
}

/// Before, at both ends of, and within each animation; the rest pose where there is none.
fn moments(asset: &Asset) -> Vec<(Option<usize>, f32)> {
    let animations = asset.animations().iter().enumerate();
    let mut moments: Vec<_> = animations
        .flat_map(|(index, animation)| [0.0, 0.37, 1.0].map(|part| (Some(index), part * animation.duration_s)))
        .collect();
    moments.push((None, 0.0));
    moments
}

/// A model's mesh, with an extractor for each number of lights; made anew when an instance turns over.
struct Extraction {
    turned: Vec<bool>,
    mesh: Mesh,
    extractors: [Option<Extractor>; LIGHT_COUNTS.len()],
}

impl Extraction {
    fn new(model: &Model, pose: &Pose) -> Result<Self, String> {
        let mesh = model.mesh(pose).map_err(text)?;
        Ok(Self { turned: turned(pose), mesh, extractors: [const { None }; LIGHT_COUNTS.len()] })
    }

    /// Extracts at the deformer's positions and compares everything with the CPU reference, and some of it with big
    /// integers.
    fn check(&mut self, gpu: &Gpu, deformer: &Deformer, found: &[[f32; 3]], index: usize) -> Result<(), String> {
        let Self { mesh, extractors, .. } = self;
        let count = LIGHT_COUNTS[index];
        let lights = around(found, count);
        let options = ExtractorOptions { max_lights: count, masks: true, lists: None, ..Default::default() };
        let extractor = match &mut extractors[index] {
            Some(extractor) => extractor,
            empty => empty.insert(Extractor::new(&gpu.pipelines, mesh, options).map_err(text)?),
        };
        gpu.submit(|encoder| extractor.encode(encoder, deformer.positions(), &lights).map_err(text))?;
        let on_gpu = read(gpu, extractor, mesh, count)?;
        let twin = cpu::extract(found, mesh, &lights, Predicate::Exact, Threads::all());
        let twin = twin.map_err(text)?;
        same("facing", &on_gpu.facing, &twin.facing)?;
        same("masks", &on_gpu.masks, &twin.masks)?;
        if count == BY_ORACLE {
            let right = oracle::facing(found, mesh.faces(), &lights);
            same("facing, exactly", &on_gpu.facing, &right)?;
            let mut wrong = on_gpu.facing.clone();
            wrong[mesh.faces().len() / 2] ^= 1;
            must_fail("a flipped facing bit", &same("facing", &wrong, &right))?;
        }
        match unclosed(mesh, &on_gpu.masks, count) {
            0 => Ok(()),
            open => Err(format!("{open} vertices are not closed")),
        }
    }
}

fn turned(pose: &Pose) -> Vec<bool> {
    pose.instances().iter().map(InstancePose::faces_turned).collect()
}

/// Points and directions about the positions, some in the planes through vertices.
fn around(positions: &[[f32; 3]], count: usize) -> Vec<Light> {
    let mut random = Random::new(81);
    let mut lights = lights(&mut random, count);
    for light in lights.iter_mut().step_by(2) {
        let [x, y, z] = positions[random.below(positions.len())];
        *light = Light::point([x + random.between(-1.0, 1.0), y, z + random.between(-1.0, 1.0)]);
    }
    lights
}

fn check(path: &Path) -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let asset = Asset::open(path, Weld::Data).map_err(text)?;
    let model = asset.model();
    let deformer = Deformer::new(&gpu.pipelines, model, DeformerOptions::default()).map_err(text)?;
    let mut extraction = Extraction::new(model, &asset.pose(None, 0.0).map_err(text)?)?;
    for (moment, (animation, time_s)) in moments(&asset).into_iter().enumerate() {
        let pose = asset.pose(animation, time_s).map_err(text)?;
        if turned(&pose) != extraction.turned {
            extraction = Extraction::new(model, &pose)?;
        }
        let found = deformed(gpu, &deformer, model, &pose)?;
        check_deform(&found, model, &pose)?;
        // All numbers of lights for the first moment, then one after the other.
        let all = moment == 0 || is_long();
        for index in
            if all { 0..LIGHT_COUNTS.len() } else { moment % LIGHT_COUNTS.len()..moment % LIGHT_COUNTS.len() + 1 }
        {
            let what = format!("animation {animation:?} at {time_s} s, {} lights", LIGHT_COUNTS[index]);
            extraction.check(gpu, &deformer, &found, index).map_err(|error| format!("{what}: {error}"))?;
        }
        if moment == 0 {
            let mut wrong = found;
            wrong[0][1] += 1e3;
            must_fail("a moved vertex", &check_deform(&wrong, model, &pose))?;
        }
    }
    Ok(())
}
