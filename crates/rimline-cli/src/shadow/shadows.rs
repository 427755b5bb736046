//! What throws shadows, and what draws them: a scene of all files, or a single caster for each file.

use std::sync::Arc;

use rimline::gpu::{ReadError, ScenePipelines, ShadowDrawError, ShadowFormat, ShadowPipelines, StageTimer};
use rimline::reference::layout::ShadowStatistics;
use rimline::{Counting, Light, ShadowCamera, wgpu};

use super::covered::CoveredFaces;
use super::found::{FacingMasks, Found};
use super::posed_model::PosedModel;
use super::scene_shadows::SceneShadows;
use super::single_casters::SingleCasters;
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::GpuError;

/// How shadows are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ShadowMethod {
    pub(crate) counting: Counting,
    /// Each file is a caster by itself.
    is_single: bool,
}

impl ShadowMethod {
    /// Scenes have neither ZP+ as published nor polygons.
    pub(crate) fn new(counting: Counting, bodies: &[PosedModel<'_>]) -> Self {
        let is_single = counting == Counting::ZpPlus2005 || bodies.iter().any(PosedModel::has_polygons);
        Self { counting, is_single }
    }
}

/// What draws volumes into attachments of one format.
#[derive(Clone)]
pub(crate) enum VolumePipelines {
    Scene(Arc<ScenePipelines>),
    Single(Arc<ShadowPipelines>),
}

/// The casters of all files.
pub(crate) enum Shadows {
    Scene(Box<SceneShadows>),
    Single(SingleCasters),
}

impl VolumePipelines {
    pub(crate) fn new(gpu: &Gpu, format: &ShadowFormat, method: ShadowMethod) -> Result<Self, GpuError> {
        let (shared, counting) = (&gpu.pipelines, method.counting);
        Ok(if method.is_single {
            Self::Single(Arc::new(ShadowPipelines::new(shared, format, counting)?))
        } else {
            Self::Scene(Arc::new(ScenePipelines::new(shared, format, counting)?))
        })
    }

    fn counting(&self) -> Counting {
        match self {
            Self::Scene(pipelines) => pipelines.counting(),
            Self::Single(pipelines) => pipelines.counting(),
        }
    }
}

impl Shadows {
    pub(crate) fn new(gpu: &Gpu, pipelines: &VolumePipelines, max_lights: usize) -> Result<Self, GpuError> {
        Ok(match pipelines {
            VolumePipelines::Scene(pipelines) => {
                Self::Scene(Box::new(SceneShadows::new(gpu, pipelines.counting(), max_lights)?))
            }
            VolumePipelines::Single(pipelines) => Self::Single(SingleCasters::new(pipelines, max_lights)),
        })
    }

    /// Takes the bodies with the faces that they have now. Those that are there already stay.
    pub(crate) fn place(&mut self, gpu: &Gpu, bodies: &[PosedModel<'_>]) -> Result<(), Failure> {
        match self {
            Self::Scene(scene) => scene.place(gpu, bodies),
            Self::Single(single) => single.place(gpu, bodies),
        }
    }

    /// Leaves out covered faces of bodies that are placed and stay. Single casters leave out none.
    pub(super) fn leave_out(&mut self, covered: &CoveredFaces) -> Result<(), GpuError> {
        match self {
            Self::Scene(scene) => scene.leave_out(covered),
            Self::Single(_) => Ok(()),
        }
    }

    /// How many covered faces the last encode left out, summed over lights.
    pub(super) fn left_out(&self) -> usize {
        match self {
            Self::Scene(scene) => scene.frame().map_or(0, |frame| frame.hidden().faces),
            Self::Single(_) => 0,
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
            Self::Single(single) => single.encode(encoder, bodies, camera, lights, timer),
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
            (Self::Single(single), VolumePipelines::Single(pipelines)) => Ok(single.draw(pass, pipelines, light)?),
            (_, pipelines) => {
                let (volumes, pipelines) = (self.counting(), pipelines.counting());
                Err(ShadowDrawError::Counting { volumes, pipelines }.into())
            }
        }
    }

    fn counting(&self) -> Counting {
        match self {
            Self::Scene(scene) => scene.counting,
            Self::Single(single) => single.counting(),
        }
    }

    /// Where the facing masks of each file lie. What was encoded must have been submitted. Waits for the device.
    pub(crate) fn facing(&self, gpu: &Gpu, bodies: &[PosedModel<'_>]) -> Result<Vec<FacingMasks>, GpuError> {
        match self {
            Self::Scene(scene) => scene.facing(gpu, bodies),
            Self::Single(single) => Ok(single.facing(bodies)),
        }
    }

    /// What was found and chosen for each file. Waits for the device.
    pub(crate) fn found(&self, gpu: &Gpu) -> Result<Vec<Found>, GpuError> {
        match self {
            Self::Scene(scene) => scene.found(gpu),
            Self::Single(single) => Ok(single.found(gpu)?),
        }
    }

    /// The statistics of all files together. Waits for the device.
    pub(crate) fn statistics(&self, gpu: &Gpu) -> Result<ShadowStatistics, ReadError> {
        match self {
            Self::Scene(scene) => scene.statistics(gpu),
            Self::Single(single) => single.statistics(gpu),
        }
    }
}
