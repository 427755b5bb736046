//! Each file as one caster, in a scene of its own: for ZP+ as published in 2005 and for polygons.

use std::sync::Arc;

use rimline::gpu::{
    Caster as SceneCaster, Extraction, Extractor, ExtractorOptions, FrameInputs, LightHandle, Measuring, Scene,
    SceneFrame, SceneOptions, ShadowError, ShadowPipelines, StageTimer,
};
use rimline::reference::layout::{ExtractionStatistics, ShadowStatistics};
use rimline::{Light, Mesh, wgpu};

use super::casting::{CastInputs, FacingMasks, put, set_lights};
use super::depth;
use super::posed_model::{PosedModel, Topology};
use super::scene_shadows::first_words;
use super::shadows::{Choice, Found, Shadows, VolumePipelines, scene_options};
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::{GpuError, On as _};

/// The extractor of a single file's mesh, and what it extracted last.
pub(super) struct Extracted {
    pub(super) extractor: Extractor,
    pub(super) extraction: Option<Extraction>,
    /// Topologies that its mesh was made of.
    topologies: Vec<Topology>,
}

impl Extracted {
    /// `mesh` has some of the file's faces, over its vertices.
    pub(super) fn new(gpu: &Gpu, mesh: &Mesh, body: &PosedModel<'_>, max_lights: usize) -> Result<Self, Failure> {
        let options = ExtractorOptions { max_lights, ..ExtractorOptions::default() };
        let extractor = Extractor::new(&gpu.pipelines, mesh, options).on(gpu)?;
        Ok(Self { extractor, extraction: None, topologies: body.topologies.clone() })
    }

    /// Whether it is of the faces that the body has now: an instance that is mirrored turns its faces.
    pub(super) fn is_of(&self, body: &PosedModel<'_>) -> bool {
        self.topologies == body.topologies
    }

    pub(super) fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        body: &PosedModel<'_>,
        lights: &[Light],
        timer: Option<&mut StageTimer>,
    ) -> Result<&Extraction, GpuError> {
        let extraction = self.extractor.encode_timed(encoder, body.positions.buffer(), lights, timer)?;
        Ok(self.extraction.insert(extraction))
    }

    /// Where the facing masks of the body's faces lie.
    pub(super) fn facing(&self, body: &PosedModel<'_>) -> FacingMasks {
        let faces = 0..body.faces.len() as u32;
        FacingMasks { slots: faces.clone().collect(), runs: vec![(faces, self.extractor.results().facing.to_vec())] }
    }

    /// The silhouette edges of each light, and the statistics. Waits for the device.
    pub(super) fn found(&self, gpu: &Gpu, lights: usize) -> Result<(Vec<u32>, ExtractionStatistics), GpuError> {
        let results = self.extractor.results();
        let mut silhouettes: Vec<u32> = gpu.read(results.counts)?;
        silhouettes.truncate(lights);
        Ok((silhouettes, gpu.read_first(results.statistics)?))
    }
}

pub(super) struct SingleCasters {
    pipelines: Arc<ShadowPipelines>,
    max_lights: usize,
    casters: Vec<Caster>,
}

/// A file.
struct Caster {
    scene: Scene,
    lights: Vec<LightHandle>,
    /// Topologies that its mesh was made of.
    topologies: Vec<Topology>,
    /// Triangles of polygons, which are drawn. A polygon may be front-facing to a light while one of its triangles is
    /// back-facing.
    surface: Option<Extracted>,
    /// Frame of the last encode, to draw.
    frame: Option<SceneFrame>,
}

impl Caster {
    fn frame(&self) -> Result<&SceneFrame, ShadowError> {
        self.frame.as_ref().ok_or(ShadowError::NotEncoded)
    }

    fn statistics(&self, gpu: &Gpu) -> Result<ShadowStatistics, GpuError> {
        let buffer = self.frame()?.shadow_statistics().ok_or(ShadowError::NotEncoded)?;
        Ok(gpu.read_first(buffer)?)
    }

    /// The silhouette edges of each light, and the statistics of the extraction. Waits for the device.
    fn extracted(&self, gpu: &Gpu) -> Result<(Vec<u32>, ExtractionStatistics), GpuError> {
        let (mut silhouettes, mut sum) = (Vec::new(), bytemuck::Zeroable::zeroed());
        for group in self.frame()?.results()?.groups {
            silhouettes.extend(first_words(gpu, group.lists, 32)?);
            let record = first_words(gpu, group.record, size_of::<ExtractionStatistics>() as u64 / 4)?;
            sum = depth::sum(sum, bytemuck::pod_read_unaligned(bytemuck::cast_slice(&record)));
        }
        silhouettes.truncate(self.lights.len());
        Ok((silhouettes, sum))
    }
}

impl SingleCasters {
    pub(super) fn new(pipelines: &Arc<ShadowPipelines>, max_lights: usize) -> Self {
        Self { pipelines: Arc::clone(pipelines), max_lights, casters: Vec::new() }
    }
}

impl Shadows for SingleCasters {
    fn place(&mut self, gpu: &Gpu, bodies: &[PosedModel<'_>]) -> Result<(), Failure> {
        for (number, body) in bodies.iter().enumerate() {
            if self.casters.get(number).is_some_and(|caster| caster.topologies == body.topologies) {
                continue;
            }
            let mut options = SceneOptions { max_lights: self.max_lights, ..scene_options(self.pipelines.counting()) };
            options.measuring.set(Measuring::LISTS, true);
            options.clusters_from = None;
            let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(GpuError::Volumes).on(gpu)?;
            let mesh = scene.add_mesh(&body.mesh()?, &body.world).map_err(GpuError::Volumes).on(gpu)?;
            let caster = SceneCaster::in_buffer(mesh, body.positions.buffer());
            scene.insert(caster).map_err(GpuError::Volumes).on(gpu)?;
            let triangles = body.triangles()?;
            let surface = triangles.map(|mesh| Extracted::new(gpu, &mesh, body, self.max_lights)).transpose()?;
            let topologies = body.topologies.clone();
            put(&mut self.casters, number, Caster { scene, lights: Vec::new(), topologies, surface, frame: None });
        }
        Ok(())
    }

    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        CastInputs { bodies, camera, lights, .. }: CastInputs<'_>,
        mut timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        for (caster, body) in self.casters.iter_mut().zip(bodies) {
            if let Some(surface) = &mut caster.surface {
                surface.encode(encoder, body, lights, timer.as_deref_mut())?;
            }
            set_lights(&mut caster.scene, &mut caster.lights, lights)?;
            let views = [(*camera).into()];
            let inputs = FrameInputs { timer: timer.as_deref_mut(), ..FrameInputs::new(&views) };
            caster.frame = Some(caster.scene.encode(encoder, inputs)?);
        }
        Ok(())
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, pipelines: &VolumePipelines, light: usize) -> Result<(), GpuError> {
        let VolumePipelines::Single(own) = pipelines else {
            return Err(pipelines.refuse(self.pipelines.counting()));
        };
        for caster in &self.casters {
            let light = *caster.lights.get(light).ok_or(ShadowError::NotEncoded)?;
            caster.frame()?.draw(pass, own, 0, light)?;
        }
        Ok(())
    }

    fn facing(&self, _: &Gpu, bodies: &[PosedModel<'_>]) -> Result<Vec<FacingMasks>, GpuError> {
        let of_file = |(caster, body): (&Caster, &PosedModel<'_>)| {
            if let Some(surface) = &caster.surface {
                return Ok(surface.facing(body));
            }
            let faces = 0..body.faces.len() as u32;
            let masks = caster.frame()?.results()?.groups.iter().map(|group| group.facing.clone()).collect();
            Ok(FacingMasks { slots: faces.clone().collect(), runs: vec![(faces, masks)] })
        };
        self.casters.iter().zip(bodies).map(of_file).collect()
    }

    fn found(&self, gpu: &Gpu) -> Result<Vec<Found>, GpuError> {
        let of_file = |caster: &Caster| {
            let (silhouettes, extraction) = caster.extracted(gpu)?;
            let choices = caster.frame()?.results()?.choices.ok_or(ShadowError::NotEncoded)?;
            let words: Vec<u32> = gpu.read(choices)?;
            let lights = Choice::all(self.pipelines.counting(), &words, caster.lights.len());
            Ok(Found { lights, silhouettes, extraction, shadow: caster.statistics(gpu)?, is_whole: true })
        };
        self.casters.iter().map(of_file).collect()
    }

    /// All casters count into one stencil, so their bounds add up.
    fn statistics(&self, gpu: &Gpu) -> Result<ShadowStatistics, GpuError> {
        let mut all: ShadowStatistics = bytemuck::Zeroable::zeroed();
        for caster in &self.casters {
            all = depth::sum(all, caster.statistics(gpu)?);
        }
        if self.casters.len() > 1 {
            all.may_wrap = if all.count_bound > depth::MOST { self.max_lights as u32 } else { 0 };
        }
        Ok(all)
    }
}
