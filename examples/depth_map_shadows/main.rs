//! Shadows of casters without a mesh: a ray-marched distance field and a crown of alpha-tested cards, from a depth map of
//! the lamp. Boxes and the trunk cast by their meshes, into the same stencil. Writes `depth_map_shadows.png`. Run
//! it with `cargo run --release --example depth_map_shadows`.

#[path = "../support/stage.rs"]
mod stage;
#[path = "../support/mod.rs"]
mod support;

use rimline::gpu::depth_map::{DepthMap, DepthMapOptions, DepthMapPipelines, DepthMapVolumes};
use rimline::gpu::{Caster, FrameInputs, Pipelines, Scene, SceneOptions, ShadowFormat, ShadowPipelines, StencilCounts};
use rimline::mesh::Weld;
use rimline::{Counting, DepthDirection, Light, Mesh, ShadowCamera, wgpu};
use stage::{COLOR, Camera, DEPTH_STENCIL, Lamp, Stage};

const CASTERS: &str = include_str!("casters.wgsl");
const CARDS: u32 = 220;
/// Texels of the lamp's map, each way.
const MAP: u32 = 1024;
/// The counts of meshes own the low bits of the stencil, and wrap at 128. Parity takes the bit above.
const COUNT_BITS: u32 = 7;

/// A box that leans by `lean` at its top.
fn push_box(mesh: &mut (Vec<[f32; 3]>, Vec<[u32; 3]>), [x, y, z]: [f32; 3], [w, h, d]: [f32; 3], lean: f32) {
    let first = mesh.0.len() as u32;
    for corner in 0..8 {
        let [right, up, front] = [corner & 1, corner >> 1 & 1, corner >> 2].map(|bit| bit as f32);
        mesh.0.push([x + w * (right - 0.5) + lean * up, y + h * up, z + d * (front - 0.5)]);
    }
    for [a, b, c, d] in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]] {
        let [a, b, c, d] = [a, b, c, d].map(|corner| first + corner);
        mesh.1.extend([[a, b, c], [a, c, d]]);
    }
}

fn seen_by(camera: &Camera) -> ShadowCamera {
    ShadowCamera { view_projection: camera.view_projection, origin: camera.eye, depth: DepthDirection::Reversed }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let format = ShadowFormat {
        depth_stencil: DEPTH_STENCIL,
        colors: vec![Some(COLOR)],
        count_bits: COUNT_BITS,
        ..ShadowFormat::default()
    };
    let canvas = support::Canvas::of_size([960, 640])?;
    let camera = Camera::new([0.5, 2.9, 6.9], [0.15, 1.05, -0.3], 34.0).wide(1.5);
    let lamp_position = [-3.2, 6.2, 3.4];
    let light = Light::point(lamp_position);
    let lamp = Lamp { light, color: [0.80, 0.75, 0.67] };
    let mut stage = Stage::new(&canvas, &camera, &[lamp], format.light_pass_depth_stencil());
    stage.add_extra(CASTERS, "everywhere", ["field_ambient", "field_lit"], 3);
    stage.add_extra(CASTERS, "card", ["leaf_ambient", "leaf_lit"], 6 * CARDS);

    // Casters with a mesh.
    let mut boxes = (Vec::new(), Vec::new());
    push_box(&mut boxes, [-1.5, 0.0, -0.2], [0.2, 1.7, 0.2], 0.05);
    for post in 0..5 {
        push_box(&mut boxes, [-0.6 + 0.75 * post as f32, 0.0, -1.7], [0.14, 1.5, 0.14], 0.1);
    }
    push_box(&mut boxes, [0.9, 1.1, -1.62], [3.6, 0.12, 0.06], 0.0);
    let mesh = Mesh::new(&boxes.0, &boxes.1, Weld::Position)?;
    let vertex_buffer = canvas.storage(bytemuck::cast_slice(&boxes.0));
    let bodies = [stage.body(&vertex_buffer, mesh.faces())];
    let shared = Pipelines::new(&canvas.device);
    let counting = ShadowPipelines::new(&shared, &format, Counting::Auto)?;
    let stencil = StencilCounts { count_bits: COUNT_BITS, ..Default::default() };
    let mut scene = Scene::new(&shared, &canvas.queue, SceneOptions { stencil, ..Default::default() })?;
    let at_lamp = scene.add_light(light)?;
    let mesh = scene.add_mesh(&mesh, &boxes.0)?;
    scene.insert(Caster::rigid(mesh, [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]))?;

    // Casters without a mesh: the lamp renders its own view of them.
    let parity = DepthMapPipelines::beside_meshes(&shared, &format, COUNT_BITS..COUNT_BITS + 1)?;
    let lamp_view = Camera::new(lamp_position, [0.1, 1.0, 0.1], 50.0);
    let map = canvas.target([MAP; 2], 1, DEPTH_STENCIL);
    let depths = map.create_view(&wgpu::TextureViewDescriptor {
        aspect: wgpu::TextureAspect::DepthOnly,
        ..wgpu::TextureViewDescriptor::default()
    });
    let mut volumes = DepthMapVolumes::new(&parity, [MAP; 2], DepthMapOptions::default())?;

    let mut encoder = canvas.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    stage.draw_extras_into(&mut encoder, &lamp_view, &map);
    let eye = seen_by(&camera);
    let extruded = scene.encode(&mut encoder, FrameInputs::new(&[eye.into()]))?;
    let seen = DepthMap::new(&depths, seen_by(&lamp_view));
    let rebuilt = volumes.encode(&mut encoder, &seen, &eye)?;
    // Two draws into one stencil: a pixel is dark where either counts it.
    stage.draw(&mut encoder, &bodies, |pass, _| {
        extruded.draw(pass, &counting, 0, at_lamp)?;
        rebuilt.draw(pass, &parity).map_err(Box::<dyn std::error::Error>::from)
    })?;
    canvas.save(encoder, "depth_map_shadows.png")
}
