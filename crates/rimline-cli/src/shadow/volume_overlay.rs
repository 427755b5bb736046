//! The volumes themselves, translucent.

use rimline::gpu::{include_wgsl, results_bind_group_layout};
use rimline::wgpu;
use wgpu::{BlendState, ColorWrites, CompareFunction, PrimitiveTopology, StencilFaceState};

use super::depth::depth_format;
use super::receiver_pipelines::{Target, depth_state};
use super::render_resources::{DrawInputs, RenderResources};
use crate::device::Gpu;
use crate::gpu_error::GpuError;
use crate::render::pipeline_factory::Pass;

/// Fragment shaders of all volumes.
pub(super) const GLASS: &str = include_str!("glass.wgsl");

/// Draws the volumes of meshes themselves.
pub(super) struct VolumeOverlay {
    layout: wgpu::BindGroupLayout,
    sides: wgpu::RenderPipeline,
    edges: wgpu::RenderPipeline,
}

impl VolumeOverlay {
    pub(super) fn new(gpu: &Gpu, resources: &RenderResources<'_>, target: Target) -> Self {
        let layout = results_bind_group_layout(&gpu.device, wgpu::ShaderStages::VERTEX);
        let source = format!("{}\n{GLASS}\n{}", include_wgsl(2), include_str!("volumes.wgsl"));
        let format = depth_format(&gpu.device);
        let pipeline = |name, topology| {
            resources.factory.pipeline(&Pass {
                name,
                vertex: name,
                source: &source,
                groups: &[&resources.layouts.shaded, &layout],
                topology,
                format: target.format,
                blend: Some(BlendState::ALPHA_BLENDING),
                samples: target.samples,
                write: ColorWrites::ALL,
                depth: Some(depth_state(format, false, CompareFunction::Greater, StencilFaceState::IGNORE)),
                constants: &[],
            })
        };
        Self {
            sides: pipeline("volumes", PrimitiveTopology::TriangleStrip),
            edges: pipeline("edges", PrimitiveTopology::LineStrip),
            layout,
        }
    }

    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        resources: &RenderResources<'_>,
        subject: &DrawInputs<'_>,
    ) -> Result<(), GpuError> {
        for light in 0..subject.samples {
            for extraction in subject.casters.shown(light) {
                let group = extraction.bind_group(&self.layout, light / 32)?;
                resources.select(pass, light);
                pass.set_bind_group(2, &group, &[]);
                for pipeline in [&self.sides, &self.edges] {
                    pass.set_pipeline(pipeline);
                    extraction.draw(pass, light)?;
                }
            }
        }
        Ok(())
    }
}
