//! The draws of a light's shadow volume.

use super::pipelines::{Drawing, PiecePipelines, ShadowPipelines};
use crate::layout::DrawArguments;

/// The bind groups of the draws of a light, and where its arguments lie.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightDraws<'a> {
    /// Casters, camera and lights, with the offsets of the light in them.
    pub(crate) frame: &'a wgpu::BindGroup,
    pub(crate) uniform: u32,
    pub(crate) seen: u32,
    /// Edges and the lists of sides.
    pub(crate) sides: &'a wgpu::BindGroup,
    /// Faces and their lists.
    pub(crate) caps: &'a wgpu::BindGroup,
    /// The light's `ShadowDraws` and their offset.
    pub(crate) draws: &'a wgpu::Buffer,
    pub(crate) first: u64,
    /// Whether volumes may end at the range.
    pub(crate) may_end: bool,
    /// Whether some casters are not in the depth buffer.
    pub(crate) has_proxies: bool,
    /// Pieces of L-twisted polygons and their [`PieceDraws`](crate::layout::PieceDraws), and the offset of those of the light.
    pub(crate) pieces: Option<(&'a wgpu::BindGroup, &'a wgpu::Buffer)>,
    pub(crate) first_piece: u64,
}

// The numbers of the fields of `ShadowDraws`.
const PLAIN: u64 = 0;
const CLIPPED: u64 = 1;
/// The first of both classes.
const NEAR_CAPS: u64 = 2;
const FAR_CAPS: u64 = 4;
const LIGHT_CAPS: u64 = 6;

// The numbers of the last fields of `PieceDraws`. The first are as those of `ShadowDraws`.
const PIECE_LIGHT_CAP: u64 = 4;
const PIECE_DARK_CAP: u64 = 5;

impl LightDraws<'_> {
    /// Draws the shadow volumes of the light.
    pub(crate) fn draw(self, pass: &mut wgpu::RenderPass<'_>, pipelines: &ShadowPipelines) {
        let Self { frame, uniform, seen, sides, caps, draws, first, may_end, has_proxies, .. } = self;
        pass.set_bind_group(0, frame, &[uniform, seen]);
        let draw = |pass: &mut wgpu::RenderPass<'_>, drawing: &Drawing, kind: u64| {
            for pipeline in drawing {
                pass.set_pipeline(pipeline);
                pass.draw_indirect(draws, first + kind * size_of::<DrawArguments>() as u64);
            }
        };
        pass.set_bind_group(1, caps, &[]);
        if let Some((_, near_caps)) = &pipelines.near {
            for (class, pipeline) in (0..).zip(near_caps) {
                draw(pass, pipeline, NEAR_CAPS + class);
            }
        }
        if let Some(ends) = may_end.then(|| pipelines.ends()).flatten() {
            for (class, pipeline) in (0..).zip(ends) {
                draw(pass, pipeline, FAR_CAPS + class);
            }
        }
        if let Some(light_caps) = has_proxies.then(|| pipelines.light_caps()).flatten() {
            for (class, pipeline) in (0..).zip(light_caps) {
                draw(pass, pipeline, LIGHT_CAPS + class);
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
        self.draw_pieces(pass, pipelines);
    }

    /// Draws the sides and caps of pieces. Which of them there are is in the arguments.
    fn draw_pieces(self, pass: &mut wgpu::RenderPass<'_>, pipelines: &ShadowPipelines) {
        let Some((pieces, draws)) = self.pieces else { return };
        let PiecePipelines { side, near, light_cap, dark_cap } = pipelines.pieces();
        pass.set_bind_group(1, pieces, &[]);
        let draw = |pass: &mut wgpu::RenderPass<'_>, drawing: &Drawing, kind: u64| {
            for pipeline in drawing {
                pass.set_pipeline(pipeline);
                pass.draw_indirect(draws, self.first_piece + kind * size_of::<DrawArguments>() as u64);
            }
        };
        if let Some((clipped, near_caps)) = near {
            draw(pass, clipped, CLIPPED);
            for (class, pipeline) in (0..).zip(near_caps) {
                draw(pass, pipeline, NEAR_CAPS + class);
            }
        }
        draw(pass, side, PLAIN);
        draw(pass, light_cap, PIECE_LIGHT_CAP);
        draw(pass, dark_cap, PIECE_DARK_CAP);
    }
}
