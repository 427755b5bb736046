//! The casters of a frame as all ways to shadows take them, and the silhouettes of a file by itself.

use std::ops::Range;

use rimline::gpu::{Extraction, Extractor, ExtractorOptions, LightHandle, Scene, ShadowError, StageTimer};
use rimline::reference::layout::ExtractionStatistics;
use rimline::{Light, LightError, Mesh, ShadowCamera, wgpu};

use super::posed_model::{PosedModel, Topology};
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::{GpuError, On as _};

/// The casters of a frame, the viewer's camera, and the lights.
#[derive(Clone, Copy)]
pub(crate) struct CastInputs<'a> {
    pub(crate) bodies: &'a [PosedModel<'a>],
    /// Bodies that depth maps of the lights must see: `bodies`, or those that they stand in for.
    pub(crate) seen: &'a [PosedModel<'a>],
    pub(crate) camera: &'a ShadowCamera,
    pub(crate) lights: &'a [Light],
}

#[derive(Default)]
pub(crate) struct FacingMasks {
    /// Faces whose masks lie in one buffer for each batch of 32 lights.
    pub(super) runs: Vec<(Range<u32>, Vec<wgpu::Buffer>)>,
    /// The place of each face in its buffer.
    pub(super) slots: Vec<u32>,
}

/// Gives a scene these lights: their handles are in order.
pub(super) fn set_lights(
    scene: &mut Scene,
    handles: &mut Vec<LightHandle>,
    lights: &[Light],
) -> Result<(), ShadowError> {
    for (number, &light) in lights.iter().enumerate() {
        // The scene sees one light.
        let numbered = |error| match error {
            ShadowError::Light(LightError::NegativeWeight { w, .. }) => {
                LightError::NegativeWeight { index: number, w }.into()
            }
            error => error,
        };
        match handles.get(number) {
            Some(&handle) => scene.set_light(handle, light).map_err(numbered)?,
            None => handles.push(scene.add_light(light).map_err(numbered)?),
        }
    }
    Ok(())
}

/// Puts `made` in the place of what has this number, or behind the last.
pub(super) fn put<T>(list: &mut Vec<T>, number: usize, made: T) {
    match list.get_mut(number) {
        Some(old) => *old = made,
        None => list.push(made),
    }
}

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
