//! Three spheres displaced by noise in a shader, lit by three coloured lights, after the last figure of Brabec and Seidel
//! (2003): a shader of the caller moves the vertices on the GPU, and silhouettes and shadows follow. Writes
//! `three_spheres.png`. Run it with `cargo run --release --example three_spheres [SECONDS]`.

#[path = "../support/stage.rs"]
mod stage;
#[path = "../support/mod.rs"]
mod support;

use rimline::gpu::{
    Caster, Deformer, DeformerOptions, FrameInputs, PoseInputs, Scene, SceneOptions, ShadowFormat, ShadowPipelines,
};
use rimline::{
    Counting, DepthDirection, Displacement, Geometry, GeometryOptions, Instance, InstancePose, Light, Model, Pose,
    ShadowCamera, wgpu,
};
use rimline_testkit::shapes;
use stage::{COLOR, Camera, DEPTH_STENCIL, Lamp, Stage};

/// Where the spheres are; `noise.wgsl` knows it, too.
const CENTRES: [[f32; 3]; 3] = [[-2.0, 1.25, 0.6], [0.0, 1.25, -1.7], [2.0, 1.25, 0.6]];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let seconds: f32 = std::env::args().nth(1).map_or(Ok(0.0), |text| text.parse())?;
    let canvas = support::Canvas::new(704)?;
    let device = &canvas.device;
    let camera = Camera::new([0.0, 6.0, 11.5], [0.0, 0.75, -0.2], 33.0);
    let lamps = [
        Lamp { light: Light::point([-4.5, 6.0, 3.5]), color: [0.62, 0.10, 0.05] },
        Lamp { light: Light::point([4.5, 6.0, 3.5]), color: [0.06, 0.46, 0.10] },
        Lamp { light: Light::point([0.0, 7.0, 5.5]), color: [0.07, 0.14, 0.60] },
    ];
    let lights = lamps.map(|lamp| lamp.light);
    let format = ShadowFormat { depth_stencil: DEPTH_STENCIL, colors: vec![Some(COLOR)], ..ShadowFormat::default() };
    let stage = Stage::new(&canvas, &camera, &lamps, format.light_pass_depth_stencil());

    // One sphere, three times; the deformer places and displaces it.
    let sphere = shapes::sphere(64);
    let sphere = Geometry::new(sphere.positions, sphere.faces, GeometryOptions::default())?;
    let model = Model::new(vec![sphere], vec![Instance::new(0, None); 3])?;
    let placed = |[x, y, z]: [f32; 3]| {
        InstancePose::new(vec![[[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]]], Vec::new())
    };
    let pose = Pose::new(CENTRES.into_iter().map(placed).collect::<Result<_, _>>()?);
    let displacement = Displacement::new(include_str!("noise.wgsl"))?;
    let options = DeformerOptions { displacement: Some(&displacement), ..DeformerOptions::default() };
    let deformer = Deformer::new(device, &model, options)?;
    let mesh = model.mesh(&pose)?;
    let bodies = [stage.body(deformer.positions().buffer, mesh.faces())];

    let pipelines = ShadowPipelines::new(device, &format, Counting::Auto)?;
    let mut scene = Scene::new(device, &canvas.queue, SceneOptions::default())?;
    // Only casters without a buffer read the positions of the mesh.
    let mesh = scene.add_mesh(&mesh, &vec![[0.0; 3]; mesh.vertex_count() as usize])?;
    scene.insert(Caster::in_buffer(mesh, deformer.positions()))?;
    let handles = lights.iter().map(|&light| scene.add_light(light)).collect::<Result<Vec<_>, _>>()?;

    // Every frame.
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let view =
        ShadowCamera { view_projection: camera.view_projection, origin: camera.eye, depth: DepthDirection::Reversed };
    deformer.encode(&mut encoder, PoseInputs { time_s: seconds, ..PoseInputs::new(&pose) })?;
    let shadows = scene.encode(&mut encoder, FrameInputs::new(&[view.into()]))?;
    stage.draw(&mut encoder, &bodies, |pass, light| shadows.draw(pass, &pipelines, 0, handles[light]))?;
    canvas.save(encoder, "three_spheres.png")
}
