//! The draws of a light's shadow volume.

use super::buffers::Buffers;
use super::pipelines::ShadowPipelines;
use crate::gpu::common::uniforms::UniformTable;
use crate::layout::{DrawArguments, ShadowDraw, ShadowDraws};

/// The bind groups of the draws.
#[derive(Debug)]
pub(super) struct DrawGroups {
    /// Camera and lights.
    pub(super) frame: wgpu::BindGroup,
    /// Edges and the lists of sides, one for each batch of lights.
    pub(super) sides: Vec<wgpu::BindGroup>,
    /// Faces and their lists, one for each batch of lights.
    pub(super) caps: Vec<wgpu::BindGroup>,
}

/// The offset of a light's draws of one kind, in bytes.
fn offset(light: usize, kind: u64) -> u64 {
    (light * size_of::<ShadowDraws>()) as u64 + kind * size_of::<DrawArguments>() as u64
}

const PLAIN: u64 = 0;
const CLIPPED: u64 = 1;
/// The first of the two lists of cap faces.
const CAPS: u64 = 2;
/// Sides that ZP+ as published leaves to z-fail.
const SWITCHED: u64 = 4;
/// The first of the two lists of their cap faces, or of the dark caps of z-pass.
const FAR_CAPS: u64 = 5;

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
        let draws = &buffers.draws;
        let uniform = (light * UniformTable::stride::<ShadowDraw>()) as u32;
        pass.set_bind_group(0, &self.frame, &[uniform]);
        if let Some((clipped, near_caps)) = &pipelines.clipped {
            pass.set_bind_group(1, caps, &[]);
            for (class, pipeline) in (0..).zip(near_caps) {
                pass.set_pipeline(pipeline);
                pass.draw_indirect(draws, offset(light, CAPS + class));
            }
            pass.set_bind_group(1, sides, &[]);
            pass.set_pipeline(clipped);
            pass.draw_indirect(draws, offset(light, CLIPPED));
        }
        if let Some((side, near_caps)) = &pipelines.zp_plus_2005 {
            pass.set_bind_group(1, caps, &[]);
            for (class, pipeline) in (0..).zip(near_caps) {
                pass.set_pipeline(pipeline);
                pass.draw_indirect(draws, offset(light, CAPS + class));
            }
            pass.set_bind_group(1, sides, &[]);
            pass.set_pipeline(side);
            pass.draw_indirect(draws, offset(light, CLIPPED));
        }
        if let Some(ends) = pipelines.ends.as_ref().filter(|_| may_end) {
            pass.set_bind_group(1, caps, &[]);
            for (class, pipeline) in (0..).zip(ends) {
                pass.set_pipeline(pipeline);
                pass.draw_indirect(draws, offset(light, FAR_CAPS + class));
            }
        }
        let (side_kind, cap_kind) = if pipelines.zp_plus_2005.is_some() { (SWITCHED, FAR_CAPS) } else { (PLAIN, CAPS) };
        if let Some(classes) = &pipelines.caps {
            pass.set_bind_group(1, caps, &[]);
            for (class, pipelines) in (0..).zip(classes) {
                for pipeline in pipelines {
                    pass.set_pipeline(pipeline);
                    pass.draw_indirect(draws, offset(light, cap_kind + class));
                }
            }
        }
        pass.set_bind_group(1, sides, &[]);
        pass.set_pipeline(&pipelines.side);
        pass.draw_indirect(draws, offset(light, side_kind));
    }
}
