//! Render pipelines: what those of all subjects differ in.

use super::pipelines::Pipelines;

/// A render pipeline that draws triangles, without vertex buffers and without changing a colour.
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
    pub(crate) format: wgpu::TextureFormat,
    pub(crate) writes_depth: bool,
    pub(crate) compare: wgpu::CompareFunction,
    pub(crate) stencil: wgpu::StencilState,
    pub(crate) samples: u32,
    pub(crate) colors: &'a [Option<wgpu::TextureFormat>],
}

impl Pipelines {
    /// Makes a render pipeline.
    pub(crate) fn draws(&self, drawn: &Drawn<'_>) -> wgpu::RenderPipeline {
        let (label, bias) = (Some(drawn.label), wgpu::DepthBiasState::default());
        let groups: Vec<_> = drawn.layouts.iter().copied().map(Some).collect();
        let layout = self.device().create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let unchanged = |color: &Option<wgpu::TextureFormat>| {
            let write_mask = wgpu::ColorWrites::empty();
            color.map(|format| wgpu::ColorTargetState { format, blend: None, write_mask })
        };
        let targets: Vec<_> = drawn.colors.iter().map(unchanged).collect();
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
            depth_stencil: Some(wgpu::DepthStencilState {
                format: drawn.format,
                depth_write_enabled: Some(drawn.writes_depth),
                depth_compare: Some(drawn.compare),
                stencil: drawn.stencil.clone(),
                bias,
            }),
            multisample: wgpu::MultisampleState { count: drawn.samples, ..Default::default() },
            fragment: drawn.fragment.map(|(module, entry_point)| wgpu::FragmentState {
                module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}
