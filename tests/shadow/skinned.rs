//! A skinned figure in motion: what the deform stage wrote, against rays through it.

use glam::{Affine3A, DVec3, Vec3};
use rimline::gpu::{Deformer, DeformerOptions, FrameInputs, Scene, SceneOptions};
use rimline::{Counting, Instance, Light, Model, Pose, wgpu};
use rimline_testkit::shapes::Shape;

use crate::classes::with_caster;
use crate::render::{Placing, Renderer};
use crate::scene::{Body, Eye, Frame};
use crate::trials::{RIGHT, Tally, Test, Traced, every, frames};
use rimline_testkit::device::Gpu;
use rimline_testkit::models::bending_tube;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::{must_fail, same};

pub(crate) const TESTS: &[Test] = &[("skinned_figure_in_motion", skinned), ("culled_casters_show_nowhere", culled)];

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

/// Figures in a room, of which a frame deforms those that it needs: the same depths and stencil counts as with all of
/// them. The others are points then. Figures walk out of sight and back.
fn culled() -> Result<(), String> {
    const INSTANCES: usize = 12;
    let gpu = Gpu::shared()?;
    let (tube, bend) = bending_tube();
    let geometry = &tube.geometries()[0];
    let model = Model::new(vec![geometry.clone()], vec![Instance::new(0, None); INSTANCES]).map_err(text)?;
    let other = Deformer::new(&gpu.pipelines, &model, DeformerOptions::default()).map_err(text)?;
    let rest = Pose::new(vec![bend(0.0).instances()[0].clone(); INSTANCES]);
    let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, SceneOptions::default()).map_err(text)?;
    let inserted = scene.insert_model(&model, &rest, DeformerOptions::default()).map_err(text)?;
    let lights: Vec<Light> =
        vec![Light::point([-3.0, 4.0, 2.0]).with_range(9.0), Light::point([8.0, 6.0, -7.0]).with_range(9.0)];
    for light in &lights {
        scene.add_light(*light).map_err(text)?;
    }
    let (mut count, mut noticed, mut shadowed, mut turned) = (0, 0, 0, 0);
    let mut before = vec![0; INSTANCES];
    for number in 0..2 * frames() {
        let mut random = Random::new(9100 + number);
        println!("seed {}", 9100 + number);
        let pose = |_| {
            let bent = bend(number as f32 * 0.4);
            let at = [random.between(-10.0, 10.0), random.between(-1.5, 1.0), random.between(-10.0, 10.0)];
            let placed = bent.placed(Affine3A::from_translation(at.into())).map_err(text)?;
            Ok::<_, String>(placed.instances()[0].clone())
        };
        let pose = Pose::new((0..INSTANCES).map(pose).collect::<Result<_, _>>()?);
        scene.set_pose(inserted, &pose).map_err(text)?;
        let eye = Vec3::from(random.direction()) * Vec3::new(6.0, 1.0, 6.0);
        let forward = DVec3::new(f64::from(random.between(-1.0, 1.0)), -0.1, f64::from(random.between(-1.0, 1.0)));
        let eye = Eye { is_relative: true, ..Eye::new(eye.as_dvec3(), forward, 0.1) };
        let inputs = [eye.camera().into()];
        gpu.submit(|encoder| {
            scene.encode(encoder, FrameInputs::new(&inputs)).map_err(text)?;
            other.encode(encoder, &pose).map_err(text)
        })?;
        let culled_positions = scene.positions(inserted).map_err(text)?.buffer;
        let points: Vec<[f32; 3]> = gpu.read(culled_positions, model.vertex_count())?;
        let is_point = |positions: &[[f32; 3]]| u32::from(positions.iter().all(|position| *position == [0.0; 3]));
        let words: Vec<u32> = points.chunks(geometry.positions().len()).map(is_point).collect();
        count += words.iter().sum::<u32>();
        turned += words.iter().zip(&before).filter(|(now, before)| now != before).count();
        before = words;
        let frame = |positions: &wgpu::Buffer| -> Result<Frame, String> {
            let all: Vec<[f32; 3]> = gpu.read(positions, model.vertex_count())?;
            let casters = all.chunks(geometry.positions().len()).map(|positions| {
                Body::caster(Shape { positions: positions.to_vec(), faces: geometry.faces().to_vec() })
            });
            let bodies = casters.chain([Body::room([0.0, 3.0, 0.0], 13.0)]).collect();
            Ok(Frame { bodies, eye, lights: lights.clone(), size: 64 })
        };
        let (culled, all) = (frame(culled_positions)?, frame(other.positions().buffer)?);
        let renderer = Renderer { placing: Placing::Scene, range: 9.0, ..Renderer::new(&gpu) };
        let [found, expected] = [&culled, &all].map(|frame| renderer.count(frame, Counting::Auto));
        let (found, expected) = (found?, expected?);
        same("stencil counts", &found.stencils, &expected.stencils)?;
        shadowed += expected.stencils.iter().flatten().filter(|count| **count > 0).count();
        // Negative control: points instead of what is needed.
        let mut hidden = culled.clone();
        for (body, word) in hidden.bodies.iter_mut().zip(&before) {
            if *word == 0 {
                body.shape.positions.fill([0.0; 3]);
            }
        }
        let hidden = renderer.count(&hidden, Counting::Auto)?;
        if expected.stencils.iter().flatten().any(|count| *count > 0) {
            must_fail("points", &same("stencil counts", &hidden.stencils, &expected.stencils))?;
            noticed += 1;
        }
    }
    println!("{count} figures not needed, {turned} changes, {shadowed} pixels in shadow, {noticed} controls");
    if count < 20 || turned < 10 || shadowed < 500 || noticed < 4 {
        Err("too few of a kind".to_owned())
    } else {
        Ok(())
    }
}
