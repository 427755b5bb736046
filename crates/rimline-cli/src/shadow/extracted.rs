//! The extraction of a single file's mesh.

use rimline::gpu::{DeviceError, Extraction, Extractor, ExtractorOptions, StageTimer, read_back_vec};
use rimline::reference::layout::ExtractionStatistics;
use rimline::{Light, Mesh, wgpu};

use super::found::{FacingMasks, FacingRun};
use super::posed_model::{PosedModel, Topology};
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::GpuError;

/// A file's extractor, and what it extracted last.
pub(super) struct Extracted {
    pub(super) extractor: Extractor,
    pub(super) extraction: Option<Extraction>,
    /// Topologies that its mesh was made of.
    topologies: Vec<Topology>,
}

impl Extracted {
    pub(super) fn new(gpu: &Gpu, body: &PosedModel<'_>, max_lights: usize) -> Result<Self, Failure> {
        Self::of_mesh(gpu, &body.mesh()?, body, max_lights)
    }

    /// With some of the file's faces, over its vertices.
    pub(super) fn of_mesh(gpu: &Gpu, mesh: &Mesh, body: &PosedModel<'_>, max_lights: usize) -> Result<Self, Failure> {
        let options = ExtractorOptions { max_lights, ..ExtractorOptions::default() };
        let extractor = Extractor::new(&gpu.pipelines, mesh, options).map_err(|error| GpuError::from(error).on(gpu))?;
        Ok(Self { extractor, extraction: None, topologies: body.topologies.clone() })
    }

    /// Whether it is of the faces that the body has now: an instance that is mirrored turns its faces.
    pub(super) fn is_of(&self, body: &PosedModel<'_>) -> bool {
        self.topologies == body.topologies
    }

    /// Records the extraction.
    pub(super) fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        body: &PosedModel<'_>,
        lights: &[Light],
        timer: Option<&mut StageTimer>,
    ) -> Result<&Extraction, GpuError> {
        let extraction = self.extractor.encode(encoder, body.positions.buffer(), lights, timer)?;
        Ok(self.extraction.insert(extraction))
    }

    /// Where the facing masks of the body's faces lie.
    pub(super) fn facing(&self, body: &PosedModel<'_>) -> FacingMasks {
        let faces = 0..body.faces.len() as u32;
        let facing = self.extractor.results().facing.to_vec();
        FacingMasks { slots: faces.clone().collect(), runs: vec![FacingRun { faces, facing }] }
    }

    /// The silhouette edges of each light, and the statistics. Waits for the device.
    pub(super) fn found(&self, gpu: &Gpu, lights: usize) -> Result<(Vec<u32>, ExtractionStatistics), DeviceError> {
        let results = self.extractor.results();
        let mut silhouettes: Vec<u32> = read_back_vec(&gpu.device, &gpu.queue, results.counts)?;
        silhouettes.truncate(lights);
        let statistics: Vec<ExtractionStatistics> = read_back_vec(&gpu.device, &gpu.queue, results.statistics)?;
        Ok((silhouettes, statistics.first().copied().unwrap_or(bytemuck::Zeroable::zeroed())))
    }
}
