//! Viewers on the shared device.

use glam::{Vec2, Vec3};
use rimline_testkit::device::Gpu as Device;
pub(crate) use rimline_testkit::on_gpu::text as say;
use rimline_view::{BodyError, Button, Event, Gpu, Modifiers, Picture, Renderer, Viewer, scenes};

pub(crate) type Outcome = Result<(), String>;

/// A condition that must be true.
pub(crate) fn hold(is_true: bool, what: impl Into<String>) -> Outcome {
    if is_true { Ok(()) } else { Err(what.into()) }
}

/// The shared device. Its pipelines are compiled once.
pub(crate) fn gpu() -> Result<Gpu, String> {
    let shared = Device::shared()?;
    let make = || Ok(Gpu::of(shared.device.clone(), shared.queue.clone(), shared.name.clone(), true));
    Ok((*shared.kept("viewer", make)?).clone())
}

/// A target that stands for a window of this size.
pub(crate) fn window(gpu: &Gpu, [width, height]: [u32; 2]) -> wgpu::TextureView {
    let target = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("window"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8Unorm,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    target.create_view(&wgpu::TextureViewDescriptor::default())
}

/// A tetrahedron.
pub(crate) fn block() -> Result<rimline::Model, String> {
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let geometry = rimline::Geometry::new(positions, faces, rimline::GeometryOptions::default()).map_err(say)?;
    rimline::Model::new(vec![geometry], vec![rimline::Instance::new(0, None)]).map_err(say)
}

/// Its pose.
pub(crate) fn rest() -> Result<rimline::Pose, BodyError> {
    Ok(rimline::Pose::new(vec![rimline::InstancePose::new([glam::Affine3A::IDENTITY], Vec::new())?]))
}

/// A viewer of a scene, and its renderer.
pub(crate) fn viewer(scene: scenes::Make, size: [u32; 2]) -> Result<(Viewer, Renderer), String> {
    let mut viewer = Viewer::new(scene().map_err(say)?);
    viewer.handle(Event::Resized(size));
    viewer.handle(Event::Acted(rimline_view::Action::ResetCamera));
    viewer.clock.is_running = false;
    Ok((viewer, Renderer::new(gpu()?).map_err(say)?))
}

pub(crate) fn picture(viewer: &Viewer, renderer: &mut Renderer) -> Result<Picture, String> {
    renderer.draw(viewer).map_err(say)?;
    let picture = renderer.read().ok_or("no picture was drawn")?;
    finish(renderer, picture)
}

/// Waits for a picture of the device.
pub(crate) fn finish(
    renderer: &Renderer,
    picture: impl Future<Output = Result<Picture, rimline_view::RenderError>>,
) -> Result<Picture, String> {
    renderer.gpu().device.poll(wgpu::PollType::wait_indefinitely()).map_err(say)?;
    pollster::block_on(picture).map_err(say)
}

/// The pixel of a light's handle.
pub(crate) fn handle(viewer: &Viewer, lamp: usize) -> Result<Vec2, String> {
    let at = viewer.lamps[lamp].handle(&viewer.bounds());
    viewer.camera().project(at).ok_or_else(|| "the handle is behind the eye".into())
}

/// Drags from one pixel to another.
pub(crate) fn drag(viewer: &mut Viewer, from: Vec2, to: Vec2, modifiers: Modifiers) {
    viewer.handle(Event::Moved(from.into()));
    viewer.handle(Event::Pressed(Button::Primary, modifiers));
    for step in 1..=4 {
        viewer.handle(Event::Moved(from.lerp(to, step as f32 / 4.0).into()));
    }
    viewer.handle(Event::Released);
}

/// The point of the ground that a pixel's centre shows.
pub(crate) fn on_ground(viewer: &Viewer, [x, y]: [u32; 2]) -> Option<Vec3> {
    let camera = viewer.camera();
    let ray = camera.ray(Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
    let along = (viewer.ground() - camera.view.eye.y) / ray.y;
    (along > 0.0 && along.is_finite()).then(|| camera.view.eye + along * ray)
}
