//! A scene of a setting.

use bytemuck::Zeroable as _;
use glam::{Quat, Vec3};
use rimline::gpu::{
    Caster, CasterHandle, DeformError, Deformer, DeformerOptions, FrameInputs, LightHandle, Measuring, MeshHandle,
    Receivers, Scene, SceneFrame, SceneNeeds, SceneOptions, SceneStatistics, ShadowPipelines, ShadowStatistics,
    StageTimer, View,
};
use rimline::{Light, Mesh, MeshError, ModelBounds, Pose};

use super::{Casters, Recorder, Setting, Until};
use crate::Error;
use crate::gpu::Gpu;

/// Deforms casters that walk, for all recorders on a device.
pub struct Deforming<'a> {
    setting: &'a Setting,
    deformer: Option<Deformer>,
}

impl<'a> Deforming<'a> {
    pub fn new(gpu: &Gpu, setting: &'a Setting) -> Result<Self, Error> {
        let deformer = match &setting.casters {
            Casters::Rigid { .. } => None,
            Casters::Walking { model, .. } => Some(Deformer::new(&gpu.pipelines, model, DeformerOptions::default())?),
        };
        Ok(Self { setting, deformer })
    }

    /// The positions of all casters.
    pub fn positions(&self) -> Option<&wgpu::Buffer> {
        self.deformer.as_ref().map(|deformer| deformer.positions().buffer)
    }

    fn pose(&self, frame: usize) -> Result<Option<Pose>, Error> {
        match &self.setting.casters {
            Casters::Rigid { .. } => Ok(None),
            Casters::Walking { pose, .. } => Ok(Some(pose(frame)?)),
        }
    }

    /// Records the deformation into a pose, of what the frame needs.
    fn encode(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        pose: &Pose,
        needs: Option<&SceneNeeds>,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), Error> {
        match (&self.deformer, needs) {
            (Some(deformer), Some(needs)) => deformer.encode_needed(encoder, pose, 0.0, None, needs, timer)?,
            (Some(deformer), None) => deformer.encode(encoder, pose, 0.0, None, timer)?,
            (None, _) => {}
        }
        Ok(())
    }
}

/// Counters of a frame's stages.
#[derive(Clone, Copy, Debug)]
pub struct Counted {
    pub scene: SceneStatistics,
    pub shadows: ShadowStatistics,
}

/// A mesh with its positions at rest.
type Given<'a> = (Mesh, &'a [[f32; 3]]);

pub struct SceneRecorder<'a> {
    setting: &'a Setting,
    deforming: &'a Deforming<'a>,
    /// `None`: nothing is drawn.
    pipelines: Option<&'a ShadowPipelines>,
    pub scene: Scene,
    pub meshes: Vec<MeshHandle>,
    pub lights: Vec<LightHandle>,
    pub casters: Vec<CasterHandle>,
    /// Where casters that walk are in a pose.
    bounds: Option<ModelBounds>,
    skips_unneeded: bool,
    pose: Option<Pose>,
    needs: Option<SceneNeeds>,
    frame: Option<SceneFrame>,
    /// Frames so far.
    frames: usize,
}

impl<'a> SceneRecorder<'a> {
    pub fn new(
        gpu: &Gpu,
        setting: &'a Setting,
        deforming: &'a Deforming<'a>,
        pipelines: Option<&'a ShadowPipelines>,
        options: SceneOptions,
    ) -> Result<Self, Error> {
        let mut of_frame = options.measuring;
        of_frame.set(Measuring::UNNEEDED, true);
        let skips_unneeded = of_frame != options.measuring;
        let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options)?;
        let (mut casters, mut bounds) = (Vec::new(), None);
        let given: Result<Vec<Given<'_>>, MeshError> = match &setting.casters {
            Casters::Rigid { shapes, .. } => {
                shapes.iter().map(|shape| Ok((shape.mesh()?, &shape.positions[..]))).collect()
            }
            Casters::Walking { model, .. } => {
                let mesh = |positions: &[_], faces: &[_]| Mesh::from_faces(positions.len(), faces.to_vec());
                let geometries = model.geometries().iter();
                geometries.map(|of| Ok((mesh(of.positions(), of.faces())?, of.positions()))).collect()
            }
        };
        let mut meshes = Vec::new();
        for (mesh, positions) in given? {
            meshes.push(scene.add_mesh(&mesh, positions)?);
        }
        match (&setting.casters, &deforming.deformer) {
            (Casters::Rigid { placed, .. }, _) => {
                for &(shape, matrix) in placed {
                    casters.push(scene.insert(Caster::rigid(meshes[shape], matrix))?);
                }
            }
            (Casters::Walking { model, .. }, Some(deformer)) => {
                bounds = Some(ModelBounds::new(model));
                for (number, instance) in model.instances().iter().enumerate() {
                    if let Some(positions) = deformer.instance_positions(number) {
                        casters.push(scene.insert(Caster::in_buffer(meshes[instance.geometry()], positions))?);
                    }
                }
            }
            (Casters::Walking { .. }, None) => {}
        }
        let lights = setting.lights.iter().map(|&light| scene.add_light(light)).collect::<Result<_, _>>()?;
        Ok(Self {
            setting,
            deforming,
            pipelines,
            scene,
            meshes,
            lights,
            casters,
            bounds,
            skips_unneeded,
            pose: None,
            needs: None,
            frame: None,
            frames: 0,
        })
    }

    /// Begins a frame. Returns whether casters walk, so that they must be deformed.
    pub fn begin(&mut self) -> Result<bool, Error> {
        self.pose = self.deforming.pose(self.frames)?;
        self.frames += 1;
        Ok(self.pose.is_some())
    }

    /// States where casters of the pose are, finds those that the frame needs, and deforms them.
    pub fn deform(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        mut timer: Option<&mut StageTimer>,
    ) -> Result<(), Error> {
        let (Some(bounds), Some(pose)) = (&self.bounds, &self.pose) else { return Ok(()) };
        let boxes = bounds.boxes(pose, 0.0).map_err(DeformError::from)?;
        for (&caster, own) in self.casters.iter().zip(boxes) {
            self.scene.set_bounds(caster, own)?;
        }
        if self.skips_unneeded {
            let cameras = [self.setting.camera];
            self.needs = Some(self.scene.encode_needs(encoder, &self.casters, &cameras, timer.as_deref_mut())?);
        }
        self.deforming.encode(encoder, pose, self.needs.as_ref(), timer)
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
        let views = [View { camera: self.setting.camera, depth }];
        let inputs = FrameInputs { views: &views, timer };
        let frame = match &self.needs {
            Some(needs) => self.scene.encode_needed(encoder, inputs, needs),
            None => self.scene.encode(encoder, inputs),
        };
        self.frame = Some(frame?);
        Ok(())
    }

    /// The counters of the last frame's stages.
    pub fn counted(&self, gpu: &Gpu) -> Result<Counted, Error> {
        let mut counted = Counted { scene: SceneStatistics::zeroed(), shadows: ShadowStatistics::zeroed() };
        if let Some(frame) = &self.frame {
            let scene: Vec<SceneStatistics> = gpu.read(frame.statistics())?;
            counted.scene = scene.first().copied().unwrap_or(counted.scene);
            if let Some(buffer) = frame.shadow_statistics() {
                let shadows: Vec<ShadowStatistics> = gpu.read(buffer)?;
                counted.shadows = shadows.first().copied().unwrap_or(counted.shadows);
            }
        }
        Ok(counted)
    }

    /// Bytes of the last frame's buffers, topology not counted.
    pub fn bytes(&self) -> Result<u64, Error> {
        Ok(self.frame.as_ref().map(SceneFrame::results).transpose()?.map_or(0, |results| results.bytes))
    }

    /// The number of silhouette edges of each light, of the last encode.
    pub fn silhouette_edges(&self, gpu: &Gpu) -> Result<Vec<u64>, Error> {
        let mut edges = vec![0; self.lights.len()];
        let results = self.frame.as_ref().map(SceneFrame::results).transpose()?;
        for group in results.iter().flat_map(|results| &results.groups) {
            let counts: Vec<u32> = gpu.read(group.lists)?;
            edges.iter_mut().zip(counts).for_each(|(sum, count)| *sum += u64::from(count));
        }
        Ok(edges)
    }
}

impl Recorder for SceneRecorder<'_> {
    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        until: Until,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), Error> {
        let views = [View::new(self.setting.camera)];
        let views = if until == Until::Volumes { &views[..] } else { &[] };
        self.frame = Some(self.scene.encode(encoder, FrameInputs { views, timer })?);
        Ok(())
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, light: usize) -> Result<(), Error> {
        if let (Some(frame), Some(pipelines), Some(&light)) = (&self.frame, self.pipelines, self.lights.get(light)) {
            frame.draw(pass, pipelines, 0, light)?;
        }
        Ok(())
    }
}
