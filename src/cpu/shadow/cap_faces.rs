//! Cap faces: the vertices of light caps, dark caps and near caps.

use glam::{Vec2, Vec4, Vec4Swizzles};

use super::casting::has_near_cap;
use super::shadow::{
    behind_near_plane, corner, direction_to_clip, dot_3, extrusion, far_end, is_orthographic, light_side, near_plane,
    on_near_plane, parallel_to_near_plane, project_to_near_plane, to_clip,
};
use super::sides::End;
use super::zp_plus_2005::frustum_to_clip;
use crate::layout::{ShadowLight, ShadowView};

/// The vertices of a face at its place, in clip space.
pub fn light_cap(view: &ShadowView, face: [End; 3]) -> [Vec4; 3] {
    face.map(|(_, position)| to_clip(view, position))
}

/// The polygon that the eye sees in place of a face whose caster is not in the depth buffer, in clip space. It is like
/// [`light_cap`], but with ZP+ it ends on the near plane. It has up to four vertices.
pub fn seen_light_cap(view: &ShadowView, light: &ShadowLight, face: [End; 3]) -> Vec<Vec4> {
    if !has_near_cap(light) {
        return light_cap(view, face).to_vec();
    }
    let mut polygon = Vec::with_capacity(4);
    let corners = face.map(|(index, position)| (index, corner(view, light, position)));
    let [a, b, c] = corners;
    for [(a_index, a), (b_index, b)] in [[a, b], [b, c], [c, a]] {
        let (first, second) = if a_index < b_index { (&a, &b) } else { (&b, &a) };
        polygon.extend((a.height >= 0.0).then(|| behind_near_plane(view, a.near)));
        polygon.extend(((a.height >= 0.0) != (b.height >= 0.0)).then(|| on_near_plane(view, first, second)));
    }
    polygon
}

/// The vertices of a face at the far end of the volume, in clip space. `None` if the face is at infinity and out of
/// sight there. An orthographic camera sees such a face over the whole picture or not at all; see docs/numerics/rasterisers.md,
/// "Dark caps of orthographic cameras".
pub fn dark_cap(view: &ShadowView, light: &ShadowLight, face: [End; 3]) -> Option<[Vec4; 3]> {
    if is_orthographic(view) && light.end == 0.0 {
        return all_or_nothing(view, light, face);
    }
    Some(face.map(|(_, position)| far_end(view, light, position)))
}

/// Whether the camera's direction is left of the edge between two far vertices, as seen from the light. The vertex of
/// lower index comes first, so that the faces on both sides of the edge agree.
fn is_left((a_index, a): (u32, Vec2), (b_index, b): (u32, Vec2)) -> bool {
    if a_index < b_index { a.x * b.y - a.y * b.x >= 0.0 } else { b.x * a.y - b.y * a.x < 0.0 }
}

fn all_or_nothing(view: &ShadowView, light: &ShadowLight, face: [End; 3]) -> Option<[Vec4; 3]> {
    let [a, b, c] = face.map(|(_, position)| extrusion(view, light, position));
    let far = [(face[0].0, a), (face[1].0, b), (face[2].0, c)];
    let [(i, p), (j, q), (k, r)] = far.map(|(index, away)| (index, direction_to_clip(view, away).xy()));
    let left = is_left((i, p), (j, q));
    if left != is_left((j, q), (k, r)) || left != is_left((k, r), (i, p)) {
        return None;
    }
    let along = a * (q.x * r.y - q.y * r.x) + b * (r.x * p.y - r.y * p.x) + c * (p.x * q.y - p.y * q.x);
    if (dot_3(near_plane(view).0, along) > 0.0) != left {
        return None;
    }
    let corner = |x, y| Vec4::new(x, y, 1.0 - view.near_z, 1.0);
    let (second, third) = (corner(3.0, -1.0), corner(-1.0, 3.0));
    Some(if left { [corner(-1.0, -1.0), second, third] } else { [corner(-1.0, -1.0), third, second] })
}

/// The part of a face between the light and the near plane, projected from the light onto the near plane, in clip
/// space. It has up to five vertices, or more only if rounding has moved a light onto the near plane. The shader draws
/// the first five.
pub fn near_cap(view: &ShadowView, light: &ShadowLight, face: [End; 3]) -> Vec<Vec4> {
    let corners = face.map(|(index, position)| (index, corner(view, light, position)));
    let [a, b, c] = corners;
    let mut polygon = Vec::with_capacity(5);
    for [(a_index, a), (b_index, b)] in [[a, b], [b, c], [c, a]] {
        let a_above = a.height >= 0.0;
        let a_rises = a.far_height >= 0.0;
        let (first, second) = if a_index < b_index { (&a, &b) } else { (&b, &a) };
        let meeting = (a_above != (b.height >= 0.0)).then(|| on_near_plane(view, first, second));
        let turning = (a_rises != (b.far_height >= 0.0)).then(|| parallel_to_near_plane(first, second));
        polygon.extend((a_above != a_rises).then(|| project_to_near_plane(view, light, &a)));
        if a_above == (light_side(light) > 0.0) {
            polygon.extend(turning.into_iter().chain(meeting));
        } else {
            polygon.extend(meeting.into_iter().chain(turning));
        }
    }
    polygon
}

/// The near cap of ZP+ as published: the face transformed by the matrix of the light's frustum. The hardware clips it.
pub fn zp_plus_2005_cap(view: &ShadowView, light: &ShadowLight, face: [End; 3]) -> [Vec4; 3] {
    face.map(|(_, position)| frustum_to_clip(view, light, position))
}
