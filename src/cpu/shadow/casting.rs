//! The faces that cast, and what their caps count. The WGSL is `wgsl/shadow/lists.wgsl`.

use super::shadow::light_side;
use crate::layout::ShadowLight;
use crate::shadow::{CAST_AVERTED, CAST_EVERY, COUNT_Z_FAIL, COUNT_ZP_PLUS, COUNT_ZP_PLUS_2005};

/// Whether a face casts.
pub fn casts(light: &ShadowLight, facing: bool) -> bool {
    light.casting == CAST_EVERY || (light.casting == CAST_AVERTED && !facing)
}

/// A light has four lists of cap faces: near caps of both classes, and other caps of both classes.
pub const LISTS: usize = 4;

pub(crate) fn has_near_cap(light: &ShadowLight) -> bool {
    matches!(light.counting, COUNT_ZP_PLUS | COUNT_ZP_PLUS_2005)
}

/// Whether there are caps besides near caps: with z-fail, where the volume ends, and where the caster is not in the depth
/// buffer, so that the eye sees through its faces.
pub fn has_far_caps(light: &ShadowLight, in_depth: bool) -> bool {
    light.counting == COUNT_Z_FAIL || light.end > 0.0 || !in_depth
}

/// The list of the face's near cap: 0 if the cap counts up where its front is seen, 1 if it does where its back is seen. On the
/// near plane the front of a face that faces the light is seen if the light is on the eye's side.
pub fn near_kind(light: &ShadowLight, facing: bool) -> usize {
    usize::from(facing == (light_side(light) > 0.0))
}

/// The list of the face's other caps: 2 if they count up where the front is seen, 3 if they do where the back is seen.
pub fn far_kind(facing: bool) -> usize {
    if facing { 2 } else { 3 }
}
