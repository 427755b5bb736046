//! Scenes of settings, and extractors of meshes.

use bytemuck::Zeroable as _;
use glam::{Quat, Vec3};
use rimline::gpu::{
    Caster, CasterHandle, DeformerOptions, Extraction, Extractor, ExtractorOptions, FrameInputs, LightHandle,
    Measuring, MeshHandle, ModelHandle, PositionBuffer, Receivers, Scene, SceneFrame, SceneOptions, SceneStatistics,
    ShadowError, ShadowPipelines, ShadowStatistics, StageTimer, View,
};
use rimline::{Counting, Light, Mesh, ShadowCamera};
use wgpu::{BufferUsages, LoadOp, TextureView};

use super::{Casters, Pass, STENCIL, Setting, Surfaces, Target};
use crate::Error;
use crate::gpu::{Gpu, beside_draws};

/// How far a frame is recorded.
#[derive(Clone, Copy, Debug)]
pub enum Until<'a> {
    Extraction,
    /// Volumes are prepared for a view. With depths, those in which no surface is seen are culled. Then the depths must be
    /// drawn before the commands run, by the setting's surfaces.
    Volumes(Option<&'a TextureView>),
}

/// Options of a scene without clusters that makes its lists of sides and caps anew in each frame. Any scene does so with
/// bits and silhouettes of casters in buffers; those of rigid casters stay cached.
pub fn made_anew(max_lights: usize, counting: Counting) -> SceneOptions {
    let measuring = Measuring::CACHED_LISTS;
    SceneOptions { max_lights, counting, clusters_from: None, measuring, ..SceneOptions::default() }
}

#[derive(Clone, Copy, Debug)]
pub struct Counted {
    pub scene: SceneStatistics,
    pub shadows: ShadowStatistics,
}

pub struct SceneRecorder<'a> {
    pub setting: &'a Setting,
    /// At first that of the setting.
    pub camera: ShadowCamera,
    /// `None`: nothing is drawn.
    pipelines: Option<&'a ShadowPipelines>,
    pub scene: Scene,
    /// A mesh for each shape of rigid casters.
    pub meshes: Vec<MeshHandle>,
    pub lights: Vec<LightHandle>,
    /// In the order of the setting, but none that walk.
    pub casters: Vec<CasterHandle>,
    model: Option<ModelHandle>,
    frame: Option<SceneFrame>,
    /// How many were begun.
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

    /// Begins a frame: casters that walk get their next pose, in the first frame that of the start. [`Self::encode`] moves
    /// rigid casters and lights. Returns whether casters walk: draw their depths only after [`Self::deform`].
    pub fn begin(&mut self) -> Result<bool, Error> {
        if let (Some(model), Casters::Walking { pose, .. }) = (self.model, &self.setting.casters) {
            self.scene.set_pose(model, &pose(self.frames)?)?;
        }
        self.frames += 1;
        Ok(self.model.is_some())
    }

    /// Deforms casters that walk. An encode of volumes does not do so again, unless lights turn; other encodes do.
    pub fn deform(&mut self, encoder: &mut wgpu::CommandEncoder, timer: Option<&mut StageTimer>) -> Result<(), Error> {
        let views = [View::new(self.camera)];
        Ok(self.scene.deform(encoder, FrameInputs { views: &views, timer })?)
    }

    /// Moves rigid casters and lights as the setting says for the number of frames begun, and records the compute stages of
    /// the frame. Before the first [`Self::begin`] they are where they start.
    pub fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        until: Until<'_>,
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
        let view = if let Until::Volumes(depth) = until {
            // Rigid casters that do not drift look the same in each frame. A caller that moves them gives no depths.
            let is_still = matches!(self.setting.casters, Casters::Rigid { .. }) && self.setting.drift == 0.0;
            let version = is_still.then_some(0);
            let depth = depth.map(|depth| Receivers { depth, sky_receives: false, version });
            Some(View { depth, ..View::new(self.camera) })
        } else {
            None
        };
        self.frame = Some(self.scene.encode(encoder, FrameInputs { views: view.as_slice(), timer })?);
        Ok(())
    }

    pub fn frame(&self) -> Result<&SceneFrame, Error> {
        self.frame.as_ref().ok_or(Error::Shadow(ShadowError::NotEncoded))
    }

    /// The statistics of the last encode. Without a view those of shadows are 0.
    pub fn counted(&self, gpu: &Gpu) -> Result<Counted, Error> {
        let frame = self.frame()?;
        let scene = gpu.read(frame.statistics())?.pop().unwrap_or_else(SceneStatistics::zeroed);
        let shadows = frame.shadow_statistics().map_or(Ok(Vec::new()), |buffer| gpu.read(buffer))?.pop();
        Ok(Counted { scene, shadows: shadows.unwrap_or_else(ShadowStatistics::zeroed) })
    }

    /// Bytes of the last frame's buffers, but for meshes and the positions of casters.
    pub fn bytes(&self) -> Result<u64, Error> {
        Ok(self.frame()?.results()?.bytes)
    }

    /// The number of silhouette edges of each light, of the last encode.
    pub fn silhouette_edges(&self, gpu: &Gpu) -> Result<Vec<u64>, Error> {
        let mut edges = vec![0; self.lights.len()];
        for group in &self.frame()?.results()?.groups {
            let counts: Vec<u32> = gpu.read(group.lists)?;
            let of_batch = edges.iter_mut().skip(32 * group.batch).take(32);
            of_batch.zip(counts).for_each(|(sum, count)| *sum += u64::from(count));
        }
        Ok(edges)
    }

    /// Draws the volumes of a light, by its index in [`Self::lights`], into a pass that counts. Other indices draw nothing.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, light: usize) -> Result<(), Error> {
        if let (Some(pipelines), Some(&light)) = (self.pipelines, self.lights.get(light)) {
            self.frame()?.draw(pass, pipelines, 0, light)?;
        }
        Ok(())
    }
}

pub struct Drawn<'a> {
    pub scene: SceneRecorder<'a>,
    /// `None`: volumes are drawn over depths without any surface.
    pub surfaces: Option<Surfaces>,
    /// Depths and stencil.
    pub depth: TextureView,
    /// The same depths, for stages that cull volumes in which no surface is seen. The depth pass must come before them.
    pub receivers: Option<TextureView>,
}

impl Drawn<'_> {
    /// Records a part of a frame: its `stages`, the `depth` pass, the [`STENCIL`] pass of each light, or the `light` pass.
    /// Each stencil pass begins with a stencil of 0, so the light pass adds the last light. Without surfaces there are no
    /// depth and light passes.
    pub fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        part: &'static str,
        mut timer: Option<&mut StageTimer>,
    ) -> Result<(), Error> {
        let Self { scene, surfaces, depth, receivers } = self;
        match (part, surfaces) {
            ("stages", _) => scene.encode(encoder, Until::Volumes(receivers.as_ref()), beside_draws(timer))?,
            ("depth", Some(surfaces)) => surfaces.pass(encoder, depth, Pass::Depth, timer),
            ("light", Some(surfaces)) => surfaces.pass(encoder, depth, Pass::Light, timer),
            (STENCIL, surfaces) => {
                // Depth is reversed: 0 is farthest.
                let load = if surfaces.is_some() { LoadOp::Load } else { LoadOp::Clear(0.0) };
                for light in 0..scene.lights.len() {
                    let target = Target::counting(depth, load);
                    scene.draw(&mut target.begin_timed(encoder, STENCIL, timer.as_deref_mut(), None), light)?;
                }
            }
            _ => {}
        }
        Ok(())
    }
}

/// An extractor with the positions of its mesh, and lights.
pub struct ExtractorRecorder {
    pub extractor: Extractor,
    positions: wgpu::Buffer,
    lights: Vec<Light>,
    extraction: Option<Extraction>,
}

impl ExtractorRecorder {
    pub fn new(
        gpu: &Gpu,
        options: ExtractorOptions,
        mesh: &Mesh,
        positions: &[[f32; 3]],
        lights: &[Light],
    ) -> Result<Self, Error> {
        let extractor = Extractor::new(&gpu.pipelines, mesh, options)?;
        gpu.check()?;
        let positions = gpu.buffer(BufferUsages::STORAGE, positions);
        Ok(Self { extractor, positions, lights: lights.to_vec(), extraction: None })
    }

    pub fn encode(&mut self, encoder: &mut wgpu::CommandEncoder, timer: Option<&mut StageTimer>) -> Result<(), Error> {
        let positions = PositionBuffer { buffer: &self.positions, offset: 0, stride: 12 };
        self.extraction = Some(self.extractor.encode_timed(encoder, positions, &self.lights, timer)?);
        Ok(())
    }

    /// The number of silhouette edges of each light, of the last encode. Empty without one.
    pub fn silhouette_edges(&self, gpu: &Gpu) -> Result<Vec<u64>, Error> {
        let Some(extraction) = &self.extraction else { return Ok(Vec::new()) };
        let counts: Vec<u32> = gpu.read(extraction.results()?.counts)?;
        Ok(counts.into_iter().take(self.lights.len()).map(u64::from).collect())
    }
}
