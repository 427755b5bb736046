//! Vertices of very many morph targets and influences. Software devices end an invocation's loops after 65,535 turns
//! without a word, which would leave positions short.

use rimline::gpu::{DeformError, Deformer, DeformerOptions};
use rimline::internals::cpu::{self, Threads};
use rimline::{Geometry, GeometryOptions, Influences, Instance, InstancePose, Model, Pose};

use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{deformed, text};
use rimline_testkit::refusals::{refusal, refused, says};
use rimline_testkit::{must_fail, same};

pub(crate) const TESTS: &[Test] = &[
    ("many_morph_targets_and_influences_are_all_added", all_are_added),
    ("more_terms_than_loops_may_take_are_refused", too_many),
];

/// The most that both may be together, as `DeformError::TooManyTerms` says it.
const LIMIT: u32 = 60_000;

/// A triangle of `targets` morph targets, each of which moves it by 1 along x, and of `influences` a vertex: the first
/// leaves it in place, each other adds 1 to y. So x counts targets, and y influences; both are exact.
fn counting(targets: u32, influences: u32) -> Result<(Model, Pose), String> {
    let (offsets, mut joints) = ((0..=3).map(|vertex| vertex * influences).collect(), Vec::new());
    for _ in 0..3 {
        joints.push(0);
        joints.resize(joints.len() + influences as usize - 1, 1);
    }
    let weights = vec![1.0; joints.len()];
    let options = GeometryOptions {
        morph_targets: vec![vec![[1.0, 0.0, 0.0]; 3]; targets as usize],
        influences: Some(Influences::new(offsets, joints, weights).map_err(text)?),
        ..GeometryOptions::default()
    };
    let positions = vec![[0.0; 3], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]];
    let geometry = Geometry::new(positions, vec![[0, 1, 2]], options).map_err(text)?;
    let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let up = [[0.0; 4], [0.0, 0.0, 0.0, 1.0], [0.0; 4]];
    let pose = InstancePose::new(vec![identity, up], vec![1.0; targets as usize]).map_err(text)?;
    Ok((Model::new(vec![geometry], vec![Instance::new(0, None)]).map_err(text)?, Pose::new(vec![pose])))
}

fn all_are_added() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for (targets, influences) in [(40_000, 20_000), (20_000, 40_000)] {
        let (model, pose) = counting(targets, influences)?;
        let deformer = Deformer::new(&gpu.pipelines, &model, DeformerOptions::default()).map_err(text)?;
        let found = deformed(gpu, &deformer, &model, &pose)?;
        let [x, y] = [targets as f32, influences as f32 - 1.0];
        let expected = [[x, y, 0.0], [x, y, 1.0], [x, y + 1.0, 0.0]];
        same("GPU", &found, &expected)?;
        let twin = cpu::deform(&model, &pose, 0.0, None, Threads::ONE).map_err(text)?;
        same("CPU", &twin, &expected)?;
        let mut short = found;
        short[1][0] -= 1.0;
        must_fail("a target left out", &same("GPU", &short, &expected))?;
    }
    Ok(())
}

fn too_many() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    // The targets' weights decide, not their number.
    let (model, pose) = counting(40_000, 20_001)?;
    let deformer = Deformer::new(&gpu.pipelines, &model, DeformerOptions::default()).map_err(text)?;
    let expected = DeformError::TooManyTerms { instance: 0, targets: 40_000, influences: 20_001, limit: LIMIT };
    gpu.submit(|encoder| same("all targets", &[deformer.encode(encoder, &pose).err()], &[Some(expected.clone())]))?;
    let words = ["instance 0", "20001", "40000", "60000", "cpu::deform"];
    refused([refusal("the message", Err::<(), _>(expected), says(&words))])?;
    let first = &pose.instances()[0];
    let mut weights = first.morph_weights().to_vec();
    weights[7] = 0.0;
    let fewer = Pose::new(vec![InstancePose::new(first.palette().to_vec(), weights).map_err(text)?]);
    same("one target fewer", &deformed(gpu, &deformer, &model, &fewer)?[..1], &[[39_999.0, 20_000.0, 0.0]])?;
    // More influences than the limit alone: refused before anything is made.
    let (model, _) = counting(1, LIMIT + 1)?;
    let refused = DeformError::TooManyTerms { instance: 0, targets: 0, influences: LIMIT + 1, limit: LIMIT };
    same("influences", &[Deformer::new(&gpu.pipelines, &model, DeformerOptions::default()).err()], &[Some(refused)])
}
