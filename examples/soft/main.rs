//! Soft shadows: a disc of light as 32 samples, which share one extraction. Neighbouring pixels take different patterns of
//! 32, of 16 that are more evenly spread together, so that shadows show no steps. Writes `soft.png`. Run it with
//! `cargo run --release --example soft`.
//!
//! To measure, `cargo run --release --example soft -- exact` shows every pixel the same 32 samples: a point's light is then
//! the share of those that reach it, and shadows have 32 steps.

#[path = "../support/stage.rs"]
pub(crate) mod stage;
#[path = "../support/mod.rs"]
pub(crate) mod support;

use rimline::gpu::{Caster, FrameInputs, PositionBuffer, Scene, SceneOptions, ShadowFormat, ShadowPipelines};
use rimline::{AreaLight, AreaShape, Counting, DepthDirection, Light, Mesh, ShadowCamera, mesh::Weld, wgpu};
use rimline_testkit::shapes;
use stage::{COLOR, Camera, DEPTH_STENCIL, Lamp, PARTS, Stage};
use support::Canvas;

/// One batch of lights: the extraction decides them together.
const SAMPLES: usize = 32;

pub(crate) const LAMP: AreaLight = AreaLight {
    light: Light::point([-3.2, 5.6, 2.2]),
    shape: AreaShape::Disc { radius: 0.6 },
    normal: [3.2, -4.6, -2.2],
};

pub(crate) fn camera() -> Camera {
    Camera::new([3.0, 4.2, 7.0], [0.85, 1.0, 0.0], 36.0).wide(4.0 / 3.0)
}

/// Above the floor.
pub(crate) fn placed(shape: &shapes::Shape) -> Vec<[f32; 3]> {
    shape.positions.iter().map(|&[x, y, z]| [x, y + 1.4, z]).collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let parts = if std::env::args().nth(1).as_deref() == Some("exact") { 1 } else { PARTS };
    let canvas = Canvas::of_size([960, 720])?;
    let encoder = picture(&canvas, parts)?;
    canvas.save(encoder, "soft.png")
}

/// Records the picture with so many patterns of samples.
pub(crate) fn picture(canvas: &Canvas, parts: usize) -> Result<wgpu::CommandEncoder, Box<dyn std::error::Error>> {
    let device = &canvas.device;
    let (camera, lamp) = (camera(), LAMP);
    let patterns: Vec<Vec<Light>> = (0..parts).map(|part| lamp.pattern_samples(SAMPLES, part, parts)).collect();
    let share = |&light: &Light| Lamp { light, color: [0.95, 0.90, 0.82].map(|c| c / SAMPLES as f32) };
    let lamps: Vec<Vec<Lamp>> = patterns.iter().map(|lights| lights.iter().map(share).collect()).collect();
    let format = ShadowFormat { depth_stencil: DEPTH_STENCIL, colors: vec![Some(COLOR)], ..ShadowFormat::default() };
    let stage = Stage::in_parts(canvas, &camera, &lamps, format.light_pass_depth_stencil());

    let shape = shapes::blob(96, 0.6, 7);
    let vertices = placed(&shape);
    let vertex_buffer = canvas.storage(bytemuck::cast_slice(&vertices));
    let bodies = [stage.body(&vertex_buffer, &shape.faces)];

    let pipelines = ShadowPipelines::new(device, &format, Counting::Auto)?;
    let mesh = Mesh::new(&shape.positions, &shape.faces, Weld::Position)?;
    let mut scene = Scene::new(device, &canvas.queue, SceneOptions { max_lights: SAMPLES, ..SceneOptions::default() })?;
    let mesh = scene.add_mesh(&mesh, &vertices)?;
    scene.insert(Caster::in_buffer(mesh, PositionBuffer { buffer: &vertex_buffer, offset: 0, stride: 12 }))?;
    let mut handles = Vec::new();

    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    for (part, lights) in patterns.iter().enumerate() {
        let Camera { eye, view_projection } = *stage.camera(part);
        let view = ShadowCamera { view_projection, origin: eye, depth: DepthDirection::Reversed };
        for (number, &light) in lights.iter().enumerate() {
            match handles.get(number) {
                Some(&handle) => scene.set_light(handle, light)?,
                None => handles.push(scene.add_light(light)?),
            }
        }
        let shadows = scene.encode(&mut encoder, FrameInputs::new(&[view.into()]))?;
        stage
            .draw_part(&mut encoder, part, &bodies, |pass, light| shadows.draw(pass, &pipelines, 0, handles[light]))?;
    }
    stage.develop(&mut encoder);
    Ok(encoder)
}
