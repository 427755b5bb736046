//! Figures that walk about, in a scene that deforms them as far as a frame needs them, and in one that deforms all.

use glam::{DVec4, Vec3};
use rimline::gpu::{
    Caster, CasterHandle, Deformer, DeformerOptions, FrameInputs, LightHandle, Scene, SceneFrame, SceneNeeds,
    SceneOptions,
};
use rimline::model::Box3;
use rimline::{Cone, DepthDirection, Instance, InstancePose, Light, Mesh, Model, ModelBounds, Pose, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::models::bending_tube;
use rimline_testkit::on_gpu::{text, views};
use rimline_testkit::random::Random;

/// Half the width of the ground.
const GROUND: f32 = 30.0;

/// Where a figure is, how it bends, and how often that changed.
#[derive(Clone, Copy)]
pub(crate) struct Figure {
    pub(crate) at: Vec3,
    time: f32,
    pub(crate) version: u64,
}

/// The constant parts of a crowd.
pub(crate) struct Crowd {
    pub(crate) model: Model,
    bounds: ModelBounds,
    bend: Box<dyn Fn(f32) -> Pose>,
}

impl Crowd {
    pub(crate) fn new(figures: usize) -> Result<Self, String> {
        let (tube, bend) = bending_tube();
        let model = Model::new(tube.geometries().to_vec(), vec![Instance::new(0, None); figures]).map_err(text)?;
        Ok(Self { bounds: ModelBounds::new(&model), model, bend: Box::new(bend) })
    }

    pub(crate) fn figures(&self, random: &mut Random) -> Vec<Figure> {
        let figure = |_| Figure { at: place(random), time: random.between(0.0, 9.0), version: 0 };
        (0..self.model.instances().len()).map(figure).collect()
    }

    pub(crate) fn pose(&self, figures: &[Figure]) -> Result<Pose, String> {
        let pose = |figure: &Figure| {
            let bent = (self.bend)(figure.time);
            let mut palette = bent.instances()[0].palette().to_vec();
            for rows in &mut palette {
                rows.iter_mut().zip(figure.at.to_array()).for_each(|(row, c)| row[3] += c);
            }
            InstancePose::new(palette, Vec::new()).map_err(text)
        };
        Ok(Pose::new(figures.iter().map(pose).collect::<Result<_, _>>()?))
    }

    pub(crate) fn boxes(&self, pose: &Pose) -> Result<Vec<Box3>, String> {
        let boxes = self.bounds.boxes(pose, 0.0).map_err(text)?;
        boxes.into_iter().map(|own| own.ok_or_else(|| "no box".to_owned())).collect()
    }
}

pub(crate) fn place(random: &mut Random) -> Vec3 {
    Vec3::new(random.between(-GROUND, GROUND), random.between(0.5, 2.0), random.between(-GROUND, GROUND))
}

/// Makes some figures walk a bit, far, or not at all.
pub(crate) fn walk(figures: &mut [Figure], random: &mut Random) {
    for figure in figures {
        match random.below(4) {
            0 => continue,
            1 => figure.at = place(random),
            _ => {
                figure.at += Vec3::from(random.direction()) * Vec3::new(1.0, 0.0, 1.0);
                figure.time += 0.3;
            }
        }
        figure.version += 1;
    }
}

pub(crate) fn lights(random: &mut Random) -> Vec<Light> {
    let light = |number: usize| {
        let at = place(random) + 3.0 * Vec3::Y;
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

/// In the crowd, looking about level. Near 0.1, without a far plane.
pub(crate) fn camera(random: &mut Random) -> ShadowCamera {
    let origin = place(random);
    let forward = (Vec3::from(random.direction()) * Vec3::new(1.0, 0.2, 1.0)).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let [x, y, z] = [0, 1, 2].map(|axis| [2.0 * right[axis], 2.0 * up[axis], 0.0, forward[axis]]);
    let view_projection = [x, y, z, [0.0, 0.0, 0.1, 0.0]];
    ShadowCamera { view_projection, origin: origin.to_array(), depth: DepthDirection::Reversed }
}

/// Whether the camera sees a homogeneous point.
pub(crate) fn sees(camera: &ShadowCamera, point: DVec4) -> bool {
    let [x, y, z] = camera.origin.map(f64::from);
    let from = point - DVec4::new(x, y, z, 0.0) * point.w;
    let columns = camera.view_projection.map(|column| DVec4::from(column.map(f64::from)));
    let clip = columns[0] * from.x + columns[1] * from.y + columns[2] * from.z + columns[3] * from.w;
    clip.w > 0.0 && clip.x.abs() <= clip.w && clip.y.abs() <= clip.w && clip.z <= clip.w
}

/// A scene of the crowd, with its deformer.
pub(crate) struct Stage {
    pub(crate) scene: Scene,
    pub(crate) deformer: Deformer,
    pub(crate) casters: Vec<CasterHandle>,
    pub(crate) lights: Vec<LightHandle>,
}

impl Stage {
    pub(crate) fn new(gpu: &Gpu, crowd: &Crowd, lights: &[Light], options: SceneOptions) -> Result<Self, String> {
        let deformer = Deformer::new(&gpu.pipelines, &crowd.model, DeformerOptions::default()).map_err(text)?;
        let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
        let geometry = &crowd.model.geometries()[0];
        let mesh = Mesh::from_faces(geometry.positions().len(), geometry.faces().to_vec()).map_err(text)?;
        let mesh = scene.add_mesh(&mesh, geometry.positions()).map_err(text)?;
        let lights = lights.iter().map(|light| scene.add_light(*light).map_err(text)).collect::<Result<_, _>>()?;
        let figures = (0..crowd.model.instances().len()).map(|instance| {
            let positions = deformer.instance_positions(instance).ok_or("no instance")?;
            scene.insert(Caster::in_buffer(mesh, positions)).map_err(text)
        });
        let casters = figures.collect::<Result<_, String>>()?;
        Ok(Self { scene, deformer, casters, lights })
    }

    /// States where the figures are, and which version of them the frame has.
    pub(crate) fn state(&mut self, crowd: &Crowd, pose: &Pose, figures: &[Figure]) -> Result<(), String> {
        for ((&caster, own), figure) in self.casters.iter().zip(crowd.boxes(pose)?).zip(figures) {
            self.scene.set_bounds(caster, Some(own)).map_err(text)?;
            self.scene.set_position_version(caster, Some(figure.version)).map_err(text)?;
        }
        Ok(())
    }

    /// Records a frame that deforms what it needs.
    pub(crate) fn encode_needed(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        pose: &Pose,
        cameras: &[ShadowCamera],
    ) -> Result<(SceneNeeds, SceneFrame), String> {
        let needs = self.scene.encode_needs(encoder, &self.casters, cameras, None).map_err(text)?;
        self.deformer.encode_needed(encoder, pose, 0.0, None, &needs, None).map_err(text)?;
        let frame = self.scene.encode_needed(encoder, FrameInputs::new(&views(cameras)), &needs).map_err(text)?;
        Ok((needs, frame))
    }

    /// Records a frame that deforms everything.
    pub(crate) fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        pose: &Pose,
        cameras: &[ShadowCamera],
    ) -> Result<SceneFrame, String> {
        self.deformer.encode(encoder, pose, 0.0, None, None).map_err(text)?;
        self.scene.encode(encoder, FrameInputs::new(&views(cameras))).map_err(text)
    }
}
