//! A scene of a setting.

use bytemuck::Zeroable as _;
use glam::{Quat, Vec3};
use rimline::gpu::{
    Caster, CasterHandle, DeformerOptions, FrameInputs, LightHandle, Measuring, MeshHandle, ModelHandle,
    PositionBuffer, Receivers, Scene, SceneFrame, SceneOptions, SceneStatistics, ShadowError, ShadowPipelines,
    ShadowStatistics, StageTimer, View,
};
use rimline::{Counting, Light, ShadowCamera};
use wgpu::BufferUsages;

use super::{Casters, Setting};
use crate::Error;
use crate::gpu::Gpu;

/// How far a frame is recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Until {
    /// Silhouettes are extracted.
    Extraction,
    /// Volumes are prepared for a view.
    Volumes,
}

/// Options of a scene without clusters that makes its lists anew in each frame.
pub fn made_anew(max_lights: usize, counting: Counting) -> SceneOptions {
    let measuring = Measuring::CACHED_LISTS;
    SceneOptions { max_lights, counting, clusters_from: None, measuring, ..SceneOptions::default() }
}

/// Counters of a frame's stages.
#[derive(Clone, Copy, Debug)]
pub struct Counted {
    pub scene: SceneStatistics,
    pub shadows: ShadowStatistics,
}

pub struct SceneRecorder<'a> {
    pub setting: &'a Setting,
    pub camera: ShadowCamera,
    /// `None`: nothing is drawn.
    pipelines: Option<&'a ShadowPipelines>,
    pub scene: Scene,
    pub meshes: Vec<MeshHandle>,
    pub lights: Vec<LightHandle>,
    pub casters: Vec<CasterHandle>,
    /// The casters that walk.
    model: Option<ModelHandle>,
    frame: Option<SceneFrame>,
    /// Frames so far.
    frames: usize,
}

impl<'a> SceneRecorder<'a> {
    pub fn new(
        gpu: &Gpu,
        setting: &'a Setting,
        pipelines: Option<&'a ShadowPipelines>,
        options: SceneOptions,
    ) -> Result<Self, Error> {
        let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options)?;
        let (mut meshes, mut casters, mut model) = (Vec::new(), Vec::new(), None);
        match &setting.casters {
            Casters::Rigid { shapes, placed } => {
                for shape in shapes {
                    meshes.push(scene.add_mesh(&shape.mesh()?, &shape.positions)?);
                }
                for &(shape, matrix) in placed {
                    let caster = scene.insert(Caster::rigid(meshes[shape], matrix))?;
                    if let Some((_, polygons)) = setting.occluders.as_ref().filter(|(of, _)| *of == shape) {
                        scene
                            .set_occluders(caster, &polygons.iter().map(|polygon| &polygon[..]).collect::<Vec<_>>())?;
                    }
                    casters.push(caster);
                }
            }
            Casters::InBuffers(shapes) => {
                for shape in shapes {
                    let mesh = scene.add_mesh(&shape.mesh()?, &shape.positions)?;
                    let buffer = &gpu.buffer(BufferUsages::STORAGE, &shape.positions);
                    let positions = PositionBuffer { buffer, offset: 0, stride: 12 };
                    casters.push(scene.insert(Caster::in_buffer(mesh, positions))?);
                }
            }
            Casters::Walking { model: of, pose } => {
                model = Some(scene.insert_model(of, &pose(0)?, DeformerOptions::default())?);
            }
        }
        let lights = setting.lights.iter().map(|&light| scene.add_light(light)).collect::<Result<_, _>>()?;
        let camera = setting.camera;
        Ok(Self { setting, camera, pipelines, scene, meshes, lights, casters, model, frame: None, frames: 0 })
    }

    /// The positions of casters that walk.
    pub fn positions(&self) -> Result<Option<&wgpu::Buffer>, Error> {
        let positions = self.model.map(|model| self.scene.positions(model)).transpose()?;
        Ok(positions.map(|positions| positions.buffer))
    }

    /// Begins a frame. Returns whether casters walk, so that they must be deformed.
    pub fn begin(&mut self) -> Result<bool, Error> {
        if let (Some(model), Casters::Walking { pose, .. }) = (self.model, &self.setting.casters) {
            self.scene.set_pose(model, &pose(self.frames)?)?;
        }
        self.frames += 1;
        Ok(self.model.is_some())
    }

    /// Deforms casters of the pose that the frame needs.
    pub fn deform(&mut self, encoder: &mut wgpu::CommandEncoder, timer: Option<&mut StageTimer>) -> Result<(), Error> {
        let views = [View::new(self.camera)];
        Ok(self.scene.deform(encoder, FrameInputs { views: &views, timer })?)
    }

    /// Moves what the setting moves, and records all stages of the frame. `depth` is what the eye sees, if it is drawn.
    pub fn encode_seen(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        depth: Option<&wgpu::TextureView>,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), Error> {
        if let Casters::Rigid { placed, .. } = &self.setting.casters
            && self.setting.drift != 0.0
        {
            let drift = self.setting.drift * (self.frames % 2) as f32;
            for (&caster, (_, matrix)) in self.casters.iter().zip(placed) {
                self.scene.set_transform(caster, matrix.map(|[x, y, z, w]| [x, y, z, w + drift]))?;
            }
        }
        if self.setting.turn != 0.0 {
            let turn = Quat::from_rotation_y(self.setting.turn * self.frames as f32);
            for (&handle, &light) in self.lights.iter().zip(&self.setting.lights) {
                let xyz = (turn * Vec3::from(light.xyz)).to_array();
                self.scene.set_light(handle, Light { xyz, ..light })?;
            }
        }
        let version = self.setting.still_receivers();
        let depth = depth.map(|depth| Receivers { depth, sky_receives: false, version });
        let views = [View { depth, ..View::new(self.camera) }];
        self.frame = Some(self.scene.encode(encoder, FrameInputs { views: &views, timer })?);
        Ok(())
    }

    /// The last frame.
    pub fn frame(&self) -> Result<&SceneFrame, Error> {
        self.frame.as_ref().ok_or(Error::Shadow(ShadowError::NotEncoded))
    }

    /// The counters of the last frame's stages.
    pub fn counted(&self, gpu: &Gpu) -> Result<Counted, Error> {
        let frame = self.frame()?;
        let scene = gpu.read(frame.statistics())?.first().copied();
        let shadows = frame.shadow_statistics().map(|buffer| gpu.read(buffer)).transpose()?;
        let shadows = shadows.and_then(|shadows| shadows.first().copied());
        let (none, nothing) = (SceneStatistics::zeroed(), ShadowStatistics::zeroed());
        Ok(Counted { scene: scene.unwrap_or(none), shadows: shadows.unwrap_or(nothing) })
    }

    /// Bytes of the last frame's buffers, topology not counted.
    pub fn bytes(&self) -> Result<u64, Error> {
        Ok(self.frame()?.results()?.bytes)
    }

    /// The number of silhouette edges of each light, of the last encode.
    pub fn silhouette_edges(&self, gpu: &Gpu) -> Result<Vec<u64>, Error> {
        let mut edges = vec![0; self.lights.len()];
        for group in &self.frame()?.results()?.groups {
            let counts: Vec<u32> = gpu.read(group.lists)?;
            edges.iter_mut().zip(counts).for_each(|(sum, count)| *sum += u64::from(count));
        }
        Ok(edges)
    }

    /// Records the compute stages of a frame in which nothing moves.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        until: Until,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), Error> {
        let views = [View::new(self.camera)];
        let views = if until == Until::Volumes { &views[..] } else { &[] };
        self.frame = Some(self.scene.encode(encoder, FrameInputs { views, timer })?);
        Ok(())
    }

    /// Draws the volumes of a light into a pass that counts.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, light: usize) -> Result<(), Error> {
        if let (Some(pipelines), Some(&light)) = (self.pipelines, self.lights.get(light)) {
            self.frame()?.draw(pass, pipelines, 0, light)?;
        }
        Ok(())
    }
}
