//! The bounds of shadows, translucent: the volumes of meshes, or the boundaries that depth maps have.

use rimline::gpu::include_wgsl;
use rimline::wgpu;
use rimline_picture::{
    OVERLAY, Pass, READ_ONLY, Resources, Target, UNIFORM, VolumeOverlay, group, layout, overlay_pass, read_texture,
};
use wgpu::{DepthBiasState, PrimitiveTopology};

use super::casters::DrawInputs;
use super::light_maps::ShownDepths;
use crate::gpu_error::GpuError;

/// Draws what bounds the shadows.
pub(crate) enum Overlay {
    Volumes(VolumeOverlay),
    Maps(MapOverlay),
}

/// Draws the boundaries that depth maps have.
pub(crate) struct MapOverlay {
    layout: wgpu::BindGroupLayout,
    /// Triangles and lines.
    passes: [wgpu::RenderPipeline; 2],
}

impl Overlay {
    pub(super) fn new(resources: &Resources, target: Target, of_maps: bool) -> Self {
        if of_maps {
            Self::Maps(MapOverlay::new(resources, target))
        } else {
            Self::Volumes(VolumeOverlay::new(resources, target))
        }
    }

    pub(super) fn draw(&self, pass: &mut wgpu::RenderPass<'_>, subject: &DrawInputs<'_>) -> Result<(), GpuError> {
        for light in 0..subject.samples {
            match self {
                Self::Volumes(volumes) => {
                    for extraction in subject.casters.shown(light) {
                        volumes.draw(pass, &subject.casters.resources.shared, extraction, [light; 2])?;
                    }
                }
                Self::Maps(maps) => maps.draw(pass, subject, light),
            }
        }
        Ok(())
    }
}

impl MapOverlay {
    fn new(resources: &Resources, target: Target) -> Self {
        let types = [UNIFORM, READ_ONLY, read_texture(wgpu::TextureViewDimension::D2, false)];
        let layout = layout(&resources.factory.device, wgpu::ShaderStages::VERTEX, &types);
        let source = format!("{}\n{OVERLAY}\n{}", include_wgsl(2), include_str!("depth_overlay.wgsl"));
        let groups = [&resources.light, &layout];
        let pipeline = |name, vertex, topology, bias| {
            let pass = overlay_pass(resources, target, (name, &source), &groups);
            let depth = pass.depth.clone().map(|depth| wgpu::DepthStencilState { bias, ..depth });
            resources.factory.pipeline(&Pass { vertex, topology, depth, ..pass })
        };
        // Where the boundary lies on what casts, it is behind it. Depth falls with the distance.
        let behind = DepthBiasState { constant: -64, slope_scale: -4.0, clamp: 0.0 };
        let triangles = pipeline("volumes", "depth_volumes", PrimitiveTopology::TriangleList, behind);
        let lines = pipeline("edges", "depth_edges", PrimitiveTopology::LineList, DepthBiasState::default());
        Self { layout, passes: [triangles, lines] }
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, subject: &DrawInputs<'_>, light: usize) {
        let shown = subject.casters.shadows.shown_maps(light);
        let Some(ShownDepths { shown, cells, texture }) = shown else { return };
        let bound =
            [shown.views.as_entire_binding(), cells.as_entire_binding(), wgpu::BindingResource::TextureView(texture)];
        let resources = &subject.casters.resources.shared;
        resources.select(pass, light);
        pass.set_bind_group(2, &group(&resources.factory.device, &self.layout, &bound), &[]);
        for (pipeline, arguments) in self.passes.iter().zip([[0, 32], [16, 48]]) {
            pass.set_pipeline(pipeline);
            for at in arguments {
                pass.draw_indirect(&shown.draws, at);
            }
        }
    }
}
