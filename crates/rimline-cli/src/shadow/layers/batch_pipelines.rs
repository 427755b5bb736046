//! Pipelines that draw batches of casters. The low bits of the stencil count; another bit marks pixels that earlier
//! batches darken.

use std::sync::{Arc, OnceLock};

use rimline::gpu::{Pipelines, ShadowFormat, ShadowPipelines};
use rimline::{Counting, wgpu};

use crate::gpu_error::GpuError;
use crate::render::pipeline_factory::{COMMON, Pass, depth_state};

/// The bits that count.
pub(super) const COUNT_BITS: u32 = 7;
/// The most that they count to.
pub(super) const MOST_OF_BATCH: u32 = (1 << COUNT_BITS) - 1;

/// Made when they are first needed, as most pictures do without.
#[derive(Clone)]
pub(crate) struct BatchPipelines {
    pipelines: Pipelines,
    format: ShadowFormat,
    counting: Counting,
    made: Arc<OnceLock<Made>>,
}

pub(super) struct Made {
    pub(super) counting: ShadowPipelines,
    resolve: wgpu::RenderPipeline,
}

impl BatchPipelines {
    pub(crate) fn new(pipelines: &Pipelines, format: &ShadowFormat, counting: Counting) -> Self {
        let format = ShadowFormat { count_bits: COUNT_BITS, ..format.clone() };
        Self { pipelines: pipelines.clone(), format, counting, made: Arc::default() }
    }

    pub(super) fn get(&self) -> Result<&Made, GpuError> {
        if let Some(made) = self.made.get() {
            return Ok(made);
        }
        let counting = ShadowPipelines::new(&self.pipelines, &self.format, self.counting)?;
        let resolve = resolve(self.pipelines.device(), &self.format);
        Ok(self.made.get_or_init(|| Made { counting, resolve }))
    }
}

impl Made {
    /// Where a count is not 0, sets the bit of darkness and the count to 0.
    pub(super) fn resolve(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.resolve);
        pass.set_stencil_reference(MOST_OF_BATCH + 1);
        pass.draw(0..3, 0..1);
        pass.set_stencil_reference(0);
    }
}

fn resolve(device: &wgpu::Device, format: &ShadowFormat) -> wgpu::RenderPipeline {
    // The reference has no bit of the count, so the comparison is with 0.
    let face = wgpu::StencilFaceState {
        compare: wgpu::CompareFunction::NotEqual,
        fail_op: wgpu::StencilOperation::Keep,
        depth_fail_op: wgpu::StencilOperation::Keep,
        pass_op: wgpu::StencilOperation::Replace,
    };
    let depth = depth_state(format.depth_stencil, false, wgpu::CompareFunction::Always, face);
    let color = format.colors.iter().flatten().next().copied().unwrap_or(wgpu::TextureFormat::Rgba8Unorm);
    let pass = Pass {
        samples: format.samples,
        write: wgpu::ColorWrites::empty(),
        depth: Some(wgpu::DepthStencilState {
            stencil: wgpu::StencilState { read_mask: MOST_OF_BATCH, ..depth.stencil.clone() },
            ..depth
        }),
        ..Pass::over("resolve", "@fragment fn resolve_fragment() {}", &[], color)
    };
    pass.pipeline(device, COMMON, None)
}
