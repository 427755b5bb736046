//! The bounds of shadows, translucent: the volumes of meshes, or the boundaries that depth maps have.

use rimline::gpu::{include_wgsl, results_bind_group_layout};
use rimline::wgpu;
use wgpu::{BlendState, CompareFunction, DepthBiasState, PrimitiveTopology, StencilFaceState};

use super::casters::DrawInputs;
use super::depth::depth_format;
use super::light_maps::ShownDepths;
use super::render_resources::{RenderResources, Target};
use crate::gpu_error::GpuError;
use crate::render::pipeline_factory::{Pass, READ_ONLY, UNIFORM, depth_state, read_texture};

/// Draws what bounds the shadows.
pub(super) struct Overlay {
    layout: wgpu::BindGroupLayout,
    /// Triangles and lines.
    passes: [wgpu::RenderPipeline; 2],
}

impl Overlay {
    pub(super) fn new(resources: &RenderResources<'_>, target: Target, of_maps: bool) -> Self {
        let RenderResources { factory, shaded, .. } = resources;
        let device = &factory.gpu.device;
        let layout = if of_maps {
            let types = [UNIFORM, READ_ONLY, read_texture(wgpu::TextureViewDimension::D2, false)];
            factory.gpu.layout(wgpu::ShaderStages::VERTEX, &types)
        } else {
            results_bind_group_layout(device, wgpu::ShaderStages::VERTEX)
        };
        let source = format!("{}\n{}", include_wgsl(2), include_str!("overlay.wgsl"));
        let groups = [shaded, &layout];
        let pipeline = |name, vertex, topology, bias| {
            let depth = depth_state(depth_format(device), false, CompareFunction::Greater, StencilFaceState::IGNORE);
            factory.pipeline(&Pass {
                vertex,
                topology,
                blend: Some(BlendState::ALPHA_BLENDING),
                samples: target.samples,
                depth: Some(wgpu::DepthStencilState { bias, ..depth }),
                ..Pass::new(name, &source, &groups, target.format)
            })
        };
        // Where the boundary lies on what casts, it is behind it. Depth falls with the distance.
        let behind = DepthBiasState { constant: -64, slope_scale: -4.0, clamp: 0.0 };
        let none = DepthBiasState::default();
        let passes = if of_maps {
            let triangles = pipeline("volumes", "depth_volumes", PrimitiveTopology::TriangleList, behind);
            [triangles, pipeline("edges", "depth_edges", PrimitiveTopology::LineList, none)]
        } else {
            let sides = pipeline("volumes", "volumes", PrimitiveTopology::TriangleStrip, none);
            [sides, pipeline("edges", "edges", PrimitiveTopology::LineStrip, none)]
        };
        Self { layout, passes }
    }

    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, subject: &DrawInputs<'_>) -> Result<(), GpuError> {
        let resources = subject.casters.resources;
        for light in 0..subject.samples {
            for extraction in subject.casters.shown(light) {
                let group = extraction.bind_group(&self.layout, light / 32)?;
                resources.select(pass, light);
                pass.set_bind_group(2, &group, &[]);
                for pipeline in &self.passes {
                    pass.set_pipeline(pipeline);
                    extraction.draw(pass, light)?;
                }
            }
            let shown = subject.casters.shadows.shown_maps(light);
            let Some(ShownDepths { shown, cells, texture }) = shown else { continue };
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
        Ok(())
    }
}
