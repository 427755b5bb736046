//! Polygons as they are: a quadrilateral that the light sees as a bow tie, an octagon with a hole that is not planar, a
//! cube of which a side is twisted. Each is one face, and so are its shadows. Writes `polygons.png`. Run it with `cargo
//! run --release --example polygons`.

#[path = "../support/stage.rs"]
mod stage;
#[path = "../support/mod.rs"]
mod support;

use rimline::gpu::{Caster, FrameInputs, PositionBuffer, Scene, SceneOptions, ShadowFormat, ShadowPipelines};
use rimline::mesh::{PolygonLoops, Weld};
use rimline::{Counting, DepthDirection, Light, Mesh, ShadowCamera, wgpu};
use stage::{COLOR, Camera, DEPTH_STENCIL, Lamp, Stage};

/// Positions, and loops of corners for each polygon.
#[derive(Default)]
struct Polygons {
    positions: Vec<[f32; 3]>,
    loops: Vec<u32>,
    sizes: Vec<u32>,
    corners: Vec<u32>,
}

impl Polygons {
    fn push(&mut self, loops: &[Vec<[f32; 3]>]) {
        self.loops.push(loops.len() as u32);
        for points in loops {
            self.sizes.push(points.len() as u32);
            self.corners.extend((0..points.len()).map(|at| (self.positions.len() + at) as u32));
            self.positions.extend(points);
        }
    }
}

/// A ring of points around a centre, which waves up and down.
fn ring([x, y, z]: [f32; 3], radius: f32, wave: f32, turns: f32) -> Vec<[f32; 3]> {
    let corner = |at: usize| {
        let angle = (at as f32 + 0.5) / 8.0 * turns * std::f32::consts::TAU;
        [x + radius * angle.cos(), y + if at.is_multiple_of(2) { wave } else { -wave }, z - radius * angle.sin()]
    };
    (0..8).map(corner).collect()
}

fn polygons() -> Polygons {
    let mut scene = Polygons::default();
    // Opposite sides are turned against each other by more than a right angle, so light from above sees them cross.
    scene.push(&[vec![[-2.6, 1.5, 0.8], [-0.9, 0.7, 0.9], [-2.5, 0.9, -0.8], [-0.9, 1.7, -0.7]]]);
    // The hole runs the other way round.
    scene.push(&[ring([1.3, 1.5, -1.2], 1.0, 0.12, 1.0), ring([1.3, 1.5, -1.2], 0.45, 0.05, -1.0)]);
    // The corners of the upper side are swapped along one edge: that side and two of its neighbours are twisted.
    let at = |x: f32, y: f32, z: f32| [0.6 + x, 0.1 + y, 1.3 + z];
    let low = [at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0), at(1.0, 0.0, -1.0), at(0.0, 0.0, -1.0)];
    let high = [at(0.0, 1.0, 0.0), at(1.0, 1.0, 0.0), at(0.15, 1.25, -1.0), at(0.85, 0.8, -1.0)];
    scene.push(&[vec![low[3], low[2], low[1], low[0]]]);
    scene.push(&[high.to_vec()]);
    for side in 0..4 {
        let next = (side + 1) % 4;
        scene.push(&[vec![low[side], low[next], high[next], high[side]]]);
    }
    scene
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let format = ShadowFormat { depth_stencil: DEPTH_STENCIL, colors: vec![Some(COLOR)], ..ShadowFormat::default() };
    let canvas = support::Canvas::of_size([960, 640])?;
    let camera = Camera::new([0.4, 4.6, 6.2], [0.0, 0.45, 0.0], 36.0).wide(1.5);
    let sun = Light::directional([-0.35, 1.0, 0.25]);
    let lamp = Lamp { light: sun, color: [0.75, 0.71, 0.65] };
    let stage = Stage::new(&canvas, &camera, &[lamp], format.light_pass_depth_stencil());

    // Equal positions are one vertex, so the cube's sides have common edges.
    let Polygons { positions, loops, sizes, corners } = polygons();
    let given = PolygonLoops { polygon_loops: &loops, loop_sizes: &sizes, loop_corners: &corners };
    let mesh = Mesh::from_polygons_by_loop(&positions, given, Weld::Position)?;
    let vertex_buffer = canvas.storage(bytemuck::cast_slice(&positions));
    // These triangles are the surface of the polygons.
    let bodies = [stage.body(&vertex_buffer, mesh.faces())];

    let pipelines = ShadowPipelines::new(&canvas.device, &format, Counting::Auto)?;
    let mut scene = Scene::new(&canvas.device, &canvas.queue, SceneOptions::default())?;
    let mesh = scene.add_mesh(&mesh, &positions)?;
    scene.insert(Caster::in_buffer(mesh, PositionBuffer { buffer: &vertex_buffer, offset: 0, stride: 12 }))?;
    let light = scene.add_light(sun)?;
    let mut encoder = canvas.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let view =
        ShadowCamera { view_projection: camera.view_projection, origin: camera.eye, depth: DepthDirection::Reversed };
    let shadows = scene.encode(&mut encoder, FrameInputs::new(&[view.into()]))?;
    stage.draw(&mut encoder, &bodies, |pass, _| shadows.draw(pass, &pipelines, 0, light))?;
    canvas.save(encoder, "polygons.png")
}
