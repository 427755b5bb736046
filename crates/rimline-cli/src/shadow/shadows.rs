//! What throws shadows, and what draws them: a scene of all files, or a single caster for each file with the published method.

use std::sync::Arc;

use rimline::gpu::{ReadError, ScenePipelines, ShadowDrawError, ShadowFormat, ShadowPipelines, StageTimer};
use rimline::reference::layout::ShadowStatistics;
use rimline::{Counting, Light, ShadowCamera, wgpu};

use super::found::{FacingMasks, Found};
use super::posed_model::PosedModel;
use super::published::Published;
use super::scene_shadows::SceneShadows;
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::GpuError;

/// What draws volumes into attachments of one format.
#[derive(Clone)]
pub(crate) enum VolumePipelines {
    Scene(Arc<ScenePipelines>),
    /// ZP+ as published, which scenes do not have.
    Published(Arc<ShadowPipelines>),
}

/// The casters of all files.
pub(crate) enum Shadows {
    Scene(Box<SceneShadows>),
    Published(Published),
}

impl VolumePipelines {
    pub(crate) fn new(gpu: &Gpu, format: &ShadowFormat, counting: Counting) -> Result<Self, GpuError> {
        let shared = &gpu.pipelines;
        Ok(if counting == Counting::ZpPlus2005 {
            Self::Published(Arc::new(ShadowPipelines::new(shared, format, counting)?))
        } else {
            Self::Scene(Arc::new(ScenePipelines::new(shared, format, counting)?))
        })
    }

    fn counting(&self) -> Counting {
        match self {
            Self::Scene(pipelines) => pipelines.counting(),
            Self::Published(pipelines) => pipelines.counting(),
        }
    }
}

impl Shadows {
    pub(crate) fn new(gpu: &Gpu, pipelines: &VolumePipelines, max_lights: usize) -> Result<Self, GpuError> {
        Ok(match pipelines {
            VolumePipelines::Scene(pipelines) => {
                Self::Scene(Box::new(SceneShadows::new(gpu, pipelines.counting(), max_lights)?))
            }
            VolumePipelines::Published(pipelines) => Self::Published(Published::new(pipelines, max_lights)),
        })
    }

    /// Takes the bodies with the faces that they have now. Those that are there already stay.
    pub(crate) fn place(&mut self, gpu: &Gpu, bodies: &[PosedModel<'_>]) -> Result<(), Failure> {
        match self {
            Self::Scene(scene) => scene.place(gpu, bodies),
            Self::Published(published) => published.place(gpu, bodies),
        }
    }

    /// Records extraction and choice for all lights. There are as many as before.
    pub(crate) fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        bodies: &[PosedModel<'_>],
        camera: &ShadowCamera,
        lights: &[Light],
        timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        match self {
            Self::Scene(scene) => scene.encode(encoder, camera, lights, timer),
            Self::Published(published) => published.encode(encoder, bodies, camera, lights, timer),
        }
    }

    /// Draws the volumes of a light into the stencil, as they were encoded.
    pub(crate) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &VolumePipelines,
        light: usize,
    ) -> Result<(), GpuError> {
        match (self, pipelines) {
            (Self::Scene(scene), VolumePipelines::Scene(pipelines)) => Ok(scene.draw(pass, pipelines, light)?),
            (Self::Published(published), VolumePipelines::Published(pipelines)) => {
                Ok(published.draw(pass, pipelines, light)?)
            }
            (_, pipelines) => {
                let (volumes, pipelines) = (self.counting(), pipelines.counting());
                Err(ShadowDrawError::Counting { volumes, pipelines }.into())
            }
        }
    }

    fn counting(&self) -> Counting {
        match self {
            Self::Scene(scene) => scene.counting,
            Self::Published(_) => Counting::ZpPlus2005,
        }
    }

    /// Where the facing masks of each file lie. What was encoded must have been submitted. Waits for the device.
    pub(crate) fn facing(&self, gpu: &Gpu, bodies: &[PosedModel<'_>]) -> Result<Vec<FacingMasks>, GpuError> {
        match self {
            Self::Scene(scene) => scene.facing(gpu, bodies),
            Self::Published(published) => Ok(published.facing(bodies)),
        }
    }

    /// What was found and chosen for each file. Waits for the device.
    pub(crate) fn found(&self, gpu: &Gpu) -> Result<Vec<Found>, GpuError> {
        match self {
            Self::Scene(scene) => scene.found(gpu),
            Self::Published(published) => Ok(published.found(gpu)?),
        }
    }

    /// The statistics of all files together. Waits for the device.
    pub(crate) fn statistics(&self, gpu: &Gpu) -> Result<ShadowStatistics, ReadError> {
        match self {
            Self::Scene(scene) => scene.statistics(gpu),
            Self::Published(published) => published.statistics(gpu),
        }
    }
}
