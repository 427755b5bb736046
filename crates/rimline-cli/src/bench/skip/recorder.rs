//! Records the frames of a setting with some levels of skipping on.

use glam::{Quat, Vec3};
use rimline::gpu::{
    Caster, CasterHandle, DeformError, Deformer, DeformerOptions, LightHandle, Receivers, Scene, SceneFrame,
    SceneNeeds, SceneStatistics, ShadowStatistics, StageTimer, read_back_vec,
};
use rimline::{Light, Mesh, MeshError, ModelBounds, ModelError, Pose, wgpu};

use super::super::casters::recorder::{DrawPipelines, mesh_failure};
use super::levels::Variant;
use super::results::Counted;
use super::setting::{Casters, Setting};
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::GpuError;

/// Deforms figures that walk, for all recorders on a device.
pub(super) struct Deforming<'a> {
    setting: &'a Setting,
    deformer: Option<Deformer>,
}

impl<'a> Deforming<'a> {
    pub(super) fn new(gpu: &Gpu, setting: &'a Setting) -> Result<Self, Failure> {
        let make = |model| Deformer::new(&gpu.pipelines, model, DeformerOptions::default());
        let deformer = match &setting.casters {
            Casters::Rigid { .. } => None,
            Casters::Walking(walk) => Some(make(&walk.model).map_err(|error| GpuError::from(error).on(gpu))?),
        };
        Ok(Self { setting, deformer })
    }

    /// The positions of all figures.
    pub(super) fn positions(&self) -> Option<&wgpu::Buffer> {
        self.deformer.as_ref().map(|deformer| deformer.positions().buffer)
    }

    /// The pose of a frame. `None`: nothing is deformed.
    pub(super) fn pose(&self, frame: usize) -> Result<Option<Pose>, Failure> {
        match &self.setting.casters {
            Casters::Rigid { .. } => Ok(None),
            Casters::Walking(walk) => walk.pose(frame).map(Some).map_err(model_failure),
        }
    }

    /// Records the deformation into a pose, of what the frame needs.
    pub(super) fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pose: Option<&Pose>,
        needs: Option<&SceneNeeds>,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        match (&self.deformer, pose, needs) {
            (Some(deformer), Some(pose), Some(needs)) => {
                deformer.encode_needed(encoder, pose, 0.0, None, needs, timer)?;
            }
            (Some(deformer), Some(pose), None) => deformer.encode(encoder, pose, 0.0, None, timer)?,
            _ => {}
        }
        Ok(())
    }
}

/// Why a model or a pose cannot be made.
pub(super) fn model_failure(source: ModelError) -> Failure {
    Failure::Input { file: "crowd".into(), source: source.into() }
}

/// A mesh with its positions at rest.
type Given<'a> = (Mesh, &'a [[f32; 3]]);

/// A scene with some levels on.
pub(super) struct SkipRecorder<'a> {
    setting: &'a Setting,
    scene: Scene,
    lights: Vec<LightHandle>,
    casters: Vec<CasterHandle>,
    /// Where figures that walk are in a pose, and whether they are left out where the frame does not need them.
    bounds: Option<ModelBounds>,
    skips_unneeded: bool,
    needs: Option<SceneNeeds>,
    encoded: Option<SceneFrame>,
    /// Frames so far.
    pub(super) frames: usize,
}

impl<'a> SkipRecorder<'a> {
    pub(super) fn new(
        gpu: &Gpu,
        setting: &'a Setting,
        deforming: &Deforming<'_>,
        variant: Variant,
    ) -> Result<Self, Failure> {
        let lights = setting.lights.len();
        let options = variant.options(lights);
        let scene = Scene::new(&gpu.pipelines, &gpu.queue, options);
        let bounds = match &setting.casters {
            Casters::Rigid { .. } => None,
            Casters::Walking(walk) => Some(ModelBounds::new(&walk.model)),
        };
        let mut recorder = Self {
            setting,
            scene: scene.map_err(|error| GpuError::from(error).on(gpu))?,
            lights: Vec::with_capacity(lights),
            casters: Vec::new(),
            bounds,
            skips_unneeded: options.skip_unneeded,
            needs: None,
            encoded: None,
            frames: 0,
        };
        let meshes: Result<Vec<Given<'_>>, MeshError> = match &setting.casters {
            Casters::Rigid { shapes, .. } => {
                shapes.iter().map(|shape| Ok((shape.mesh()?, &shape.positions[..]))).collect()
            }
            Casters::Walking(walk) => {
                let geometries = walk.model.geometries().iter();
                let mesh = |positions: &[_], faces: &[_]| Mesh::from_faces(positions.len(), faces.to_vec());
                geometries.map(|of| Ok((mesh(of.positions(), of.faces())?, of.positions()))).collect()
            }
        };
        recorder.fill(&meshes.map_err(mesh_failure)?, deforming).map_err(|error| error.on(gpu))?;
        Ok(recorder)
    }

    fn fill(&mut self, meshes: &[Given<'_>], deforming: &Deforming<'_>) -> Result<(), GpuError> {
        let scene = &mut self.scene;
        let mut handles = Vec::with_capacity(meshes.len());
        for (mesh, positions) in meshes {
            handles.push(scene.add_mesh(mesh, positions)?);
        }
        match (&self.setting.casters, &deforming.deformer) {
            (Casters::Rigid { placed, .. }, _) => {
                for &(shape, matrix) in placed {
                    self.casters.push(scene.insert(Caster::rigid(handles[shape], matrix))?);
                }
            }
            (Casters::Walking(walk), Some(deformer)) => {
                for (number, instance) in walk.model.instances().iter().enumerate() {
                    if let Some(positions) = deformer.instance_positions(number) {
                        let caster = Caster::in_buffer(handles[instance.geometry()], positions);
                        self.casters.push(scene.insert(caster)?);
                    }
                }
            }
            (Casters::Walking(_), None) => {}
        }
        for &light in &self.setting.lights {
            self.lights.push(scene.add_light(light)?);
        }
        Ok(())
    }

    /// States where the figures of a pose are, and finds those that the frame needs. `None`: all are deformed.
    pub(super) fn find_needs(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        pose: Option<&Pose>,
        timer: Option<&mut StageTimer>,
    ) -> Result<Option<&SceneNeeds>, GpuError> {
        if let (Some(bounds), Some(pose)) = (&self.bounds, pose) {
            let boxes = bounds.boxes(pose, 0.0).map_err(DeformError::from)?;
            for (&figure, own) in self.casters.iter().zip(boxes) {
                self.scene.set_bounds(figure, own)?;
            }
            if self.skips_unneeded {
                self.needs = Some(self.scene.encode_needs(encoder, &self.casters, &[self.setting.camera], timer)?);
            }
        }
        Ok(self.needs.as_ref())
    }

    /// Records all stages of the frame at hand. `depth` is what the eye sees, if it is drawn.
    pub(super) fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        depth: Option<&wgpu::TextureView>,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
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
        let receivers = [depth.map(|depth| Receivers { depth, sky_receives: false, version })];
        let cameras = [self.setting.camera];
        let encoded = match &self.needs {
            Some(needs) => self.scene.encode_needed(encoder, &cameras, &receivers, needs, timer),
            None => self.scene.encode_for(encoder, &cameras, &receivers, timer),
        };
        self.encoded = Some(encoded?);
        Ok(())
    }

    pub(super) fn lights(&self) -> usize {
        self.lights.len()
    }

    /// Draws the volumes of a light into a stencil pass.
    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &DrawPipelines,
        light: usize,
    ) -> Result<(), GpuError> {
        if let (Some(frame), Some(&light)) = (&self.encoded, self.lights.get(light)) {
            frame.draw(pass, &pipelines.scene, 0, light)?;
        }
        Ok(())
    }

    /// Reads the counters of the last frame's stages.
    pub(super) fn counted(&self, gpu: &Gpu) -> Result<Counted, GpuError> {
        let mut counted = Counted::default();
        let Gpu { device, queue, .. } = gpu;
        if let Some(frame) = &self.encoded {
            let scene: Vec<SceneStatistics> = read_back_vec(device, queue, frame.statistics())?;
            counted.scene = scene.first().copied().unwrap_or(counted.scene);
            if let Some(buffer) = frame.shadow_statistics() {
                let shadows: Vec<ShadowStatistics> = read_back_vec(device, queue, buffer)?;
                counted.shadows = shadows.first().copied().unwrap_or(counted.shadows);
            }
        }
        Ok(counted)
    }
}
