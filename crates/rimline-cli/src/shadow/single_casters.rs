//! Each file as one caster. ZP+ as published in 2005 and polygons need this: scenes have neither.

use std::sync::Arc;

use rimline::gpu::{
    DeviceError, ShadowError, ShadowFrame, ShadowOptions, ShadowPipelines, ShadowVolumes, StageTimer, read_back_vec,
};
use rimline::reference::cpu;
use rimline::reference::layout::{SeenLight, ShadowStatistics};
use rimline::{Counting, wgpu};

use super::cast_inputs::{CastInputs, put};
use super::counts;
use super::extracted::Extracted;
use super::found::{FacingMasks, Found};
use super::posed_model::PosedModel;
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::GpuError;

pub(crate) struct SingleCasters {
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

    pub(super) fn counting(&self) -> Counting {
        self.pipelines.counting()
    }

    pub(super) fn place(&mut self, gpu: &Gpu, bodies: &[PosedModel<'_>]) -> Result<(), Failure> {
        for (number, body) in bodies.iter().enumerate() {
            if self.casters.get(number).is_some_and(|caster| caster.extracted.is_of(body)) {
                continue;
            }
            let extracted = Extracted::new(gpu, body, self.max_lights)?;
            let surface = match body.triangles()? {
                Some(triangles) => Some(Extracted::of_mesh(gpu, &triangles, body, self.max_lights)?),
                None => None,
            };
            let options = ShadowOptions { bound_counts: true, ..ShadowOptions::default() };
            let volumes = ShadowVolumes::new(&self.pipelines, &extracted.extractor, options)
                .map_err(|error| GpuError::Volumes(error).on(gpu))?;
            let caster = Caster { extracted, surface, volumes, frame: None };
            put(&mut self.casters, number, caster);
        }
        Ok(())
    }

    pub(super) fn encode(
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

    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &ShadowPipelines,
        light: usize,
    ) -> Result<(), ShadowError> {
        self.casters
            .iter()
            .filter_map(|caster| caster.frame.as_ref())
            .try_for_each(|frame| frame.draw(pass, pipelines, light))
    }

    pub(super) fn facing(&self, bodies: &[PosedModel<'_>]) -> Vec<FacingMasks> {
        let of_file = |(caster, body): (&Caster, &PosedModel<'_>)| {
            caster.surface.as_ref().unwrap_or(&caster.extracted).facing(body)
        };
        self.casters.iter().zip(bodies).map(of_file).collect()
    }

    pub(super) fn found(&self, gpu: &Gpu) -> Result<Vec<Found>, DeviceError> {
        let (device, queue) = (&gpu.device, &gpu.queue);
        let of_file = |Caster { extracted, volumes, .. }: &Caster| {
            let (silhouettes, extraction) = extracted.found(gpu, self.max_lights)?;
            let mut seen: Vec<SeenLight> = read_back_vec(device, queue, volumes.seen())?;
            seen.truncate(self.max_lights);
            let words: Vec<u32> = read_back_vec(device, queue, volumes.choices())?;
            Ok(Found {
                lights: cpu::chosen(&volumes.shape(), &seen, &words),
                silhouettes,
                extraction,
                shadow: counts::read(gpu, volumes.statistics())?,
                is_whole: true,
            })
        };
        self.casters.iter().map(of_file).collect()
    }

    /// All casters count into one stencil, so their bounds add up.
    pub(super) fn statistics(&self, gpu: &Gpu) -> Result<ShadowStatistics, DeviceError> {
        let mut all: ShadowStatistics = bytemuck::Zeroable::zeroed();
        for caster in &self.casters {
            all = counts::sum(all, counts::read(gpu, caster.volumes.statistics())?);
        }
        if self.casters.len() > 1 {
            all.may_wrap = if all.count_bound > counts::MOST { self.max_lights as u32 } else { 0 };
        }
        Ok(all)
    }
}
