//! Shadow volumes in a renderer that has its own passes: they draw into its depth-stencil attachment, with its camera,
//! between its depth pass and its light passes. Writes `shadows_drop_in.png`. Run it with
//! `cargo run --release --example shadows_drop_in`.

#[path = "../support/stage.rs"]
mod stage;
#[path = "../support/mod.rs"]
mod support;

use rimline::gpu::{
    Extractor, ExtractorOptions, PositionBuffer, ShadowFormat, ShadowOptions, ShadowPipelines, ShadowVolumes,
};
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

    // Once: pipelines. Once a mesh: topology, extraction, volumes.
    let pipelines = ShadowPipelines::new(device, &format, Counting::Auto)?;
    let mesh = Mesh::new(&shape.positions, &shape.faces, Weld::Position)?;
    let mut extractor = Extractor::new(device, &mesh, ExtractorOptions::default())?;
    let mut volumes = ShadowVolumes::new(&pipelines, &extractor, ShadowOptions::default())?;

    // Every frame: extract and choose, then draw the volumes where the stencil is wanted. Nothing is read back.
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let positions = PositionBuffer { buffer: &vertex_buffer, offset: 0, stride: 12 };
    let view =
        ShadowCamera { view_projection: camera.view_projection, origin: camera.eye, depth: DepthDirection::Reversed };
    let extraction = extractor.encode(&mut encoder, positions, &[sun])?;
    let shadows = volumes.encode(&mut encoder, &extraction, &view, None)?;
    stage.draw(&mut encoder, &bodies, |pass, light| shadows.draw(pass, &pipelines, light))?;
    canvas.save(encoder, "shadows_drop_in.png")
}
