//! Paper cases: where ZP+ as published leaves a caster and a light to z-fail.

use crate::layout::{ShadowLight, ShadowView};

/// Whether the near plane cuts both finite edges of one of the sides of `silhouettes`, by the positions of their ends:
/// the mesh's edge and the far one (case D of Hornus et al. 2005, section 5).
pub fn paper_cases(
    view: &ShadowView,
    light: &ShadowLight,
    silhouettes: impl IntoIterator<Item = [[f32; 3]; 2]>,
) -> bool {
    let [x, y, z, w] = light.light;
    let is_cut_at = |position| is_cut(view, to_clip(view, position));
    let is_far_cut =
        |[px, py, pz]: [f32; 3]| is_cut(view, direction_to_clip(view, [w * px - x, w * py - y, w * pz - z]));
    silhouettes.into_iter().any(|[a, b]| is_cut_at(a) != is_cut_at(b) && is_far_cut(a) != is_far_cut(b))
}

fn is_cut(view: &ShadowView, [_, _, z, w]: [f32; 4]) -> bool {
    w <= 0.0 || if view.near_z == 0.0 { z < 0.0 } else { z > w }
}

fn to_clip(view: &ShadowView, [x, y, z]: [f32; 3]) -> [f32; 4] {
    let [from_x, from_y, from_z] = view.origin;
    let clip = direction_to_clip(view, [x - from_x, y - from_y, z - from_z]);
    let [_, _, _, last] = view.view_projection;
    std::array::from_fn(|row| clip[row] + last[row])
}

fn direction_to_clip(view: &ShadowView, [x, y, z]: [f32; 3]) -> [f32; 4] {
    let [first, second, third, _] = view.view_projection;
    std::array::from_fn(|row| first[row] * x + second[row] * y + third[row] * z)
}
