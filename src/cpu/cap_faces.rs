//! Cap faces: the vertices of light caps, dark caps and near caps.

use glam::Vec4;

use super::paper::frustum_to_clip;
use super::shadow::{corner, far_end, light_side, on_near_plane, parallel_to_near_plane, star, to_clip};
use super::sides::End;
use crate::layout::{ShadowLight, ShadowView};

/// A face at its place, in clip space.
pub fn light_cap(view: &ShadowView, face: [End; 3]) -> [Vec4; 3] {
    face.map(|(_, position)| to_clip(view, position))
}

/// A face at the volume's far end, in clip space.
pub fn dark_cap(view: &ShadowView, light: &ShadowLight, face: [End; 3]) -> [Vec4; 3] {
    face.map(|(_, position)| far_end(view, light, position))
}

/// What of a face lies between the light and the near plane, seen from the light on the near plane, in clip space: up to
/// five vertices, more only where rounding has a light on the near plane. The shader draws the first five.
pub fn near_cap(view: &ShadowView, light: &ShadowLight, face: [End; 3]) -> Vec<Vec4> {
    let corners = face.map(|(index, position)| (index, corner(view, light, position)));
    let [a, b, c] = corners;
    let mut polygon = Vec::with_capacity(5);
    for [(a_index, a), (b_index, b)] in [[a, b], [b, c], [c, a]] {
        let a_above = a.height >= 0.0;
        let a_rises = a.rise >= 0.0;
        let (first, second) = if a_index < b_index { (&a, &b) } else { (&b, &a) };
        let meeting = (a_above != (b.height >= 0.0)).then(|| on_near_plane(view, first, second));
        let turning = (a_rises != (b.rise >= 0.0)).then(|| parallel_to_near_plane(first, second));
        polygon.extend((a_above != a_rises).then(|| star(view, light, &a)));
        if a_above == (light_side(light) > 0.0) {
            polygon.extend(turning.into_iter().chain(meeting));
        } else {
            polygon.extend(meeting.into_iter().chain(turning));
        }
    }
    polygon
}

/// The near cap of ZP+ as published: the face by the matrix of the light's frustum, for the hardware to clip.
pub fn paper_cap(view: &ShadowView, light: &ShadowLight, face: [End; 3]) -> [Vec4; 3] {
    face.map(|(_, position)| frustum_to_clip(view, light, position))
}
