//! 100 casters and 4 lights in one scene: walking figures, a model that the scene deforms, and boxes, which
//! share a mesh and have a matrix each. Writes `scene.png`. Run it with
//! `cargo run --release --example scene [SECONDS]`.

pub(crate) mod contents;
#[path = "../support/stage.rs"]
pub(crate) mod stage;
#[path = "../support/mod.rs"]
pub(crate) mod support;

use std::error::Error;

use rimline::gpu::{
    Caster, CasterHandle, DeformerOptions, FrameInputs, LightHandle, ModelHandle, Pipelines, Scene, SceneOptions,
    ShadowFormat, ShadowPipelines,
};
use rimline::{Counting, DepthDirection, ShadowCamera, wgpu};
use rimline_testkit::shapes;
use stage::{Body, COLOR, Camera, DEPTH_STENCIL, Stage};
use support::Canvas;

pub(crate) const SIZE: [u32; 2] = [1152, 768];

fn main() -> Result<(), Box<dyn Error>> {
    let seconds: f32 = std::env::args().nth(1).map_or(Ok(0.75), |text| text.parse())?;
    let canvas = Canvas::of_size(SIZE)?;
    let mut world = World::new(&canvas)?;
    let mut encoder = canvas.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    world.frame(&mut encoder, seconds)?;
    canvas.save(encoder, "scene.png")
}

/// All that stays from frame to frame.
pub(crate) struct World<'a> {
    /// A renderer, and what it draws: figures, boxes.
    stage: Stage<'a>,
    bodies: [Body; 2],
    /// Moves the figures, and throws the shadows.
    scene: Scene,
    walkers: ModelHandle,
    pipelines: ShadowPipelines,
    lights: Vec<LightHandle>,
    /// The boxes that move.
    floating: Vec<CasterHandle>,
}

impl<'a> World<'a> {
    pub(crate) fn new(canvas: &'a Canvas) -> Result<Self, Box<dyn Error>> {
        let format =
            ShadowFormat { depth_stencil: DEPTH_STENCIL, colors: vec![Some(COLOR)], ..ShadowFormat::default() };
        let stage = Stage::new(canvas, &contents::camera(), &contents::LAMPS, format.light_pass_depth_stencil());
        stage.set_ambient(contents::AMBIENT);
        let shared = Pipelines::new(&canvas.device);
        let pipelines = ShadowPipelines::new(&shared, &format, Counting::Auto)?;
        let mut scene = Scene::new(&shared, &canvas.queue, SceneOptions::default())?;
        let lights = contents::LAMPS.iter().map(|lamp| scene.add_light(lamp.light)).collect::<Result<_, _>>()?;

        // Figures: the scene deforms those that a frame needs, and writes them to one buffer, one after the other.
        let model = contents::walkers()?;
        let walkers = scene.insert_model(&model, &contents::pose(0.0)?, DeformerOptions::default())?;
        let walker = &model.geometries()[0];
        let dressed = contents::dressed(walker.positions().len() as u32);
        let walking = stage.bodies(scene.positions(walkers)?.buffer, walker.faces(), &dressed);

        // Boxes: one cube with many matrices.
        let cube = shapes::cube();
        let mesh = scene.add_mesh(&cube.mesh()?, &cube.positions)?;
        let placed = contents::boxes(0.0);
        let casters: Vec<_> = placed
            .iter()
            .map(|placed_box| scene.insert(Caster::rigid(mesh, placed_box.rows)))
            .collect::<Result<_, _>>()?;
        let boxes = stage.bodies(&canvas.storage(bytemuck::cast_slice(&cube.positions)), &cube.faces, &placed);

        let floating = casters[contents::FLOATING].to_vec();
        Ok(Self { stage, bodies: [walking, boxes], scene, walkers, pipelines, lights, floating })
    }

    /// Records a frame.
    pub(crate) fn frame(&mut self, encoder: &mut wgpu::CommandEncoder, seconds: f32) -> Result<(), Box<dyn Error>> {
        let Self { stage, bodies, scene, .. } = self;
        // Update of everything that moved.
        scene.set_pose(self.walkers, &contents::pose(seconds)?)?;
        let boxes = contents::boxes(seconds);
        stage.move_instances(&bodies[1], &boxes);
        for (&caster, placed_box) in self.floating.iter().zip(&boxes[contents::FLOATING]) {
            scene.set_transform(caster, placed_box.rows)?;
        }
        // The positions of the figures, and the shadow volumes of all casters and lights, as the camera sees them.
        let Camera { eye, view_projection } = *stage.camera(0);
        let camera = ShadowCamera { view_projection, origin: eye, depth: DepthDirection::Reversed };
        let shadows = scene.encode(encoder, FrameInputs::new(&[camera.into()]))?;
        // One depth pass, then a pass for each light.
        stage.depth_pass(encoder, 0, bodies);
        for (number, &light) in self.lights.iter().enumerate() {
            let mut pass = stage.light_pass(encoder, 0);
            shadows.draw(&mut pass, &self.pipelines, 0, light)?;
            stage.add_light(&mut pass, 0, bodies, number);
        }
        stage.develop(encoder);
        Ok(())
    }
}
