//! Pipelines that draw batches of casters. The low bits of the stencil count; another bit marks pixels that earlier
//! batches darken.

use std::sync::{Arc, OnceLock};

use rimline::gpu::{Pipelines, ShadowFormat, ShadowPipelines};
use rimline::{Counting, wgpu};

use crate::gpu_error::GpuError;

/// The bits that count.
pub(super) const COUNT_BITS: u32 = 7;
/// The most that they count to.
pub(super) const MOST_OF_BATCH: u32 = (1 << COUNT_BITS) - 1;

/// A triangle over the whole picture.
const WHOLE: &str = "
@vertex fn whole(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(select(-1.0, 3.0, vertex == 1u), select(-1.0, 3.0, vertex == 2u), 0.5, 1.0);
}
@fragment fn nothing() {}
";

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
    let label = Some("resolve batch");
    let module = device
        .create_shader_module(wgpu::ShaderModuleDescriptor { label, source: wgpu::ShaderSource::Wgsl(WHOLE.into()) });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label,
        bind_group_layouts: &[],
        immediate_size: 0,
    });
    // The reference has no bit of the count, so the comparison is with 0.
    let face = wgpu::StencilFaceState {
        compare: wgpu::CompareFunction::NotEqual,
        fail_op: wgpu::StencilOperation::Keep,
        depth_fail_op: wgpu::StencilOperation::Keep,
        pass_op: wgpu::StencilOperation::Replace,
    };
    let write_mask = wgpu::ColorWrites::empty();
    let target = |color: &Option<wgpu::TextureFormat>| {
        color.map(|format| wgpu::ColorTargetState { format, blend: None, write_mask })
    };
    let targets: Vec<_> = format.colors.iter().map(target).collect();
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label,
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("whole"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: format.depth_stencil,
            depth_write_enabled: Some(false),
            depth_compare: Some(wgpu::CompareFunction::Always),
            stencil: wgpu::StencilState { front: face, back: face, read_mask: MOST_OF_BATCH, write_mask: 0xff },
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState { count: format.samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("nothing"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}
