//! Every good model file at several times of each of its animations: extraction equal to the CPU's bit for bit at the
//! deformed positions, facing to big integers', and closed at every vertex for every light.

use std::path::Path;

use libtest_mimic::Trial;
use rimline::Predicate;
use rimline::gltf::Asset;
use rimline::gpu::{Deformer, DeformerOptions, Extractor, ExtractorOptions};
use rimline::internals::cpu::{self, Threads};
use rimline::mesh::Weld;

use rimline_testkit::device::Gpu;
use rimline_testkit::harness::on_models;
use rimline_testkit::on_gpu::{deformed, read, text};
use rimline_testkit::oracle::{self, unclosed};
use rimline_testkit::random::Random;
use rimline_testkit::{lights, must_fail, same};

/// In two batches.
const LIGHTS: usize = 33;
/// The number of them for which big integers are asked, too; they are slow.
const BY_ORACLE: usize = 12;

/// A test a file.
pub(crate) fn trials() -> Vec<Trial> {
    on_models("file ", check).into_iter().map(|trial| trial.with_kind("gpu")).collect()
}

fn check(path: &Path) -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let asset = Asset::open(path, Weld::Data).map_err(text)?;
    let model = asset.model();
    let deformer = Deformer::new(&gpu.pipelines, model, DeformerOptions::default()).map_err(text)?;
    let animations = asset.animations().iter().enumerate();
    let moments = animations
        .flat_map(|(index, animation)| [0.0, 0.37, 1.0].map(|part| (Some(index), part * animation.duration_s)));
    for (moment, (animation, time_s)) in moments.chain([(None, 0.0)]).enumerate() {
        let what = format!("animation {animation:?} at {time_s} s");
        let pose = asset.pose(animation, time_s).map_err(text)?;
        let (mesh, positions) = (model.mesh(&pose).map_err(text)?, deformed(gpu, &deformer, model, &pose)?);
        // Points and directions about the positions, some in the planes through vertices.
        let mut random = Random::new(81);
        let mut lights = lights(&mut random, LIGHTS);
        for light in lights.iter_mut().step_by(2) {
            let [x, y, z] = positions[random.below(positions.len())];
            light.xyz = [x + random.between(-1.0, 1.0), y, z + random.between(-1.0, 1.0)];
            light.w = 1.0;
        }
        let options = ExtractorOptions { max_lights: LIGHTS, masks: true, lists: None, ..Default::default() };
        let mut extractor = Extractor::new(&gpu.pipelines, &mesh, options).map_err(text)?;
        gpu.submit(|encoder| extractor.encode(encoder, deformer.positions(), &lights).map_err(text))?;
        let found = read(gpu, &extractor, &mesh, LIGHTS)?;
        let twin = cpu::extract(&positions, &mesh, &lights, Predicate::Exact, Threads::all()).map_err(text)?;
        same(&format!("{what}, facing"), &found.facing, &twin.facing)?;
        same(&format!("{what}, masks"), &found.masks, &twin.masks)?;
        same(&format!("{what}, unclosed"), &[unclosed(&mesh, &found.masks, LIGHTS)], &[0])?;
        if moment == 0 {
            let right = oracle::facing(&positions, mesh.faces(), &lights[..BY_ORACLE]);
            let first = |mask: &u32| mask & ((1 << BY_ORACLE) - 1);
            let mut facing: Vec<u32> = found.facing[..right.len()].iter().map(first).collect();
            same("facing, exactly", &facing, &right)?;
            facing[right.len() / 2] ^= 1;
            must_fail("a flipped facing bit", &same("facing", &facing, &right))?;
        }
    }
    Ok(())
}
