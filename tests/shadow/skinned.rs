//! A skinned figure in motion: what the deform stage wrote, against rays through it.

use rimline::Counting;
use rimline::gpu::{Deformer, DeformerOptions};
use rimline_testkit::shapes::Shape;

use crate::classes::with_caster;
use crate::render::Renderer;
use crate::trials::{RIGHT, Tally, Test, Traced, every, frames};
use rimline_testkit::device::Gpu;
use rimline_testkit::models::bending_tube;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;

pub(crate) const TESTS: &[Test] = &[("skinned_figure_in_motion", skinned)];

/// One deformer, pose after pose. Rays through the pose before must not match the counts of the next.
fn skinned() -> Result<(), String> {
    let gpu = Gpu::shared()?;
    let renderer = Renderer::new(&gpu);
    let (model, pose) = bending_tube();
    let deformer = Deformer::new(&gpu.pipelines, &model, DeformerOptions::default()).map_err(text)?;
    let mut tally = Tally::default();
    let mut shape = Shape { positions: Vec::new(), faces: model.geometries()[0].faces().to_vec() };
    let mut noticed = 0;
    for number in 0..frames() {
        let seed = 9000 + number;
        let pose = pose(number as f32 * 0.4);
        gpu.submit(|encoder| deformer.encode(encoder, &pose).map_err(text))?;
        let positions = gpu.read(deformer.positions().buffer, model.vertex_count())?;
        let before = std::mem::replace(&mut shape.positions, positions);
        let traced = Traced::of(with_caster(&mut Random::new(seed), shape.clone()), seed);
        tally.add(&traced, &renderer, &RIGHT, true);
        if number > 0 {
            let mut stale = traced.frame.clone();
            stale.bodies[0].shape.positions = before;
            let counted = renderer.count(&traced.frame, Counting::Auto)?;
            let stale = Traced::of(stale, seed);
            let wrong = stale.compared().counts(&counted.stencils[0], &every(&counted, 0));
            noticed += usize::from(!wrong.pixels.is_empty());
        }
    }
    println!("the pose before noticed {noticed} times");
    if noticed == 0 {
        return Err("negative control: the pose before went unnoticed".to_owned());
    }
    tally.result("skinned figure in motion")
}
