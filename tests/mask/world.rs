//! Casters in a room, a camera and lights, at random; and a scene of them.

use glam::DVec3;
use rimline::gpu::{Caster, FrameInputs, LightHandle, Scene, SceneFrame, SceneOptions};
use rimline::{Cone, Light, Mesh, ShadowCamera, mesh::Weld};
use rimline_testkit::IDENTITY;
use rimline_testkit::cases::topologies;
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::{text, views};
use rimline_testkit::random::Random;
use rimline_testkit::scenes::{Pose, direction};
use rimline_testkit::shapes::{self, Shape};

/// The size of pictures, if nothing else is said.
pub(crate) const SIZE: [u32; 2] = [192, 128];

/// All in world space.
pub(crate) struct World {
    pub(crate) casters: Vec<Shape>,
    /// It does not cast.
    pub(crate) room: Shape,
    pub(crate) camera: ShadowCamera,
    pub(crate) lights: Vec<Light>,
}

fn moved(positions: &[[f32; 3]], by: f32, to: DVec3) -> Vec<[f32; 3]> {
    let transform = |p: &[f32; 3]| (DVec3::from(p.map(f64::from)) * f64::from(by) + to).as_vec3().to_array();
    positions.iter().map(transform).collect()
}

impl World {
    /// `projection` is one of [`PROJECTIONS`](rimline_testkit::scenes::PROJECTIONS), whose odd ones have standard depth.
    pub(crate) fn new(seed: u64, projection: usize, lights: usize) -> Self {
        let mut cases = topologies();
        let random = &mut Random::new(seed);
        let mut casters = vec![shapes::torus(24, 16, 0.8, 0.3)];
        let (_, positions, mesh) = cases.swap_remove(random.below(cases.len()));
        let positions = moved(&positions, 0.6, direction(random));
        casters.push(Shape { positions, faces: mesh.faces().to_vec() });
        let mut room = shapes::cube();
        room.faces.iter_mut().for_each(|face| face.swap(1, 2));
        room.positions = moved(&room.positions, 4.0, DVec3::ZERO);
        let away = direction(random);
        let forward = (-away + 0.2 * direction(random)).normalize();
        let right = forward.cross(direction(random)).normalize();
        let eye = f64::from(random.between(0.8, 3.0)) * away;
        let pose = Pose { eye, forward, right, up: right.cross(forward), near: 0.05, scale: 2.0 };
        let light = |number: usize| match number % 3 {
            2 => Light::directional(random.direction()),
            _ => Light::point(random.direction().map(|c| 2.5 * c)),
        };
        let lights = (0..lights).map(light).collect();
        Self { casters, room, camera: pose.camera(projection, seed.is_multiple_of(2)), lights }
    }

    /// The same with lights that affect a part of it, by a range, a cone, or both.
    pub(crate) fn with_ranges(mut self, seed: u64) -> Self {
        let random = &mut Random::new(seed);
        for (number, light) in self.lights.iter_mut().enumerate().filter(|(_, light)| light.w != 0.0) {
            if number % 2 == 0 || random.below(2) == 0 {
                light.range = random.between(0.5, 3.0);
            }
            if number % 2 == 1 {
                let axis = light.xyz.map(|c| -c);
                light.cone = Some(Cone::new(axis, random.between(0.1, 2.0)));
            }
        }
        self
    }

    /// The corners of all visible faces, three a face.
    pub(crate) fn corners(&self) -> Vec<[f32; 3]> {
        let bodies = self.casters.iter().chain([&self.room]);
        bodies.flat_map(|body| body.faces.iter().flatten().map(|&v| body.positions[v as usize])).collect()
    }

    /// The scene, encoded for the camera.
    pub(crate) fn encode(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        options: SceneOptions,
    ) -> Result<Encoded, String> {
        let options = SceneOptions { max_lights: self.lights.len().max(1), ..options };
        let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
        for Shape { positions, faces } in &self.casters {
            let mesh = Mesh::new(positions, faces, Weld::Position).map_err(text)?;
            let mesh = scene.add_mesh(&mesh, positions).map_err(text)?;
            scene.insert(Caster::rigid(mesh, IDENTITY)).map_err(text)?;
        }
        let lights = self.lights.iter().map(|light| scene.add_light(*light).map_err(text));
        let lights = lights.collect::<Result<Vec<_>, _>>()?;
        let frame = encode(&mut scene, encoder, &[self.camera])?;
        Ok(Encoded { scene, frame, lights })
    }
}

/// A scene with its last frame.
pub(crate) struct Encoded {
    pub(crate) scene: Scene,
    pub(crate) frame: SceneFrame,
    pub(crate) lights: Vec<LightHandle>,
}

/// Encodes a scene for some views.
pub(crate) fn encode(
    scene: &mut Scene,
    encoder: &mut wgpu::CommandEncoder,
    cameras: &[ShadowCamera],
) -> Result<SceneFrame, String> {
    scene.encode(encoder, FrameInputs::new(&views(cameras))).map_err(text)
}
