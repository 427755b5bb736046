//! Piece crossings: the sides of pieces that cross the half planes of a pencil.

use glam::Vec3;

use super::stencil_crossings::cross_edge;
use super::stencil_pencil::CastingBox;
use crate::layout::StencilPencil;

/// Adds the pieces of a caster to a row of [`super::stencil_crossings::stencil_crossings`]. A piece has the ends of its side.
pub fn piece_crossings(pencil: &StencilPencil, caster: &CastingBox, pieces: &[[[f32; 3]; 2]], row: &mut [u32]) {
    if !pencil.meets(caster) {
        for ends in pieces {
            cross_edge(pencil, row, ends.map(Vec3::from), 1);
        }
    }
}
