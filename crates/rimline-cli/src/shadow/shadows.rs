//! Ways to cast shadows: a scene of all files, or depth maps of the lights.

use std::sync::Arc;
use std::thread::{Builder, JoinHandle};

use rimline::gpu::depth_map::DepthMapPipelines;
use rimline::gpu::{SceneOptions, ShadowFormat, ShadowPipelines, StageTimer, StencilCounts, Use};
use rimline::internals::layout::{ExtractionStatistics, ShadowStatistics};
use rimline::internals::scene::CHOICE_WORDS;
use rimline::{Counting, Light, Origin, wgpu};

use super::casting::{CastInputs, CoveredFaces};
use super::from_depth::{DepthsFound, FromDepth};
use super::layers::BatchPipelines;
use super::light_maps::ShownDepths;
use super::posed_model::PosedModel;
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::GpuError;
use rimline_files::npz::DepthMapArrays;
use rimline_picture::FacingMasks;

pub(crate) trait Shadows {
    /// Takes the bodies with their current faces. Bodies that are there already stay.
    fn set_bodies(&mut self, bodies: &[PosedModel<'_>]) -> Result<(), Failure>;

    /// Records extraction and choice for all lights. There are as many as before.
    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: CastInputs<'_>,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError>;

    /// Draws the volumes of a light into the stencil, as they were encoded.
    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, pipelines: &VolumePipelines, light: usize) -> Result<(), GpuError>;

    /// Buffers of the facing masks of each file. Encoded commands must have been submitted. Waits for the device.
    fn facing(&self, bodies: &[PosedModel<'_>]) -> Result<Vec<FacingMasks>, GpuError>;

    /// Results and choices for each file. Waits for the device.
    fn found(&self) -> Result<Vec<Found>, GpuError>;

    /// The statistics of all files together. Waits for the device.
    fn statistics(&self) -> Result<ShadowStatistics, GpuError>;

    /// Where more may lie over each other than the stencil counts, as was encoded and submitted, looks at it for `all`
    /// lights that are drawn before bodies are placed anew. Waits for the device.
    fn count_layers(&mut self, _inputs: CastInputs<'_>, _all: &[Light]) -> Result<(), Failure> {
        Ok(())
    }

    /// Leaves out covered faces of bodies that are placed and stay. Only a scene does.
    fn leave_out(&mut self, _covered: &CoveredFaces) -> Result<(), GpuError> {
        Ok(())
    }

    /// How many covered faces the last encode left out, summed over lights.
    fn left_out(&self) -> usize {
        0
    }

    /// Results in maps of the lights, if they cast. Waits for the device.
    fn depths_found(&self) -> Result<Option<DepthsFound>, GpuError> {
        Ok(None)
    }

    /// Contents of the overlay of a light's maps, if they cast.
    fn shown_maps(&self, _light: usize) -> Option<ShownDepths<'_>> {
        None
    }

    /// The maps of a light as they were drawn, if they cast. Waits for the device.
    fn saved_maps(&self, _light: usize, _origin: Origin) -> Result<Option<DepthMapArrays>, GpuError> {
        Ok(None)
    }
}

pub(crate) struct Found {
    /// For a file of many casters, the most that any of them needs for each light.
    pub(super) lights: Vec<Choice>,
    pub(super) silhouettes: Vec<u32>,
    pub(super) extraction: ExtractionStatistics,
    pub(super) shadow: ShadowStatistics,
    /// Whether the bounds and overflows of `shadow` are the file's own. With several files they are known for all of
    /// them together.
    pub(super) is_whole: bool,
}

/// The faces that cast for a light and how they are counted, in words of the report.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Choice {
    pub(super) casting: &'static str,
    pub(super) counting: &'static str,
}

impl Choice {
    pub(super) const NOTHING: &'static str = "nothing";
    pub(super) const EVERY: &'static str = "every";

    /// The choices for so many lights, from the words of each 32.
    pub(super) fn all(counting: Counting, words: &[u32], lights: usize) -> Vec<Self> {
        let of_light = |light: usize| {
            let word = |kind| words.get(CHOICE_WORDS * (light / 32) + kind).copied().unwrap_or(0);
            let [casts, every, near] = [0, 1, 2].map(|kind| word(kind) >> (light % 32) & 1 != 0);
            let counting = match (counting, near) {
                _ if !casts => "z-pass",
                (Counting::ZpPlus2005, true) => "zp+paper",
                (Counting::ZpPlus2005, false) | (Counting::ZFail, _) => "z-fail",
                (_, true) => "zp+",
                (_, false) => "z-pass",
            };
            let casting = match (casts, every) {
                (false, _) => Self::NOTHING,
                (true, false) => "averted",
                (true, true) => Self::EVERY,
            };
            Self { casting, counting }
        };
        (0..lights).map(of_light).collect()
    }
}

/// The options of scenes, but for the number of lights.
pub(super) fn scene_options(counting: Counting) -> SceneOptions {
    let stencil = StencilCounts { bound_counts: true, ..StencilCounts::default() };
    SceneOptions { counting, stencil, ..SceneOptions::default() }
}

#[derive(Clone, Debug)]
pub(crate) struct ShadowMethod {
    counting: Counting,
    /// Maps of the lights cast instead of meshes.
    pub(super) from_depth: Option<FromDepth>,
}

impl ShadowMethod {
    pub(crate) fn new(counting: Counting, from_depth: Option<FromDepth>) -> Self {
        Self { counting, from_depth }
    }

    /// Begins to make the pipelines of a scene, if there will be one.
    pub(crate) fn compile(&self, gpu: &Gpu) -> Compiling {
        if self.from_depth.is_some() {
            return Compiling(None);
        }
        let (pipelines, options) = (gpu.pipelines.clone(), scene_options(self.counting));
        // A refusal of the device is told where the pipeline is needed, and so is a thread that cannot be started.
        let make = move || _ = pipelines.warm_up(&[Use::SceneShadows(&options)]);
        Compiling(Builder::new().name("compiling".into()).spawn(make).ok())
    }
}

/// A thread that makes pipelines. Dropping it waits for it: a process must not end while a driver compiles.
pub(crate) struct Compiling(Option<JoinHandle<()>>);

impl Drop for Compiling {
    fn drop(&mut self) {
        // Pipelines that it could not make are made where they are needed.
        let _ = self.0.take().map(JoinHandle::join);
    }
}

/// Pipelines that draw volumes into attachments of one format.
#[derive(Clone)]
pub(crate) enum VolumePipelines {
    Scene(Arc<ShadowPipelines>, BatchPipelines),
    /// Maps of the lights cast.
    Depth(Arc<DepthMapPipelines>, FromDepth),
}

impl VolumePipelines {
    pub(crate) fn new(gpu: &Gpu, format: &ShadowFormat, method: &ShadowMethod) -> Result<Self, GpuError> {
        let (shared, counting) = (&gpu.pipelines, method.counting);
        if let Some(from) = &method.from_depth {
            // The bit of the stencil that maps turn round. Each light has a stencil of its own.
            return Ok(Self::Depth(Arc::new(DepthMapPipelines::new(shared, format, 0)?), from.clone()));
        }
        let batches = BatchPipelines::new(shared, format, counting);
        Ok(Self::Scene(Arc::new(ShadowPipelines::new(shared, format, counting)?), batches))
    }
}
