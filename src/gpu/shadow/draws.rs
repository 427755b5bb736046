//! The draws of a light's shadow volume.

use super::buffers::Buffers;
use super::pipelines::ShadowPipelines;
use crate::gpu::common::uniforms::UniformTable;
use crate::layout::{DrawArguments, SeenLight, ShadowDraw, ShadowDraws};

/// The bind groups of the draws.
#[derive(Debug)]
pub(super) struct DrawGroups {
    /// Casters, camera and lights.
    pub(super) frame: wgpu::BindGroup,
    /// Edges and the lists of sides, one for each batch of lights.
    pub(super) sides: Vec<wgpu::BindGroup>,
    /// Faces and their lists, one for each batch of lights.
    pub(super) caps: Vec<wgpu::BindGroup>,
}

// The numbers of the fields of `ShadowDraws`.
const PLAIN: u64 = 0;
const CLIPPED: u64 = 1;
/// The first of both classes.
const NEAR_CAPS: u64 = 2;
const FAR_CAPS: u64 = 4;

impl DrawGroups {
    /// Draws the shadow volume of `light`.
    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &ShadowPipelines,
        buffers: &Buffers,
        light: usize,
        may_end: bool,
    ) {
        let (Some(sides), Some(caps)) = (self.sides.get(light / 32), self.caps.get(light / 32)) else { return };
        let uniform = (light * UniformTable::stride::<ShadowDraw>()) as u32;
        let seen = (light * size_of::<SeenLight>()) as u32;
        pass.set_bind_group(0, &self.frame, &[uniform, seen]);
        let first = (light * size_of::<ShadowDraws>()) as u64;
        let draw = |pass: &mut wgpu::RenderPass<'_>, pipeline: &wgpu::RenderPipeline, kind: u64| {
            pass.set_pipeline(pipeline);
            pass.draw_indirect(&buffers.draws, first + kind * size_of::<DrawArguments>() as u64);
        };
        pass.set_bind_group(1, caps, &[]);
        if let Some((_, near_caps)) = &pipelines.near {
            for (class, pipeline) in (0..).zip(near_caps) {
                draw(pass, pipeline, NEAR_CAPS + class);
            }
        }
        if let Some(ends) = pipelines.ends.as_ref().filter(|_| may_end) {
            for (class, pipeline) in (0..).zip(ends) {
                draw(pass, pipeline, FAR_CAPS + class);
            }
        }
        for (class, pipelines) in (0..).zip(pipelines.caps.iter().flatten()) {
            for pipeline in pipelines {
                draw(pass, pipeline, FAR_CAPS + class);
            }
        }
        pass.set_bind_group(1, sides, &[]);
        if let Some((clipped, _)) = &pipelines.near {
            draw(pass, clipped, CLIPPED);
        }
        draw(pass, &pipelines.side, PLAIN);
    }
}
