//! An extractor, with shadow volumes where they are wanted, for each mesh.

use rimline::gpu::{
    Extraction, Extractor, ExtractorOptions, PositionBuffer, ShadowFrame, ShadowOptions, ShadowPipelines,
    ShadowVolumes, StageTimer,
};
use rimline::{Light, Mesh, ShadowCamera};
use wgpu::BufferUsages;

use super::{Recorder, Until};
use crate::Error;
use crate::gpu::Gpu;
use crate::shapes::Shape;

/// Meshes whose positions are in world space.
pub struct Meshes<'a> {
    all: Vec<Recorded>,
    /// `None`: nothing is drawn.
    pipelines: Option<&'a ShadowPipelines>,
    pub lights: Vec<Light>,
    /// `None`: nothing is drawn.
    pub camera: Option<ShadowCamera>,
}

struct Recorded {
    positions: wgpu::Buffer,
    extractor: Extractor,
    volumes: Option<ShadowVolumes>,
    extraction: Option<Extraction>,
    frame: Option<ShadowFrame>,
}

impl<'a> Meshes<'a> {
    pub fn new(pipelines: Option<&'a ShadowPipelines>, lights: &[Light], camera: Option<ShadowCamera>) -> Self {
        Self { all: Vec::new(), pipelines, lights: lights.to_vec(), camera }
    }

    /// Adds a mesh.
    pub fn push(
        &mut self,
        gpu: &Gpu,
        options: ExtractorOptions,
        mesh: &Mesh,
        positions: &[[f32; 3]],
    ) -> Result<(), Error> {
        let extractor = Extractor::new(&gpu.pipelines, mesh, options)?;
        gpu.check()?;
        let volumes =
            |pipelines: &&ShadowPipelines| ShadowVolumes::new(pipelines, &extractor, ShadowOptions::default());
        let volumes = self.pipelines.as_ref().map(volumes).transpose()?;
        let positions = gpu.buffer(BufferUsages::STORAGE, positions);
        self.all.push(Recorded { positions, extractor, volumes, extraction: None, frame: None });
        Ok(())
    }

    /// The same with the options that are usual for these lights.
    pub fn push_all(&mut self, gpu: &Gpu, shapes: impl IntoIterator<Item = Shape>) -> Result<(), Error> {
        let options = ExtractorOptions { max_lights: self.lights.len(), ..ExtractorOptions::default() };
        shapes.into_iter().try_for_each(|shape| self.push(gpu, options, &shape.mesh()?, &shape.positions))
    }

    /// The first mesh's extractor.
    pub fn extractor(&self) -> Option<&Extractor> {
        self.all.first().map(|mesh| &mesh.extractor)
    }

    /// The number of silhouette edges of each light, of the last encode.
    pub fn silhouette_edges(&self, gpu: &Gpu) -> Result<Vec<u64>, Error> {
        let mut edges = vec![0; self.lights.len()];
        for extraction in self.all.iter().filter_map(|mesh| mesh.extraction.as_ref()) {
            let counts: Vec<u32> = gpu.read(extraction.results()?.counts)?;
            edges.iter_mut().zip(counts).for_each(|(sum, count)| *sum += u64::from(count));
        }
        Ok(edges)
    }
}

impl Recorder for Meshes<'_> {
    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        until: Until,
        mut timer: Option<&mut StageTimer>,
    ) -> Result<(), Error> {
        for Recorded { positions, extractor, volumes, extraction, frame } in &mut self.all {
            let positions = PositionBuffer { buffer: positions, offset: 0, stride: 12 };
            let found = extractor.encode_timed(encoder, positions, &self.lights, timer.as_deref_mut())?;
            if let (Until::Volumes, Some(volumes), Some(camera)) = (until, volumes, &self.camera) {
                *frame = Some(volumes.encode(encoder, &found, camera, timer.as_deref_mut())?);
            }
            *extraction = Some(found);
        }
        Ok(())
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, light: usize) -> Result<(), Error> {
        for frame in self.all.iter().filter_map(|mesh| mesh.frame.as_ref()) {
            if let Some(pipelines) = self.pipelines {
                frame.draw(pass, pipelines, light)?;
            }
        }
        Ok(())
    }
}
