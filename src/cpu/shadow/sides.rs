//! Sides: the vertices of the quads that extend from silhouette edges away from the light.

use glam::Vec4;

use super::shadow::{
    behind_near_plane, corner, direction_to_clip, extrusion, far_end, on_near_plane, parallel_to_near_plane,
    project_to_near_plane, to_clip,
};
use super::zp_plus_2005::{counterpart, is_cut};
use crate::layout::{ShadowLight, ShadowView};

/// An end of an edge: index and position of its vertex.
pub type End = (u32, [f32; 3]);

/// The first and the second vertex, and the first and the second far vertex, in clip space.
pub fn side(view: &ShadowView, light: &ShadowLight, [first, second]: [End; 2]) -> [Vec4; 4] {
    let far = |position| far_end(view, light, position);
    [to_clip(view, first.1), to_clip(view, second.1), far(first.1), far(second.1)]
}

/// The polygon that remains of the side after clipping at the near plane, in clip space. It has up to five vertices, or
/// more only if rounding has moved a light onto the near plane. The shader draws the first five.
pub fn side_clipped(view: &ShadowView, light: &ShadowLight, [first, second]: [End; 2]) -> Vec<Vec4> {
    let p = corner(view, light, first.1);
    let q = corner(view, light, second.1);
    let (p_near, q_near) = (p.height >= 0.0, q.height >= 0.0);
    let (p_far, q_far) = (p.far_height >= 0.0, q.far_height >= 0.0);
    let (a, b) = if first.0 < second.0 { (&p, &q) } else { (&q, &p) };
    let offered = [
        p_near.then(|| behind_near_plane(view, p.near)),
        (p_near != q_near).then(|| on_near_plane(view, a, b)),
        q_near.then(|| behind_near_plane(view, q.near)),
        (q_near != q_far).then(|| project_to_near_plane(view, light, &q)),
        q_far.then_some(q.far),
        (p_far != q_far).then(|| parallel_to_near_plane(a, b)),
        p_far.then_some(p.far),
        (p_near != p_far).then(|| project_to_near_plane(view, light, &p)),
    ];
    offered.into_iter().flatten().collect()
}

/// The three quads of a side in ZP+ as published, each in the form of [`side`]: the side itself, and the corrective
/// quads of the paper's cases C1 and C2. A quad is `None` if its case does not apply.
pub fn zp_plus_2005_side(view: &ShadowView, light: &ShadowLight, ends: [End; 2]) -> [Option<[Vec4; 4]>; 3] {
    let near = ends.map(|(_, position)| to_clip(view, position));
    let far = ends.map(|(_, position)| direction_to_clip(view, extrusion(view, light, position)));
    let float = |nailed: [Vec4; 2]| {
        let moved = |end: usize| {
            let clip = nailed[end];
            if is_cut(view, clip) { counterpart(view, light, ends[end].1) } else { clip }
        };
        [moved(0), moved(1)]
    };
    let is_cut_in = |[a, b]: [Vec4; 2]| is_cut(view, a) != is_cut(view, b);
    let (cuts_edge, cuts_far) = (is_cut_in(near), is_cut_in(far));
    let quad = |[a, b]: [Vec4; 2], [c, d]: [Vec4; 2]| [a, b, c, d];
    [
        Some(quad(float(near), float(far))),
        (cuts_edge && !cuts_far).then(|| quad(near, float(near))),
        (!cuts_edge && cuts_far).then(|| quad(float(far), far)),
    ]
}
