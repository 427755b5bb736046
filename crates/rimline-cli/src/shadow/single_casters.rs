//! Each file as one caster. ZP+ as published in 2005 and polygons need this: scenes have neither.

use std::sync::Arc;

use rimline::gpu::{
    Extraction, Extractor, ExtractorOptions, ShadowFrame, ShadowOptions, ShadowPipelines, ShadowVolumes, StageTimer,
};
use rimline::reference::layout::{ExtractionStatistics, ShadowStatistics};
use rimline::{Light, Mesh, wgpu};

use super::casting::{CastInputs, FacingMasks, put};
use super::depth;
use super::posed_model::{PosedModel, Topology};
use super::shadows::{Choice, Found, Shadows, VolumePipelines};
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
    extracted: Extracted,
    /// Triangles of polygons, which are drawn. A polygon may be front-facing to a light while one of its triangles is
    /// back-facing.
    surface: Option<Extracted>,
    volumes: ShadowVolumes,
    /// Frame of the last encode, to draw.
    frame: Option<ShadowFrame>,
}

impl SingleCasters {
    pub(super) fn new(pipelines: &Arc<ShadowPipelines>, max_lights: usize) -> Self {
        Self { pipelines: Arc::clone(pipelines), max_lights, casters: Vec::new() }
    }
}

impl Shadows for SingleCasters {
    fn place(&mut self, gpu: &Gpu, bodies: &[PosedModel<'_>]) -> Result<(), Failure> {
        for (number, body) in bodies.iter().enumerate() {
            if self.casters.get(number).is_some_and(|caster| caster.extracted.is_of(body)) {
                continue;
            }
            let extracted = Extracted::new(gpu, &body.mesh()?, body, self.max_lights)?;
            let triangles = body.triangles()?;
            let surface = triangles.map(|mesh| Extracted::new(gpu, &mesh, body, self.max_lights)).transpose()?;
            let options = ShadowOptions { bound_counts: true, ..ShadowOptions::default() };
            let volumes = ShadowVolumes::new(&self.pipelines, &extracted.extractor, options)
                .map_err(GpuError::Volumes)
                .on(gpu)?;
            put(&mut self.casters, number, Caster { extracted, surface, volumes, frame: None });
        }
        Ok(())
    }

    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        CastInputs { bodies, camera, lights, .. }: CastInputs<'_>,
        mut timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        for (Caster { extracted, surface, volumes, frame }, body) in self.casters.iter_mut().zip(bodies) {
            let extraction = extracted.encode(encoder, body, lights, timer.as_deref_mut())?;
            if let Some(surface) = surface {
                surface.encode(encoder, body, lights, timer.as_deref_mut())?;
            }
            let encoded = volumes.encode(encoder, extraction, camera, timer.as_deref_mut());
            *frame = Some(encoded.map_err(GpuError::Volumes)?);
        }
        Ok(())
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, pipelines: &VolumePipelines, light: usize) -> Result<(), GpuError> {
        let VolumePipelines::Single(own) = pipelines else {
            return Err(pipelines.refuse(self.pipelines.counting()));
        };
        let mut frames = self.casters.iter().filter_map(|caster| caster.frame.as_ref());
        Ok(frames.try_for_each(|frame| frame.draw(pass, own, light))?)
    }

    fn facing(&self, _: &Gpu, bodies: &[PosedModel<'_>]) -> Result<Vec<FacingMasks>, GpuError> {
        let drawn = self.casters.iter().map(|caster| caster.surface.as_ref().unwrap_or(&caster.extracted));
        Ok(drawn.zip(bodies).map(|(drawn, body)| drawn.facing(body)).collect())
    }

    fn found(&self, gpu: &Gpu) -> Result<Vec<Found>, GpuError> {
        let of_file = |Caster { extracted, volumes, .. }: &Caster| {
            let (silhouettes, extraction) = extracted.found(gpu, self.max_lights)?;
            let words: Vec<u32> = gpu.read(volumes.choices())?;
            let lights = Choice::all(self.pipelines.counting(), &words, self.max_lights);
            Ok(Found { lights, silhouettes, extraction, shadow: gpu.read_first(volumes.statistics())?, is_whole: true })
        };
        self.casters.iter().map(of_file).collect()
    }

    /// All casters count into one stencil, so their bounds add up.
    fn statistics(&self, gpu: &Gpu) -> Result<ShadowStatistics, GpuError> {
        let mut all: ShadowStatistics = bytemuck::Zeroable::zeroed();
        for caster in &self.casters {
            all = depth::sum(all, gpu.read_first(caster.volumes.statistics())?);
        }
        if self.casters.len() > 1 {
            all.may_wrap = if all.count_bound > depth::MOST { self.max_lights as u32 } else { 0 };
        }
        Ok(all)
    }
}
