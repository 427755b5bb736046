//! Sides: the vertices of the quads from silhouette edges away from the light.

use glam::Vec4;

use super::shadow::{away, corner, direction_to_clip, on_near_plane, parallel_to_near_plane, star, to_clip};
use crate::layout::{ShadowLight, ShadowView};

/// An end of an edge: its vertex's index and position.
pub type End = (u32, [f32; 3]);

/// First, second, first far and second far vertex, in clip space.
pub fn side(view: &ShadowView, light: &ShadowLight, [first, second]: [End; 2]) -> [Vec4; 4] {
    let far = |position| direction_to_clip(view, away(light, position));
    [to_clip(view, first.1), to_clip(view, second.1), far(first.1), far(second.1)]
}

/// Depth that rounding may have put before the near plane.
fn behind_near_plane(view: &ShadowView, clip: Vec4) -> Vec4 {
    let z = if view.near_z == 0.0 { clip.z.max(0.0) } else { clip.z.min(clip.w) };
    Vec4::new(clip.x, clip.y, z, clip.w)
}

/// The polygon that the near plane leaves of the side, in clip space: up to five vertices, more only where rounding has a
/// light on the near plane. The shader draws the first five.
pub fn side_clipped(view: &ShadowView, light: &ShadowLight, [first, second]: [End; 2]) -> Vec<Vec4> {
    let p = corner(view, light, first.1);
    let q = corner(view, light, second.1);
    let (p_near, q_near) = (p.height >= 0.0, q.height >= 0.0);
    let (p_far, q_far) = (p.rise >= 0.0, q.rise >= 0.0);
    let (a, b) = if first.0 < second.0 { (&p, &q) } else { (&q, &p) };
    let offered = [
        p_near.then(|| behind_near_plane(view, p.near)),
        (p_near != q_near).then(|| on_near_plane(view, a, b)),
        q_near.then(|| behind_near_plane(view, q.near)),
        (q_near != q_far).then(|| star(view, light, &q)),
        q_far.then_some(q.far),
        (p_far != q_far).then(|| parallel_to_near_plane(a, b)),
        p_far.then_some(p.far),
        (p_near != p_far).then(|| star(view, light, &p)),
    ];
    offered.into_iter().flatten().collect()
}
