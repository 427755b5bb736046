//! Errors of a scene when its shadow volumes are recorded or drawn.

use rimline::gpu::{
    Caster, Scene, SceneError, SceneFrame, SceneOptions, ScenePipelines, ShadowDrawError, ShadowFormat,
};
use rimline::{CameraError, Counting, DepthDirection, Light, LightError, ShadowCamera};

use crate::scene::Eye;
use crate::trials::Test;
use glam::DVec3;
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::{same, shapes};

pub(crate) const TESTS: &[Test] = &[
    ("scenes_refuse_cameras_lights_and_faces", recording),
    ("frames_of_scenes_refuse_what_does_not_go_with_them", drawing),
];

const ROWS: rimline::Matrix3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

fn camera(depth: DepthDirection, far: Option<f64>) -> ShadowCamera {
    let place = DVec3::new(0.0, 1.0, 6.0);
    Eye { place, forward: -place, near: 0.1, is_relative: true, depth, far, half_width: None }.camera()
}

fn scene(gpu: &Gpu, options: SceneOptions) -> Result<(Scene, Caster), String> {
    let shape = shapes::cube();
    let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
    let mesh = scene.add_mesh(&shape.mesh().map_err(text)?, &shape.positions).map_err(text)?;
    Ok((scene, Caster::rigid(mesh, ROWS)))
}

fn encode(gpu: &Gpu, scene: &mut Scene, cameras: &[ShadowCamera]) -> Result<SceneFrame, SceneError> {
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let frame = scene.encode(&mut encoder, cameras, None);
    gpu.queue.submit([encoder.finish()]);
    frame
}

fn recording() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let good = camera(DepthDirection::Reversed, None);
    let (mut own, caster) = scene(gpu, SceneOptions::default())?;
    let refused = |found: Result<SceneFrame, SceneError>| found.err();
    let bad = ShadowCamera { view_projection: [[0.0; 4]; 4], ..good };
    let error = SceneError::Camera { view: 1, error: CameraError::Singular };
    same("a singular camera", &[refused(encode(gpu, &mut own, &[good, bad]))], &[Some(error)])?;
    // A light that extraction takes and shadows do not.
    let light = own.add_light(Light::homogeneous([1.0, 2.0, 3.0, -1.0])).map_err(text)?;
    same("no camera", &[refused(encode(gpu, &mut own, &[]))], &[None])?;
    let negative = |index| SceneError::Light(LightError::NegativeWeight { index, w: -1.0 });
    same("a negative w", &[refused(encode(gpu, &mut own, &[good]))], &[Some(negative(0))])?;
    // The error names the light's bit, whatever other lights there are.
    let second = own.add_light(Light::homogeneous([1.0, 2.0, 3.0, -1.0])).map_err(text)?;
    own.remove_light(light).map_err(text)?;
    same("a light of bit 1", &[refused(encode(gpu, &mut own, &[good]))], &[Some(negative(1))])?;
    let light = own.add_light(Light::point([1.0, 5.0, 3.0])).map_err(text)?;
    own.remove_light(second).map_err(text)?;
    own.set_light(light, Light::point([1.0, 5.0, 3.0])).map_err(text)?;
    same("all good", &[refused(encode(gpu, &mut own, &[good]))], &[None])?;
    let caster = own.insert(caster).map_err(text)?;
    let outside = own.set_excluded(caster, light, &[3, 12]);
    same("a face too many", &[outside], &[Err(SceneError::NoSuchFace { face: 12, faces: 12 })])?;
    own.set_excluded(caster, light, &[3, 11]).map_err(text)?;
    own.remove_light(light).map_err(text)?;
    let stale = own.set_excluded(caster, light, &[3]);
    same("a light that is gone", &[stale], &[Err(SceneError::Stale { what: "light" })])?;
    same("without light", &[refused(encode(gpu, &mut own, &[good]))], &[None])?;
    let counting = Counting::ZpPlus2005;
    let (mut published, _) = scene(gpu, SceneOptions { counting, ..SceneOptions::default() })?;
    same("as published", &[refused(encode(gpu, &mut published, &[good]))], &[Some(SceneError::Counting(counting))])
}

fn drawing() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let other_device = &gpu.another(wgpu::Features::empty(), wgpu::Limits::default())?;
    let format = ShadowFormat::default();
    let made = |counting| ScenePipelines::new(&gpu.pipelines, &format, counting).map_err(text);
    let right = made(Counting::Auto)?;
    let standard = ShadowFormat { depth: DepthDirection::Standard, ..ShadowFormat::default() };
    let standard = ScenePipelines::new(&gpu.pipelines, &standard, Counting::Auto).map_err(text)?;
    let in_batches = ScenePipelines::in_batches(&gpu.pipelines, &format, Counting::Auto).map_err(text)?;
    let elsewhere = ScenePipelines::new(&other_device.pipelines, &format, Counting::Auto).map_err(text)?;
    let (mut own, caster) = scene(gpu, SceneOptions::default())?;
    let light = own.add_light(Light::point([1.0, 5.0, 3.0])).map_err(text)?;
    own.insert(caster).map_err(text)?;
    let (mut other, _) = scene(gpu, SceneOptions::default())?;
    let foreign = other.add_light(Light::point([1.0, 5.0, 3.0])).map_err(text)?;
    let first = encode(gpu, &mut own, &[camera(DepthDirection::Reversed, None)]).map_err(text)?;
    let frame = encode(gpu, &mut own, &[camera(DepthDirection::Reversed, None)]).map_err(text)?;
    let later = own.add_light(Light::point([2.0, 5.0, 3.0])).map_err(text)?;
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("depth"),
        size: wgpu::Extent3d { width: 8, height: 8, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: format.depth_stencil,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
    let draw = |frame: &SceneFrame, pipelines: &ScenePipelines, view_number: usize, light| {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &view,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
                stencil_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0), store: wgpu::StoreOp::Store }),
            }),
            ..Default::default()
        });
        let drawn = frame.draw(&mut pass, pipelines, view_number, light);
        drop(pass);
        gpu.queue.submit([encoder.finish()]);
        drawn
    };
    same("all good", &[draw(&frame, &right, 0, light)], &[Ok(())])?;
    same("an earlier frame", &[draw(&first, &right, 0, light)], &[Err(SceneError::StaleFrame)])?;
    let no_view = Err(SceneError::NoSuchView { view: 1, views: 1 });
    same("a view too many", &[draw(&frame, &right, 1, light)], &[no_view])?;
    same("a later light", &[draw(&frame, &right, 0, later)], &[Err(SceneError::NotEncoded)])?;
    same("a foreign light", &[draw(&frame, &right, 0, foreign)], &[Err(SceneError::OtherScene { what: "light" })])?;
    let counting = ShadowDrawError::Counting { volumes: Counting::Auto, pipelines: Counting::ZPass };
    let found = draw(&frame, &made(Counting::ZPass)?, 0, light);
    same("another method", &[found], &[Err(SceneError::Draw(counting))])?;
    let mut mirrored = camera(DepthDirection::Reversed, None);
    mirrored.view_projection.iter_mut().for_each(|column| column[1] = -column[1]);
    let mirror_image = encode(gpu, &mut own, &[mirrored]).map_err(text)?;
    let (ccw, cw) = (wgpu::FrontFace::Ccw, wgpu::FrontFace::Cw);
    let mirrors = ShadowDrawError::FrontFace { volumes: cw, pipelines: ccw };
    same("a mirror image", &[draw(&mirror_image, &right, 0, light)], &[Err(SceneError::Draw(mirrors))])?;
    let frame = encode(gpu, &mut own, &[camera(DepthDirection::Reversed, None)]).map_err(text)?;
    let (volumes, pipelines) = (DepthDirection::Reversed, DepthDirection::Standard);
    let depth = ShadowDrawError::Depth { volumes, pipelines };
    same("another depth", &[draw(&frame, &standard, 0, light)], &[Err(SceneError::Draw(depth))])?;
    let batches = Err(SceneError::CountBatches { count_batches: 1 });
    same("in batches", &[draw(&frame, &in_batches, 0, light)], &[batches])?;
    match draw(&frame, &elsewhere, 0, light) {
        Err(SceneError::Device(_)) => {}
        other => return Err(format!("another device: {other:?}")),
    }
    // z-fail with a far plane needs pipelines that do not clip there.
    let (mut failing, caster) = scene(gpu, SceneOptions { counting: Counting::ZFail, ..SceneOptions::default() })?;
    let light = failing.add_light(Light::point([1.0, 5.0, 3.0])).map_err(text)?;
    failing.insert(caster).map_err(text)?;
    let frame = encode(gpu, &mut failing, &[camera(DepthDirection::Reversed, Some(50.0))]).map_err(text)?;
    let found = draw(&frame, &made(Counting::ZFail)?, 0, light);
    same("a far plane", &[found], &[Err(SceneError::Draw(ShadowDrawError::FarPlane))])?;
    let frame = encode(gpu, &mut failing, &[camera(DepthDirection::Reversed, None)]).map_err(text)?;
    same("no far plane", &[draw(&frame, &made(Counting::ZFail)?, 0, light)], &[Ok(())])
}
