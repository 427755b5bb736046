//! Render pipelines that count the shadow volumes of scenes.

use super::errors::ShadowError;
use super::format::{Casters, ShadowFormat};
use super::pipelines::VolumePipelines;
use crate::gpu::common::drawing::{Drawn, depth_stencil, unchanged};
use crate::gpu::common::memory::any_error;
use crate::gpu::common::pipelines::Pipelines;
use crate::shadow::Counting;

/// A triangle over the whole picture.
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
    /// If casters are counted in batches.
    resolve: Option<Resolve>,
}

/// The pipeline that turns counts into the bit of darkness.
#[derive(Debug)]
struct Resolve {
    pipeline: wgpu::RenderPipeline,
    /// The bit of the stencil that is set where earlier batches of casters darken: the highest bit of counts.
    dark: u32,
}

impl ShadowPipelines {
    /// Makes the pipelines. `pipelines` is the caller's device, or the [`Pipelines`] that the scenes share. `counting` is
    /// that of the scenes; see [`SceneOptions`](crate::gpu::SceneOptions).
    ///
    /// # Errors
    /// [`ShadowError`] if the device lacks what shadow volumes need, or cannot draw into the attachments.
    pub fn new(
        pipelines: impl Into<Pipelines>,
        format: &ShadowFormat,
        counting: Counting,
    ) -> Result<Self, ShadowError> {
        let volumes = VolumePipelines::of_casters(pipelines.into(), format, counting, Casters::Scene)?;
        Ok(Self { volumes, resolve: None })
    }

    /// Makes the pipelines for scenes whose casters are counted in several batches
    /// ([`StencilCounts::count_batches`](crate::gpu::StencilCounts::count_batches)). The highest of
    /// [`ShadowFormat::count_bits`] is set where earlier batches darken.
    ///
    /// # Errors
    /// The errors of [`Self::new`].
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

    pub(crate) fn is_in_batches(&self) -> bool {
        self.resolve.is_some()
    }

    /// Where a count is not 0, sets the bit of darkness and the count to 0.
    pub(crate) fn resolve(&self, pass: &mut wgpu::RenderPass<'_>) {
        if let Some(resolve) = &self.resolve {
            pass.set_pipeline(&resolve.pipeline);
            pass.set_stencil_reference(resolve.dark);
            pass.draw(0..3, 0..1);
            pass.set_stencil_reference(0);
        }
    }
}

fn resolve(pipelines: &Pipelines, format: &ShadowFormat) -> Resolve {
    let counts = Casters::Batches.largest_count(format.count_bits);
    let module = pipelines.module("resolve counts", WHOLE);
    // The reference has no bit of the count, so the comparison is with 0.
    let face = wgpu::StencilFaceState {
        compare: wgpu::CompareFunction::NotEqual,
        pass_op: wgpu::StencilOperation::Replace,
        ..wgpu::StencilFaceState::IGNORE
    };
    let stencil = wgpu::StencilState { front: face, back: face, read_mask: counts, write_mask: format.count_mask() };
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
    Resolve { pipeline, dark: counts + 1 }
}
