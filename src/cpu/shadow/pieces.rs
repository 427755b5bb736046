//! Pieces: the vertices of the sides and caps of pieces of L-twisted polygons. A piece is an edge of the face that it makes with
//! the middle of its polygon, and that face faces the light.

use glam::Vec4;

use super::cap_faces::{dark_cap, near_cap, seen_light_cap};
use super::sides::{End, side, side_clipped};
use crate::layout::{ShadowLight, ShadowView};

/// The middle of the polygon, and where the piece begins and ends.
pub type PiecePoints = [[f32; 3]; 3];

/// The middle comes first where the order of two matters.
fn face(points: PiecePoints) -> [End; 3] {
    let [middle, from, to] = points;
    [(0, middle), (1, from), (2, to)]
}

/// The side as the eye sees it from outside: counter-clockwise.
fn side_ends(points: PiecePoints) -> [End; 2] {
    let [_, from, to] = face(points);
    [to, from]
}

/// The vertices of a side, as [`side`] has them.
pub fn piece_side(view: &ShadowView, light: &ShadowLight, points: PiecePoints) -> [Vec4; 4] {
    side(view, light, side_ends(points))
}

/// The vertices of a side that is clipped at the near plane.
pub fn piece_side_clipped(view: &ShadowView, light: &ShadowLight, points: PiecePoints) -> Vec<Vec4> {
    side_clipped(view, light, side_ends(points))
}

/// The vertices of the near cap.
pub fn piece_near_cap(view: &ShadowView, light: &ShadowLight, points: PiecePoints) -> Vec<Vec4> {
    near_cap(view, light, face(points))
}

/// The vertices of the cap at the polygon.
pub fn piece_light_cap(view: &ShadowView, light: &ShadowLight, points: PiecePoints) -> Vec<Vec4> {
    seen_light_cap(view, light, face(points))
}

/// The vertices of the cap at the far end.
pub fn piece_dark_cap(view: &ShadowView, light: &ShadowLight, points: PiecePoints) -> Option<[Vec4; 3]> {
    dark_cap(view, light, face(points))
}
