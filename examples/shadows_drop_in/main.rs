//! Shadow volumes in a renderer that has its own passes: they draw into its depth-stencil attachment, with its camera,
//! between its depth pass and its light passes. Writes `shadows_drop_in.png`. Run it with
//! `cargo run --release --example shadows_drop_in`.

#[path = "../support/stage.rs"]
mod stage;
#[path = "../support/mod.rs"]
mod support;

use rimline::gpu::{Caster, FrameInputs, PositionBuffer, Scene, SceneOptions, ShadowFormat, ShadowPipelines};
use rimline::{Counting, DepthDirection, Light, Mesh, ShadowCamera, mesh::Weld, wgpu};
use rimline_testkit::shapes;
use stage::{COLOR, Camera, DEPTH_STENCIL, Lamp, Stage};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Once: what your attachments are.
    let format = ShadowFormat { depth_stencil: DEPTH_STENCIL, colors: vec![Some(COLOR)], ..ShadowFormat::default() };
    // Yours: a device, a renderer whose light passes draw where the stencil is still 0, and vertex positions in a buffer.
    let canvas = support::Canvas::new(640)?;
    let device = &canvas.device;
    let camera = Camera::new([2.4, 3.6, 6.0], [0.75, 1.05, 0.0], 35.0);
    let sun = Light::directional([-0.8, 1.2, 0.5]);
    let lamp = Lamp { light: sun, color: [0.95, 0.90, 0.82] };
    let stage = Stage::new(&canvas, &camera, &[lamp], format.light_pass_depth_stencil());
    let shape = shapes::torus(192, 96, 1.0, 0.4);
    let vertices: Vec<_> = shape.positions.iter().map(|&[x, y, z]| [x, 1.4 - z, y]).collect();
    let vertex_buffer = canvas.storage(bytemuck::cast_slice(&vertices));
    let bodies = [stage.body(&vertex_buffer, &shape.faces)];

    // Once: pipelines, and a scene with a mesh, which casts from your vertices, and a light.
    let pipelines = ShadowPipelines::new(device, &format, Counting::Auto)?;
    let mesh = Mesh::new(&shape.positions, &shape.faces, Weld::Position)?;
    let mut scene = Scene::new(device, &canvas.queue, SceneOptions::default())?;
    let mesh = scene.add_mesh(&mesh, &vertices)?;
    scene.insert(Caster::in_buffer(mesh, PositionBuffer { buffer: &vertex_buffer, offset: 0, stride: 12 }))?;
    let light = scene.add_light(sun)?;

    // Every frame: extract and choose, then draw the volumes where the stencil is wanted. Nothing is read back.
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let view =
        ShadowCamera { view_projection: camera.view_projection, origin: camera.eye, depth: DepthDirection::Reversed };
    let shadows = scene.encode(&mut encoder, FrameInputs::new(&[view.into()]))?;
    stage.draw(&mut encoder, &bodies, |pass, _| shadows.draw(pass, &pipelines, 0, light))?;
    canvas.save(encoder, "shadows_drop_in.png")
}
