//! An extractor of one mesh.

use rimline::gpu::{Extraction, Extractor, ExtractorOptions, PositionBuffer, StageTimer};
use rimline::{Light, Mesh};
use wgpu::BufferUsages;

use crate::Error;
use crate::gpu::Gpu;

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

    /// The number of silhouette edges of each light, of the last encode.
    pub fn silhouette_edges(&self, gpu: &Gpu) -> Result<Vec<u64>, Error> {
        let Some(extraction) = &self.extraction else { return Ok(Vec::new()) };
        let counts: Vec<u32> = gpu.read(extraction.results()?.counts)?;
        Ok(counts.into_iter().take(self.lights.len()).map(u64::from).collect())
    }
}
