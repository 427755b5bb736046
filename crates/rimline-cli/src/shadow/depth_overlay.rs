//! The boundaries of shadows from depth maps themselves, translucent.

use rimline::wgpu;
use wgpu::{BlendState, ColorWrites, CompareFunction, DepthBiasState, PrimitiveTopology, StencilFaceState};

use super::depth::depth_format;
use super::receiver_pipelines::{Target, depth_state};
use super::render_resources::{DrawInputs, RenderResources};
use super::shown_maps::ShownDepths;
use super::volume_overlay::GLASS;
use crate::device::Gpu;
use crate::render::pipeline_factory::Pass;

/// Draws the boundaries themselves.
pub(super) struct DepthOverlay {
    layout: wgpu::BindGroupLayout,
    /// Triangles and lines.
    passes: [wgpu::RenderPipeline; 2],
}

impl DepthOverlay {
    pub(super) fn new(gpu: &Gpu, resources: &RenderResources<'_>, target: Target) -> Self {
        let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        let layout = resources.factory.layout_for(
            wgpu::ShaderStages::VERTEX,
            &[
                buffer(wgpu::BufferBindingType::Uniform),
                buffer(wgpu::BufferBindingType::Storage { read_only: true }),
                wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: false },
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
            ],
        );
        let source = format!("{GLASS}\n{}", include_str!("depth_volumes.wgsl"));
        let format = depth_format(&gpu.device);
        let pipeline = |name, vertex, topology, bias| {
            let depth = depth_state(format, false, CompareFunction::Greater, StencilFaceState::IGNORE);
            resources.factory.pipeline(&Pass {
                name,
                vertex,
                source: &source,
                groups: &[&resources.layouts.shaded, &layout],
                topology,
                format: target.format,
                blend: Some(BlendState::ALPHA_BLENDING),
                samples: target.samples,
                write: ColorWrites::ALL,
                depth: Some(wgpu::DepthStencilState { bias, ..depth }),
                constants: &[],
            })
        };
        // Where the boundary lies on what casts, it is behind it. Depth falls with the distance.
        let behind = DepthBiasState { constant: -64, slope_scale: -4.0, clamp: 0.0 };
        let triangles = pipeline("volumes", "depth_volumes", PrimitiveTopology::TriangleList, behind);
        let lines = pipeline("edges", "depth_edges", PrimitiveTopology::LineList, DepthBiasState::default());
        Self { passes: [triangles, lines], layout }
    }

    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        resources: &RenderResources<'_>,
        subject: &DrawInputs<'_>,
    ) {
        for light in 0..subject.samples {
            let Some(ShownDepths { shown, cells, texture }) = subject.casters.shadows.shown_depths(light) else {
                continue;
            };
            let bound = [
                shown.views.as_entire_binding(),
                cells.as_entire_binding(),
                wgpu::BindingResource::TextureView(texture),
            ];
            let group = resources.factory.group(&self.layout, &bound);
            resources.select(pass, light);
            pass.set_bind_group(2, &group, &[]);
            for (pipeline, arguments) in self.passes.iter().zip([[0, 32], [16, 48]]) {
                pass.set_pipeline(pipeline);
                for at in arguments {
                    pass.draw_indirect(&shown.draws, at);
                }
            }
        }
    }
}
