//! Piece arguments: the indirect draws of the pieces of L-twisted polygons.

use bytemuck::Zeroable as _;

use super::casting::near_kind;
use crate::layout::{DrawArguments, PieceDraws, ShadowLight};
use crate::shadow::{CAST_NOTHING, COUNT_Z_FAIL, COUNT_ZP_PLUS};

/// The draws of each light, and the number of pieces that there was no room for. `lights` are as they were chosen, and `counts`
/// has the numbers of their pieces, of which `capacity` have room.
pub fn piece_arguments(lights: &[ShadowLight], counts: &[u32], capacity: u32) -> (Vec<PieceDraws>, u32) {
    let mut lost = 0;
    let draws = lights.iter().zip(counts).map(|(light, &pieces)| {
        if light.casting == CAST_NOTHING {
            return PieceDraws::zeroed();
        }
        let count = pieces.min(capacity);
        lost += pieces - count;
        let draw = |is_drawn: bool, vertex_count: u32| {
            if !is_drawn || count == 0 {
                return DrawArguments::zeroed();
            }
            DrawArguments { vertex_count, instance_count: count, first_vertex: 0, first_instance: 0 }
        };
        let is_clipped = light.counting == COUNT_ZP_PLUS;
        let is_fail = light.counting == COUNT_Z_FAIL;
        let near = |kind: usize| is_clipped && near_kind(light, true) == kind;
        PieceDraws {
            plain: draw(!is_clipped, 4),
            clipped: draw(is_clipped, 5),
            near_front: draw(near(0), 5),
            near_back: draw(near(1), 5),
            light_cap: draw(true, 4),
            dark_cap: draw(is_fail || light.end > 0.0, 3),
        }
    });
    let draws = draws.collect();
    (draws, lost)
}
