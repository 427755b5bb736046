//! Cases of ZP+ as published: where the method leaves a caster and a light to z-fail.

use super::shadow::{direction_to_clip, extrusion, to_clip};
use super::zp_plus_2005::is_cut;
use crate::layout::{ShadowLight, ShadowView};

/// Whether the near plane cuts both finite edges of a side: the mesh's edge and the far one (case D of Hornus et al.
/// 2005, section 5). `silhouettes` are the silhouette edges by the positions of their ends.
pub fn zp_plus_2005_cases(
    view: &ShadowView,
    light: &ShadowLight,
    silhouettes: impl IntoIterator<Item = [[f32; 3]; 2]>,
) -> bool {
    let is_cut_at = |position| is_cut(view, to_clip(view, position));
    let is_far_cut = |position| is_cut(view, direction_to_clip(view, extrusion(view, light, position)));
    silhouettes.into_iter().any(|[a, b]| is_cut_at(a) != is_cut_at(b) && is_far_cut(a) != is_far_cut(b))
}
