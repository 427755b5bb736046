//! Errors of a scene when its shadow volumes are recorded or drawn.

use rimline::gpu::{Caster, FrameInputs, LightMask, Scene, SceneFrame, SceneOptions, View};
use rimline::gpu::{ShadowError, ShadowFormat, ShadowPipelines};
use rimline::{CameraError, Counting, DepthDirection, Light, LightError, ShadowCamera};

use crate::scene::Eye;
use crate::trials::Test;
use glam::DVec3;
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::{text, views};
use rimline_testkit::passes::draw_small;
use rimline_testkit::refusals::{Expected, is, refusal, refused, shows};
use rimline_testkit::{IDENTITY, shapes};

pub(crate) const TESTS: &[Test] = &[
    ("scenes_refuse_cameras_lights_and_faces", recording),
    ("frames_of_scenes_refuse_what_does_not_go_with_them", drawing),
];

fn camera(depth: DepthDirection, far: Option<f64>) -> ShadowCamera {
    let position = DVec3::new(0.0, 1.0, 6.0);
    Eye { is_relative: true, depth, far, ..Eye::new(position, -position, 0.1) }.camera()
}

fn scene(gpu: &Gpu, options: SceneOptions) -> Result<(Scene, Caster), String> {
    let shape = shapes::cube();
    let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
    let mesh = scene.add_mesh(&shape.mesh().map_err(text)?, &shape.positions).map_err(text)?;
    Ok((scene, Caster::rigid(mesh, IDENTITY)))
}

fn encode(gpu: &Gpu, scene: &mut Scene, cameras: &[ShadowCamera]) -> Result<SceneFrame, ShadowError> {
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let frame = scene.encode(&mut encoder, FrameInputs::new(&views(cameras)));
    gpu.queue.submit([encoder.finish()]);
    frame
}

fn recording() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let good = camera(DepthDirection::Reversed, None);
    let (mut scene_a, caster) = scene(gpu, SceneOptions::default())?;
    let bad = ShadowCamera { view_projection: [[0.0; 4]; 4], ..good };
    let singular = ShadowError::ViewCamera { view: 1, error: CameraError::Singular };
    refused([refusal("a singular camera", encode(gpu, &mut scene_a, &[good, bad]), is(singular))])?;
    // A light that extraction takes and shadows do not. It is refused at once, and nothing changes.
    let light = scene_a.add_light(Light::point([1.0, 5.0, 3.0])).map_err(text)?;
    let negative = Light::homogeneous([1.0, 2.0, 3.0, -1.0]);
    let expected = || is(ShadowError::Light(LightError::NegativeWeight { index: 0, w: -1.0 }));
    refused([
        refusal("a negative w", scene_a.add_light(negative), expected()),
        refusal("a light's negative w", scene_a.set_light(light, negative), expected()),
        refusal("the light as it was", encode(gpu, &mut scene_a, &[good]), Expected::Taken),
    ])?;
    let caster = scene_a.insert(caster).map_err(text)?;
    let too_many = ShadowError::NoSuchFace { face: 12, faces: 12 };
    refused([
        refusal("all good", encode(gpu, &mut scene_a, &[good]), Expected::Taken),
        refusal("a face too many", scene_a.set_excluded(caster, light, &[3, 12]), is(too_many)),
        refusal("the last face", scene_a.set_excluded(caster, light, &[3, 11]), Expected::Taken),
        refusal("removal", scene_a.remove_light(light), Expected::Taken),
        refusal(
            "a light that is gone",
            scene_a.set_excluded(caster, light, &[3]),
            is(ShadowError::Removed { what: "light" }),
        ),
        refusal("without light", encode(gpu, &mut scene_a, &[good]), Expected::Taken),
    ])
}

fn drawing() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let other_device = &gpu.another(wgpu::Features::empty(), wgpu::Limits::default())?;
    let format = ShadowFormat::default();
    let made = |counting| ShadowPipelines::new(&gpu.pipelines, &format, counting).map_err(text);
    let right = made(Counting::Auto)?;
    let in_batches = ShadowPipelines::in_batches(&gpu.pipelines, &format, Counting::Auto).map_err(text)?;
    let elsewhere = ShadowPipelines::new(&other_device.pipelines, &format, Counting::Auto).map_err(text)?;
    let (mut scene_a, caster) = scene(gpu, SceneOptions::default())?;
    let light = scene_a.add_light(Light::point([1.0, 5.0, 3.0])).map_err(text)?;
    scene_a.insert(caster).map_err(text)?;
    let (mut other, _) = scene(gpu, SceneOptions::default())?;
    let foreign = other.add_light(Light::point([1.0, 5.0, 3.0])).map_err(text)?;
    let view = View { lights: LightMask::ALL.without(foreign), ..View::new(camera(DepthDirection::Reversed, None)) };
    let without = gpu.submit(|encoder| other.encode(encoder, FrameInputs::new(&[view])).map_err(text))?;
    let first = encode(gpu, &mut scene_a, &[camera(DepthDirection::Reversed, None)]).map_err(text)?;
    let frame = encode(gpu, &mut scene_a, &[camera(DepthDirection::Reversed, None)]).map_err(text)?;
    let later = scene_a.add_light(Light::point([2.0, 5.0, 3.0])).map_err(text)?;
    let draw = |frame: &SceneFrame, pipelines: &ShadowPipelines, view: usize, light| {
        draw_small(gpu, |pass| frame.draw(pass, pipelines, view, light))
    };
    refused([
        refusal("all good", draw(&frame, &right, 0, light)?, Expected::Taken),
        refusal("an earlier frame", draw(&first, &right, 0, light)?, is(ShadowError::StaleFrame)),
        refusal("a view too many", draw(&frame, &right, 1, light)?, is(ShadowError::NoSuchView { view: 1, views: 1 })),
        refusal("a light left out", draw(&without, &right, 0, foreign)?, is(ShadowError::NotInView { view: 0 })),
        refusal("a later light", draw(&frame, &right, 0, later)?, is(ShadowError::NotEncoded)),
        refusal("a foreign light", draw(&frame, &right, 0, foreign)?, is(ShadowError::OtherScene { what: "light" })),
        refusal("in batches", draw(&frame, &in_batches, 0, light)?, is(ShadowError::CountBatches { count_batches: 1 })),
        refusal("another device", draw(&frame, &elsewhere, 0, light)?, shows(&["Device(OtherDevice {"])),
    ])
}
