//! For each mesh an extractor, or a scene of its own where volumes are wanted.

use rimline::gpu::{Extraction, Extractor, ExtractorOptions, PositionBuffer, SceneFrame, ShadowPipelines, StageTimer};
use rimline::{Light, Mesh, ShadowCamera};
use wgpu::BufferUsages;

use super::one_caster::{OneCaster, OneCasterOptions, OneFrame};
use super::{Recorder, Until};
use crate::Error;
use crate::gpu::Gpu;
use crate::shapes::Shape;

/// Meshes whose positions are in world space.
pub struct Meshes<'a> {
    all: Vec<(wgpu::Buffer, Recorded)>,
    /// `None`: nothing is drawn.
    pipelines: Option<&'a ShadowPipelines>,
    pub lights: Vec<Light>,
    /// `None`: nothing is drawn.
    pub camera: Option<ShadowCamera>,
}

enum Recorded {
    Alone(Box<Extractor>, Option<Extraction>),
    Casting(Box<OneCaster>, Option<OneFrame>),
}

impl<'a> Meshes<'a> {
    pub fn new(pipelines: Option<&'a ShadowPipelines>, lights: &[Light], camera: Option<ShadowCamera>) -> Self {
        Self { all: Vec::new(), pipelines, lights: lights.to_vec(), camera }
    }

    /// Adds a mesh. `options` are those of an extractor, where nothing is drawn.
    pub fn push(
        &mut self,
        gpu: &Gpu,
        options: ExtractorOptions,
        mesh: &Mesh,
        positions: &[[f32; 3]],
    ) -> Result<(), Error> {
        let recorded = match self.pipelines {
            None => Recorded::Alone(Box::new(Extractor::new(&gpu.pipelines, mesh, options)?), None),
            Some(pipelines) => {
                let max_lights = options.max_lights;
                let options =
                    OneCasterOptions { counting: pipelines.counting(), max_lights, ..OneCasterOptions::default() };
                Recorded::Casting(Box::new(OneCaster::new(&gpu.pipelines, &gpu.queue, mesh, &options)?), None)
            }
        };
        gpu.check()?;
        self.all.push((gpu.buffer(BufferUsages::STORAGE, positions), recorded));
        Ok(())
    }

    /// The same with the options that are usual for these lights.
    pub fn push_all(&mut self, gpu: &Gpu, shapes: impl IntoIterator<Item = Shape>) -> Result<(), Error> {
        let options = ExtractorOptions { max_lights: self.lights.len(), ..ExtractorOptions::default() };
        shapes.into_iter().try_for_each(|shape| self.push(gpu, options, &shape.mesh()?, &shape.positions))
    }

    /// The first mesh's extractor.
    pub fn extractor(&self) -> Option<&Extractor> {
        match self.all.first() {
            Some((_, Recorded::Alone(extractor, _))) => Some(extractor),
            _ => None,
        }
    }

    /// The number of silhouette edges of each light, of the last encode.
    pub fn silhouette_edges(&self, gpu: &Gpu) -> Result<Vec<u64>, Error> {
        let mut edges = vec![0; self.lights.len()];
        for (_, recorded) in &self.all {
            let counts = match recorded {
                Recorded::Alone(_, Some(extraction)) => gpu.read(extraction.results()?.counts)?,
                Recorded::Casting(_, Some(frame)) => counts(gpu, &frame.frame)?,
                _ => Vec::new(),
            };
            edges.iter_mut().zip(counts).for_each(|(sum, count): (_, u32)| *sum += u64::from(count));
        }
        Ok(edges)
    }
}

/// The silhouette edges of each light of a scene whose only caster has all of them.
fn counts(gpu: &Gpu, frame: &SceneFrame) -> Result<Vec<u32>, Error> {
    let mut all = Vec::new();
    for group in frame.results()?.groups {
        let words: Vec<u32> = gpu.read(group.lists)?;
        all.extend_from_slice(&words[..32]);
    }
    Ok(all)
}

impl Recorder for Meshes<'_> {
    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        until: Until,
        mut timer: Option<&mut StageTimer>,
    ) -> Result<(), Error> {
        for (positions, recorded) in &mut self.all {
            let positions = PositionBuffer { buffer: positions, offset: 0, stride: 12 };
            let timer = timer.as_deref_mut();
            match recorded {
                Recorded::Alone(extractor, found) => {
                    *found = Some(extractor.encode_timed(encoder, positions, &self.lights, timer)?);
                }
                Recorded::Casting(caster, frame) => {
                    let camera = self.camera.as_ref().filter(|_| until == Until::Volumes);
                    *frame = Some(caster.encode(encoder, positions, &self.lights, camera, timer)?);
                }
            }
        }
        Ok(())
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, light: usize) -> Result<(), Error> {
        for (_, recorded) in &self.all {
            if let (Recorded::Casting(_, Some(frame)), Some(pipelines)) = (recorded, self.pipelines) {
                frame.draw(pass, pipelines, light)?;
            }
        }
        Ok(())
    }
}
