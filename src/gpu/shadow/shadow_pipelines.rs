//! Render pipelines that count the shadow volumes of scenes.

use super::errors::ShadowError;
use super::format::{Casters, ShadowFormat};
use super::pipelines::VolumePipelines;
use crate::gpu::common::drawing::{Drawn, depth_stencil, unchanged};
use crate::gpu::common::memory::any_error;
use crate::gpu::common::pipelines::Pipelines;
use crate::shadow::Counting;

/// A triangle over the whole viewport.
const WHOLE: &str = "
@vertex fn whole(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(select(-1.0, 3.0, vertex == 1u), select(-1.0, 3.0, vertex == 2u), 0.5, 1.0);
}
@fragment fn nothing() {}
";

/// The render pipelines that draw the volumes of a [`Scene`](crate::gpu::Scene), for one counting method and one
/// [`ShadowFormat`]. Scenes share them.
#[derive(Debug)]
pub struct ShadowPipelines {
    pub(crate) volumes: VolumePipelines,
    /// `None`: casters are counted in one batch.
    pub(crate) resolve: Option<Resolve>,
}

/// The pipeline that is drawn between two batches of casters: it turns the counts of the first into the dark bit.
#[derive(Debug)]
pub(crate) struct Resolve {
    pipeline: wgpu::RenderPipeline,
    /// The dark bit of the stencil, the highest of the bits of counts. It is set where earlier batches cast a shadow.
    dark_bit: u32,
}

impl ShadowPipelines {
    /// Makes the pipelines. `pipelines` is the caller's device, or the [`Pipelines`] that the scenes share. `counting` is
    /// that of the scenes, [`SceneOptions::counting`](crate::gpu::SceneOptions::counting).
    ///
    /// # Errors
    /// [`ShadowError`] if the device lacks what shadow volumes need, or cannot draw into the attachments, or if
    /// [`ShadowFormat::count_bits`] is not 1 to 8.
    pub fn new(
        pipelines: impl Into<Pipelines>,
        format: &ShadowFormat,
        counting: Counting,
    ) -> Result<Self, ShadowError> {
        let volumes = VolumePipelines::of_casters(pipelines.into(), format, counting, Casters::Scene)?;
        Ok(Self { volumes, resolve: None })
    }

    /// Makes the pipelines for scenes whose casters are counted in several batches
    /// ([`StencilCounts::count_batches`](crate::gpu::StencilCounts::count_batches)). Each batch counts with one bit less than
    /// [`ShadowFormat::count_bits`]. The highest of these bits is set where earlier batches cast a shadow.
    ///
    /// # Errors
    /// The errors of [`Self::new`]. `count_bits` must be at least 2.
    pub fn in_batches(
        pipelines: impl Into<Pipelines>,
        format: &ShadowFormat,
        counting: Counting,
    ) -> Result<Self, ShadowError> {
        let pipelines = pipelines.into();
        let volumes = VolumePipelines::of_casters(pipelines.clone(), format, counting, Casters::Batches)?;
        let made = any_error(pipelines.device(), || resolve(&pipelines, format));
        let resolve = made.map_err(|message| ShadowError::Refused { message })?;
        Ok(Self { volumes, resolve: Some(resolve) })
    }

    /// The counting method of these pipelines.
    pub fn counting(&self) -> Counting {
        self.volumes.convention.counting
    }

    /// Where a count is not 0, sets the dark bit, and the count to 0. Sets the stencil reference of the pass to 0.
    pub(crate) fn resolve(&self, pass: &mut wgpu::RenderPass<'_>) {
        if let Some(resolve) = &self.resolve {
            pass.set_pipeline(&resolve.pipeline);
            pass.set_stencil_reference(resolve.dark_bit);
            pass.draw(0..3, 0..1);
            pass.set_stencil_reference(0);
        }
    }
}

fn resolve(pipelines: &Pipelines, format: &ShadowFormat) -> Resolve {
    let counts = Casters::Batches.largest_count(format.count_bits);
    let module = pipelines.module("resolve counts", WHOLE);
    // The reference is the dark bit, which `read_mask` leaves out, so the comparison is of the count with 0.
    let face = wgpu::StencilFaceState {
        compare: wgpu::CompareFunction::NotEqual,
        pass_op: wgpu::StencilOperation::Replace,
        ..wgpu::StencilFaceState::IGNORE
    };
    let write_mask = Casters::Scene.largest_count(format.count_bits);
    let stencil = wgpu::StencilState { front: face, back: face, read_mask: counts, write_mask };
    let compare = wgpu::CompareFunction::Always;
    let pipeline = pipelines.draws(&Drawn {
        label: "resolve counts",
        layouts: &[],
        vertex: (&module, "whole"),
        fragment: Some((&module, "nothing")),
        constants: &[],
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(depth_stencil(format.depth_stencil, false, compare, stencil)),
        samples: format.samples,
        targets: &unchanged(&format.colors),
    });
    Resolve { pipeline, dark_bit: counts + 1 }
}
