//! The draws of a light's shadow volume.

use super::format::Polygons;
use super::pipelines::{Part, PartDraw, VolumePipelines};
use crate::layout::DrawArguments;

/// The bind groups of the draws of a light, and where its arguments lie.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightDraws<'a> {
    /// Casters, camera and lights, with the offsets of the light in them.
    pub(crate) frame: &'a wgpu::BindGroup,
    pub(crate) uniform: u32,
    pub(crate) view_light: u32,
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
    /// Pieces of twisted polygons and their [`PieceDraws`](crate::layout::PieceDraws), and the offset of those of the
    /// light.
    pub(crate) pieces: Option<(&'a wgpu::BindGroup, &'a wgpu::Buffer)>,
    pub(crate) first_piece: u64,
}

impl LightDraws<'_> {
    /// Draws the shadow volumes of the light. Which pieces there are is in the arguments.
    pub(crate) fn draw(self, pass: &mut wgpu::RenderPass<'_>, pipelines: &VolumePipelines) {
        let Self { frame, uniform, view_light, sides, caps, draws, first, may_end, has_proxies, pieces, first_piece } =
            self;
        pass.set_bind_group(0, frame, &[uniform, view_light]);
        let mut set = None;
        let parts =
            [(may_end, Part::Ends), (has_proxies, Part::Proxies), (true, Part::All), (pieces.is_some(), Part::Pieces)];
        for (_, part) in parts.into_iter().filter(|(is_drawn, _)| *is_drawn) {
            for PartDraw { polygons, argument, pipelines } in pipelines.of(part) {
                let (data, arguments, first) = match (polygons, pieces) {
                    (Polygons::Pieces, Some((pieces, draws))) => (pieces, draws, first_piece),
                    (Polygons::Caps, _) => (caps, draws, first),
                    _ => (sides, draws, first),
                };
                if set != Some(*polygons) {
                    pass.set_bind_group(1, data, &[]);
                    set = Some(*polygons);
                }
                for pipeline in pipelines {
                    pass.set_pipeline(pipeline);
                    pass.draw_indirect(arguments, first + argument * size_of::<DrawArguments>() as u64);
                }
            }
        }
    }
}
