//! Casters of shadows, and pipelines that draw them: a scene of all files, or a single caster for each file.

use std::sync::Arc;

use rimline::gpu::{
    DepthMapPipelines, DeviceError, ScenePipelines, ShadowError, ShadowFormat, ShadowPipelines, StageTimer, Use,
};
use rimline::reference::layout::ShadowStatistics;
use rimline::{Counting, Light, Origin, wgpu};

use super::cast_inputs::{CastInputs, parity};
use super::covered::CoveredFaces;
use super::depth_shadows::DepthShadows;
use super::found::{FacingMasks, Found};
use super::from_depth::{DepthsFound, FromDepth};
use super::layers::BatchPipelines;
use super::posed_model::PosedModel;
use super::scene_shadows::{self, SceneShadows};
use super::shown_maps::ShownDepths;
use super::single_casters::SingleCasters;
use crate::compiling::Compiling;
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::GpuError;
use crate::input::Input;
use crate::npz::DepthMapArrays;

/// Counting that is named for maps, which count no volumes of meshes.
const NO_COUNTING: Counting = Counting::Auto;

/// The bit of the stencil that maps turn round. Each light has a stencil of its own.
const PARITY_BIT: u32 = 0;

/// How shadows are counted.
#[derive(Clone, Debug)]
pub(crate) struct ShadowMethod {
    pub(crate) counting: Counting,
    /// Each file is a caster by itself.
    is_single: bool,
    /// Maps of the lights cast instead of meshes.
    from_depth: Option<FromDepth>,
}

impl ShadowMethod {
    /// Whether maps of the lights cast instead of meshes.
    pub(super) fn has_depth_maps(&self) -> bool {
        self.from_depth.is_some()
    }

    /// Scenes have neither ZP+ as published nor polygons.
    pub(crate) fn new(counting: Counting, inputs: &[Input]) -> Self {
        let is_single = counting == Counting::ZpPlus2005 || inputs.iter().any(|input| input.polygons().is_some());
        Self { counting, is_single, from_depth: None }
    }

    /// Begins to make the pipelines of a scene, if there will be one.
    pub(crate) fn compile(&self, gpu: &Gpu) -> Compiling {
        if self.is_single || self.has_depth_maps() {
            return Compiling::default();
        }
        let (pipelines, options) = (gpu.pipelines.clone(), scene_shadows::options(self.counting));
        // A refusal of the device is told where the pipeline is needed.
        Compiling::begin(move || _ = pipelines.warm_up(&[Use::SceneShadows(&options)]))
    }

    /// The same, with maps of the lights that cast instead of meshes.
    pub(crate) fn with_depth_maps(self, from_depth: Option<FromDepth>) -> Self {
        Self { from_depth, ..self }
    }
}

/// Pipelines that draw volumes into attachments of one format.
#[derive(Clone)]
pub(crate) enum VolumePipelines {
    Scene(Arc<ScenePipelines>, BatchPipelines),
    Single(Arc<ShadowPipelines>),
    /// Maps of the lights cast.
    Depth(Arc<DepthMapPipelines>, FromDepth),
}

/// The casters of all files.
pub(crate) enum Shadows {
    Scene(Box<SceneShadows>),
    Single(SingleCasters),
    Depth(Box<DepthShadows>),
}

impl VolumePipelines {
    pub(crate) fn new(gpu: &Gpu, format: &ShadowFormat, method: &ShadowMethod) -> Result<Self, GpuError> {
        let (shared, counting) = (&gpu.pipelines, method.counting);
        if let Some(from) = &method.from_depth {
            return Ok(Self::Depth(Arc::new(DepthMapPipelines::new(shared, format, PARITY_BIT)?), from.clone()));
        }
        Ok(if method.is_single {
            Self::Single(Arc::new(ShadowPipelines::new(shared, format, counting)?))
        } else {
            let batches = BatchPipelines::new(shared, format, counting);
            Self::Scene(Arc::new(ScenePipelines::new(shared, format, counting)?), batches)
        })
    }

    fn counting(&self) -> Counting {
        match self {
            Self::Scene(pipelines, _) => pipelines.counting(),
            Self::Single(pipelines) => pipelines.counting(),
            Self::Depth(..) => NO_COUNTING,
        }
    }

    /// Whether there are volumes of meshes.
    pub(super) fn has_mesh_volumes(&self) -> bool {
        !matches!(self, Self::Depth(..))
    }
}

impl Shadows {
    pub(crate) fn new(gpu: &Gpu, pipelines: &VolumePipelines, max_lights: usize) -> Result<Self, GpuError> {
        Ok(match pipelines {
            VolumePipelines::Scene(pipelines, _) => {
                Self::Scene(Box::new(SceneShadows::new(gpu, pipelines.counting(), max_lights)?))
            }
            VolumePipelines::Single(pipelines) => Self::Single(SingleCasters::new(pipelines, max_lights)),
            VolumePipelines::Depth(maps, from) => Self::Depth(Box::new(DepthShadows::new(maps, from, max_lights))),
        })
    }

    /// Takes the bodies with their current faces. Bodies that are there already stay.
    pub(crate) fn place(&mut self, gpu: &Gpu, bodies: &[PosedModel<'_>]) -> Result<(), Failure> {
        match self {
            Self::Scene(scene) => scene.place(gpu, bodies),
            Self::Single(single) => single.place(gpu, bodies),
            Self::Depth(maps) => maps.place(gpu, bodies),
        }
    }

    /// Leaves out covered faces of bodies that are placed and stay. Single casters leave out none.
    pub(super) fn leave_out(&mut self, covered: &CoveredFaces) -> Result<(), GpuError> {
        match self {
            Self::Scene(scene) => scene.leave_out(covered),
            Self::Single(_) | Self::Depth(..) => Ok(()),
        }
    }

    /// How many covered faces the last encode left out, summed over lights.
    pub(super) fn left_out(&self) -> usize {
        match self {
            Self::Scene(scene) => scene.frame().map_or(0, |frame| frame.hidden().faces),
            Self::Single(_) | Self::Depth(..) => 0,
        }
    }

    /// Records extraction and choice for all lights. There are as many as before.
    pub(crate) fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: CastInputs<'_>,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        match self {
            Self::Scene(scene) => scene.encode(encoder, inputs, timer),
            Self::Single(single) => single.encode(encoder, inputs, timer),
            Self::Depth(maps) => maps.encode(encoder, inputs, timer),
        }
    }

    /// Where more may lie over each other than the stencil counts, as was encoded and submitted, looks at it for `all` lights that
    /// are drawn before bodies are placed anew. Waits for the device.
    pub(crate) fn count_layers(&mut self, inputs: CastInputs<'_>, all: &[Light]) -> Result<(), Failure> {
        match self {
            Self::Scene(scene) => scene.count_layers(inputs, all),
            Self::Single(_) | Self::Depth(..) => Ok(()),
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
            (Self::Scene(scene), VolumePipelines::Scene(pipelines, batches)) => {
                scene.draw(pass, (pipelines, batches), light)
            }
            (Self::Single(single), VolumePipelines::Single(pipelines)) => Ok(single.draw(pass, pipelines, light)?),
            (Self::Depth(maps), VolumePipelines::Depth(pipelines, _)) => maps.draw(pass, pipelines, light),
            (_, pipelines) => {
                let (volumes, pipelines) = (self.counting(), pipelines.counting());
                Err(ShadowError::OtherCounting { volumes, pipelines }.into())
            }
        }
    }

    fn counting(&self) -> Counting {
        match self {
            Self::Scene(scene) => scene.counting,
            Self::Single(single) => single.counting(),
            Self::Depth(_) => NO_COUNTING,
        }
    }

    /// Results in maps, if maps cast. Waits for the device.
    pub(super) fn depth_found(&self, gpu: &Gpu) -> Result<Option<DepthsFound>, DeviceError> {
        match self {
            Self::Scene(_) | Self::Single(_) => Ok(None),
            Self::Depth(maps) => maps.found(gpu).map(Some),
        }
    }

    /// Contents of the overlay of a light's maps, if maps cast.
    pub(super) fn shown_depths(&self, light: usize) -> Option<ShownDepths<'_>> {
        match self {
            Self::Scene(_) | Self::Single(_) => None,
            Self::Depth(maps) => maps.shown(light),
        }
    }

    /// The maps of a light as they were drawn, if they cast. Waits for the device.
    pub(super) fn saved_maps(
        &self,
        gpu: &Gpu,
        light: usize,
        origin: Origin,
    ) -> Result<Option<DepthMapArrays>, GpuError> {
        match self {
            Self::Scene(_) | Self::Single(_) => Ok(None),
            Self::Depth(maps) => maps.saved(gpu, light, origin),
        }
    }

    /// Buffers of the facing masks of each file. Encoded commands must have been submitted. Waits for the device.
    pub(crate) fn facing(&self, gpu: &Gpu, bodies: &[PosedModel<'_>]) -> Result<Vec<FacingMasks>, GpuError> {
        match self {
            Self::Scene(scene) => scene.facing(gpu, bodies),
            Self::Single(single) => Ok(single.facing(bodies)),
            Self::Depth(maps) => Ok(maps.facing(bodies)),
        }
    }

    /// Results and choices for each file. Waits for the device.
    pub(crate) fn found(&self, gpu: &Gpu) -> Result<Vec<Found>, GpuError> {
        match self {
            Self::Scene(scene) => scene.found(gpu),
            Self::Single(single) => Ok(single.found(gpu)?),
            Self::Depth(maps) => Ok(maps.found_of_files(gpu)?),
        }
    }

    /// The statistics of all files together. Waits for the device.
    pub(crate) fn statistics(&self, gpu: &Gpu) -> Result<ShadowStatistics, DeviceError> {
        match self {
            Self::Scene(scene) => scene.statistics(gpu),
            Self::Single(single) => single.statistics(gpu),
            Self::Depth(..) => Ok(parity()),
        }
    }
}
