//! Walking figures, and a scene whose caller deforms them all.

use glam::{Affine3A, DVec4, Quat, Vec3};
use rimline::gpu::{
    Caster, CasterHandle, Deformer, DeformerOptions, FrameInputs, LightHandle, PoseInputs, Scene, SceneFrame,
    SceneOptions, View,
};
use rimline::model::Box3;
use rimline::{Cone, Instance, Light, Mesh, Model, ModelBounds, Pose, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::models::bending_tube;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;

use crate::histories::looking;

/// Half the width of the ground.
const GROUND: f32 = 30.0;

/// The position of a figure, its bend, its size, and whether it is mirrored.
#[derive(Clone, Copy)]
pub(crate) struct Walker {
    pub(crate) at: Vec3,
    time: f32,
    pub(crate) size: f32,
    pub(crate) is_mirrored: bool,
}

/// The constant parts of a crowd.
pub(crate) struct Crowd {
    pub(crate) model: Model,
    bounds: ModelBounds,
    bend: Box<dyn Fn(f32) -> Pose>,
}

impl Crowd {
    pub(crate) fn new(walkers: usize) -> Result<Self, String> {
        let (tube, bend) = bending_tube();
        let model = Model::new(tube.geometries().to_vec(), vec![Instance::new(0, None); walkers]).map_err(text)?;
        Ok(Self { bounds: ModelBounds::new(&model), model, bend: Box::new(bend) })
    }

    pub(crate) fn walkers(&self, random: &mut Random) -> Vec<Walker> {
        let walker = |_| Walker { at: position(random), time: random.between(0.0, 9.0), size: 1.0, is_mirrored: false };
        (0..self.model.instances().len()).map(walker).collect()
    }

    pub(crate) fn pose(&self, walkers: &[Walker]) -> Result<Pose, String> {
        let pose = |walker: &Walker| {
            let bent = (self.bend)(walker.time);
            let mirror = if walker.is_mirrored { -walker.size } else { walker.size };
            let scale = glam::vec3(mirror, walker.size, walker.size);
            let at = Affine3A::from_scale_rotation_translation(scale, Quat::IDENTITY, walker.at);
            Ok::<_, String>(bent.placed(at).map_err(text)?.instances()[0].clone())
        };
        Ok(Pose::new(walkers.iter().map(pose).collect::<Result<_, _>>()?))
    }

    pub(crate) fn boxes(&self, pose: &Pose) -> Result<Vec<Option<Box3>>, String> {
        self.bounds.boxes(pose, 0.0).map_err(text)
    }
}

pub(crate) fn position(random: &mut Random) -> Vec3 {
    Vec3::new(random.between(-GROUND, GROUND), random.between(0.5, 2.0), random.between(-GROUND, GROUND))
}

/// Makes some figures walk a bit, far, or not at all, and some become their mirror images.
pub(crate) fn walk(walkers: &mut [Walker], random: &mut Random) {
    for walker in walkers {
        walker.is_mirrored ^= random.below(6) == 0;
        match random.below(4) {
            0 => {}
            1 => walker.at = position(random),
            _ => {
                walker.at += Vec3::from(random.direction()) * Vec3::new(1.0, 0.0, 1.0);
                walker.time += 0.3;
            }
        }
    }
}

pub(crate) fn lights(random: &mut Random) -> Vec<Light> {
    let light = |number: usize| {
        let at = position(random) + 3.0 * Vec3::Y;
        match number {
            0 => Light::directional([0.4, 1.0, 0.1]),
            1 => Light::homogeneous([2.0 * at.x, 2.0 * at.y, 2.0 * at.z, 2.0]).with_range(8.0),
            2 => Light::point(at.to_array()),
            3 => {
                let axis = [random.between(-1.0, 1.0), -1.0, random.between(-1.0, 1.0)];
                Light::point(at.to_array()).with_range(20.0).with_cone(Cone { axis, cosine: random.between(-0.2, 0.9) })
            }
            _ => Light::point(at.to_array()).with_range(random.between(3.0, 9.0)),
        }
    };
    (0..6).map(light).collect()
}

/// In the crowd, looking about level.
pub(crate) fn camera(random: &mut Random) -> ShadowCamera {
    let origin = position(random);
    let forward = (Vec3::from(random.direction()) * Vec3::new(1.0, 0.2, 1.0)).normalize();
    looking(origin, forward, forward.cross(Vec3::Y).normalize())
}

/// Whether the camera sees a homogeneous point.
pub(crate) fn sees(camera: &ShadowCamera, point: DVec4) -> bool {
    let [x, y, z] = camera.origin.map(f64::from);
    let from = point - DVec4::new(x, y, z, 0.0) * point.w;
    let columns = camera.view_projection.map(|column| DVec4::from(column.map(f64::from)));
    let clip = columns[0] * from.x + columns[1] * from.y + columns[2] * from.z + columns[3] * from.w;
    clip.w > 0.0 && clip.x.abs() <= clip.w && clip.y.abs() <= clip.w && clip.z <= clip.w
}

/// A scene of the crowd whose caller deforms all figures.
pub(crate) struct Apart {
    pub(crate) scene: Scene,
    deformer: Deformer,
    pub(crate) casters: Vec<CasterHandle>,
    pub(crate) lights: Vec<LightHandle>,
}

impl Apart {
    /// `options` are those of the deformer.
    pub(crate) fn new(
        gpu: &Gpu,
        crowd: &Crowd,
        pose: &Pose,
        lights: &[Light],
        (options, deforming): (SceneOptions, DeformerOptions<'_>),
    ) -> Result<Self, String> {
        let deformer = Deformer::new(&gpu.pipelines, &crowd.model, deforming).map_err(text)?;
        let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
        let geometry = &crowd.model.geometries()[0];
        let mut mesh = |turned: bool| {
            let turn = |&[a, b, c]: &[u32; 3]| if turned { [a, c, b] } else { [a, b, c] };
            let faces = geometry.faces().iter().map(turn).collect();
            let mesh = Mesh::from_faces(geometry.positions().len(), faces).map_err(text)?;
            scene.add_mesh(&mesh, geometry.positions()).map_err(text)
        };
        let meshes = [mesh(false)?, mesh(true)?];
        let lights = lights.iter().map(|light| scene.add_light(*light).map_err(text)).collect::<Result<_, _>>()?;
        let mut casters = Vec::new();
        for ((instance, pose), bounds) in pose.instances().iter().enumerate().zip(crowd.boxes(pose)?) {
            let positions = deformer.instance_positions(instance).ok_or("no instance")?;
            let mesh = meshes[usize::from(pose.faces_turned())];
            let caster = scene.insert(Caster::in_buffer(mesh, positions)).map_err(text)?;
            scene.set_bounds(caster, bounds).map_err(text)?;
            casters.push(caster);
        }
        Ok(Self { scene, deformer, casters, lights })
    }

    pub(crate) fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        (pose, time_s): (&Pose, f32),
        views: &[View<'_>],
    ) -> Result<SceneFrame, String> {
        self.deformer.encode(encoder, PoseInputs { time_s, ..PoseInputs::new(pose) }).map_err(text)?;
        self.scene.encode(encoder, FrameInputs::new(views)).map_err(text)
    }

    pub(crate) fn positions(&self, gpu: &Gpu) -> Result<Vec<[u32; 3]>, String> {
        gpu.read(self.deformer.positions().buffer, usize::MAX)
    }
}
