//! A mesh of a file by itself: its silhouettes, and which of its faces face the lights.

use rimline::gpu::{Extraction, Extractor, ExtractorOptions, StageTimer};
use rimline::internals::layout::ExtractionStatistics;
use rimline::{Light, Mesh, wgpu};

use super::casting::FacingMasks;
use super::posed_model::{PosedModel, Topology};
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
