//! Ways to cast shadows: a scene of all files, or depth maps of the lights.

use std::sync::Arc;
use std::thread::{Builder, JoinHandle};

use rimline::gpu::depth_map::DepthMapPipelines;
use rimline::gpu::{
    ExtractionStatistics, SceneOptions, ShadowFormat, ShadowPipelines, ShadowStatistics, StageTimer, StencilCounts, Use,
};
use rimline::internals::scene::CHOICE_WORDS;
use rimline::wgpu::{self, TextureFormat};
use rimline::{Counting, Light, Origin};
use rimline_files::npz::DepthMapArrays;
use rimline_picture::{FacingMasks, Resources, depth_format};

use super::casting::{CastInputs, Occlusion, PosedModel};
use super::from_depth::{DepthsFound, FromDepth};
use super::layers::BatchPipelines;
use super::light_maps::ShownDepths;
use crate::device::{Gpu, GpuError};
use crate::failure::Failure;
use crate::output::note;

pub(crate) trait Shadows {
    /// Takes the bodies with their current faces. Later calls have the same bodies, in the same order, with the same buffers.
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

    /// Leaves out occluded faces of bodies that are placed and stay. Only a scene does.
    fn leave_out(&mut self, _occlusion: &Occlusion) -> Result<(), GpuError> {
        Ok(())
    }

    /// How many occluded faces the last encode left out, summed over lights.
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
                (true, false) => "back-facing",
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
    pub(crate) counting: Counting,
    /// Maps of the lights cast instead of meshes.
    pub(crate) from_depth: Option<FromDepth>,
}

impl ShadowMethod {
    /// Begins to make the pipelines of a scene, if there will be one.
    pub(crate) fn compile(&self, gpu: &Gpu) -> Compiling {
        if self.from_depth.is_some() {
            return Compiling(None);
        }
        let (pipelines, options) = (gpu.pipelines.clone(), scene_options(self.counting));
        // A refusal of the device is reported where the pipeline is needed, and so is a thread that cannot be started.
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
pub(crate) enum VolumePipelines {
    Scene(Arc<ShadowPipelines>, BatchPipelines),
    /// Maps of the lights cast.
    Depth(Arc<DepthMapPipelines>, FromDepth),
}

pub(crate) struct RenderResources<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) shared: Resources,
    pub(super) size: [u32; 2],
}

impl<'a> RenderResources<'a> {
    /// For pictures of this size, with so many samples of lights.
    pub(crate) fn new(gpu: &'a Gpu, size: [u32; 2], samples: usize) -> Self {
        Self { gpu, shared: Resources::new((&gpu.device, &gpu.queue), samples), size }
    }

    /// Pipelines of volumes for so many samples a pixel.
    pub(super) fn pipelines(&self, samples: u32, method: &ShadowMethod) -> Result<VolumePipelines, GpuError> {
        let (shared, counting) = (&self.gpu.pipelines, method.counting);
        let format = ShadowFormat {
            depth_stencil: depth_format(&self.gpu.device),
            samples,
            colors: Vec::new(),
            trim: method.from_depth.is_none() && self.gpu.clips_wrongly(),
            ..ShadowFormat::default()
        };
        if let Some(from) = &method.from_depth {
            // The bit of the stencil that maps turn round. Each light has a stencil of its own.
            let pipelines = Arc::new(DepthMapPipelines::new(shared, &format, 0)?);
            return Ok(VolumePipelines::Depth(pipelines, from.clone()));
        }
        let batches = BatchPipelines::new(shared, &format, counting);
        Ok(VolumePipelines::Scene(Arc::new(ShadowPipelines::new(shared, &format, counting)?), batches))
    }
}

/// The nearest near plane with which 24 bits tell distances half a pixel apart, where `pixel` is the size of one at a
/// distance of 1: two numbers next to each other are `distance² / (2²⁴ near)` apart.
fn nearest(farthest: f32, pixel: f32) -> f32 {
    farthest / (16_777_216.0 * 0.5 * pixel)
}

/// A warning, if depth in this format is too coarse for the farthest surface with a shadow.
pub(super) fn too_coarse(format: TextureFormat, near: f32, farthest: f32, pixel: f32) -> Option<String> {
    let nearest = nearest(farthest, pixel);
    (format == TextureFormat::Depth24PlusStencil8 && near < nearest).then(|| {
        format!(
            "shadows {farthest} away may be wrong: depth has 24 bits on this device, too few for a near \
             plane at {near}. Set --near to {nearest} or more, or choose a device with DEPTH32FLOAT_STENCIL8 \
             (`rimline devices` says which have it)"
        )
    })
}

/// Tells the user where shadows may be wrong. Counts may wrap: no count exceeds `count_bound`, and `may_wrap` counts
/// lights, or samples, whose counts may exceed what the stencil holds. All casters count into one stencil. Pieces of
/// twisted polygons may have no room.
pub(crate) fn warn_of_limits(found: ShadowStatistics) {
    let ShadowStatistics { count_bound, may_wrap, .. } = found;
    if let Some(warning) = too_many_pieces(&found) {
        note(&warning);
    }
    if may_wrap > 0 {
        note(&format!(
            "warning: shadows may be wrong where 256 or more faces overlap as seen from the eye: the stencil \
             has 8 bits, and the models may overlap up to {count_bound} times. Draw fewer files at once, or \
             models with fewer layers; `rimline query` counts without this limit"
        ));
    }
}

/// A warning, if pieces of twisted polygons had no room.
fn too_many_pieces(&ShadowStatistics { lost_pieces, most_pieces, .. }: &ShadowStatistics) -> Option<String> {
    (lost_pieces > 0).then(|| {
        format!(
            "warning: shadows of twisted polygons are wrong: those of a file have {most_pieces} pieces for a \
             light, and a buffer of this device has no room for them. Use fewer lights, cut the file into \
             several, or leave out --polygons"
        )
    })
}

/// A statistic of two, number by number.
pub(crate) fn each<T: bytemuck::Pod>(mut one: T, other: T, of: fn(u32, u32) -> u32) -> T {
    let numbers = bytemuck::cast_slice_mut::<T, u32>(std::slice::from_mut(&mut one)).iter_mut();
    numbers.zip(bytemuck::cast_slice::<T, u32>(&[other])).for_each(|(number, other)| *number = of(*number, *other));
    one
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    #[test]
    fn coarse_depth_is_reported_with_what_to_set() {
        let bits = TextureFormat::Depth24PlusStencil8;
        let warning = |bits, near| too_coarse(bits, near, 10.0, 1.0 / 1024.0);
        // 10 · 2¹⁰ · 2 / 2²⁴.
        let least = 10.0 / 8192.0;
        assert_eq!(nearest(10.0, 1.0 / 1024.0), least);
        assert_eq!(warning(bits, least), None);
        let coarse = warning(bits, 1e-5).expect("10⁻⁶ of the distance is too near");
        let expected = "shadows 10 away may be wrong: depth has 24 bits on this device, too few for a near plane at 0.00001. Set \
                        --near to 0.0012207031 or more, or choose a device with DEPTH32FLOAT_STENCIL8 (`rimline devices` says \
                        which have it)";
        assert_eq!(coarse, expected);
        assert_eq!(warning(TextureFormat::Depth32FloatStencil8, 1e-5), None);
        // Steps are half a pixel there.
        let step = |distance: f32, near: f32| distance * distance / (16_777_216.0 * near);
        assert_eq!(step(10.0, least), 0.5 * 10.0 / 1024.0);
    }

    #[test]
    fn pieces_without_room_are_reported() {
        let found = |lost_pieces| ShadowStatistics { lost_pieces, most_pieces: 600, ..Zeroable::zeroed() };
        assert_eq!(too_many_pieces(&found(0)), None);
        let warning = too_many_pieces(&found(1)).expect("one is lost");
        assert!(warning.contains("have 600 pieces for a light"), "{warning}");
    }

    #[test]
    fn sums_do_not_wrap() {
        let found = |count_bound, skipped| ShadowStatistics { count_bound, skipped, ..Zeroable::zeroed() };
        let sum = |one, other| each(one, other, u32::saturating_add);
        let both = sum(found(200, 1), found(100, 2));
        assert_eq!((both.count_bound, both.skipped, both.near_capped), (300, 3, 0));
        assert_eq!(sum(found(u32::MAX, 0), found(2, 0)).count_bound, u32::MAX);
    }
}
