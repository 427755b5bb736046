//! The light's frustum of ZP+ as published (Hornus et al. 2005). The WGSL is `wgsl/shadow/vertices.wgsl`.

use glam::{Vec3, Vec4};

use super::shadow::{dot_3, light_side, near_plane, placed};
use crate::layout::{ShadowLight, ShadowView};

/// A position transformed by the matrix of the light's frustum: x, y and w.
fn in_frustum(view: &ShadowView, light: &ShadowLight, position: [f32; 3]) -> Vec3 {
    let q = placed(view, position);
    let row = |[x, y, z, w]: [f32; 4]| dot_3(Vec3::new(x, y, z), q) + w;
    Vec3::new(row(light.frustum_x), row(light.frustum_y), row(light.frustum_w))
}

/// The same position in clip space, with a depth by which the hardware clips.
pub(crate) fn frustum_to_clip(view: &ShadowView, light: &ShadowLight, position: [f32; 3]) -> Vec4 {
    let p = in_frustum(view, light, position);
    let z = if light.light[3] == 0.0 {
        let (normal, constant) = near_plane(view);
        let height = dot_3(normal, placed(view, position)) + constant;
        p.z * (1.0 - light_side(light) * height / light.frustum_near)
    } else {
        let near_w = view.near_w * light.height.abs();
        (p.z - light.frustum_near * near_w) / (1.0 - light.frustum_near)
    };
    Vec4::new(p.x, p.y, z, p.z)
}

/// The vertex of the near cap that corresponds to a vertex.
pub(crate) fn counterpart(view: &ShadowView, light: &ShadowLight, position: [f32; 3]) -> Vec4 {
    let p = in_frustum(view, light, position);
    Vec4::new(p.x, p.y, p.z * view.near_z, p.z)
}

/// Whether a vertex is on the eye's side of the near plane.
pub(crate) fn is_cut(view: &ShadowView, clip: Vec4) -> bool {
    clip.w <= 0.0 || if view.near_z == 0.0 { clip.z < 0.0 } else { clip.z > clip.w }
}
