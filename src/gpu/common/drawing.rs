//! Render pipelines: what those of all subjects differ in.

use super::pipelines::Pipelines;

/// A render pipeline without vertex buffers.
pub(crate) struct Drawn<'a> {
    /// The label, and the bind group layouts.
    pub(crate) label: &'a str,
    pub(crate) layouts: &'a [&'a wgpu::BindGroupLayout],
    /// Module and entry point.
    pub(crate) vertex: (&'a wgpu::ShaderModule, &'a str),
    /// `None`: it only writes depth.
    pub(crate) fragment: Option<(&'a wgpu::ShaderModule, &'a str)>,
    /// Constants of the vertex stage.
    pub(crate) constants: &'a [(&'a str, f64)],
    pub(crate) primitive: wgpu::PrimitiveState,
    pub(crate) depth_stencil: Option<wgpu::DepthStencilState>,
    pub(crate) samples: u32,
    pub(crate) targets: &'a [Option<wgpu::ColorTargetState>],
}

/// A depth-stencil state without bias.
pub(crate) fn depth_stencil(
    format: wgpu::TextureFormat,
    writes_depth: bool,
    compare: wgpu::CompareFunction,
    stencil: wgpu::StencilState,
) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format,
        depth_write_enabled: Some(writes_depth),
        depth_compare: Some(compare),
        stencil,
        bias: wgpu::DepthBiasState::default(),
    }
}

/// Targets of these formats that stay as they are.
pub(crate) fn unchanged(colors: &[Option<wgpu::TextureFormat>]) -> Vec<Option<wgpu::ColorTargetState>> {
    let write_mask = wgpu::ColorWrites::empty();
    let target = |format| wgpu::ColorTargetState { format, blend: None, write_mask };
    colors.iter().map(|color| color.map(target)).collect()
}

impl Pipelines {
    /// Makes a render pipeline.
    pub(crate) fn draws(&self, drawn: &Drawn<'_>) -> wgpu::RenderPipeline {
        let label = Some(drawn.label);
        let groups: Vec<_> = drawn.layouts.iter().copied().map(Some).collect();
        let layout = self.device().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let constants = wgpu::PipelineCompilationOptions { constants: drawn.constants, ..Default::default() };
        self.device().create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label,
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: drawn.vertex.0,
                entry_point: Some(drawn.vertex.1),
                compilation_options: constants,
                buffers: &[],
            },
            primitive: drawn.primitive,
            depth_stencil: drawn.depth_stencil.clone(),
            multisample: wgpu::MultisampleState { count: drawn.samples, ..Default::default() },
            fragment: drawn.fragment.map(|(module, entry_point)| wgpu::FragmentState {
                module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: drawn.targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}
