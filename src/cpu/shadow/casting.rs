//! The faces that cast, and what their caps count. The WGSL is `wgsl/shadow/casting.wgsl`.

use super::shadow::light_side;
use crate::layout::ShadowLight;
use crate::shadow::{CAST_AVERTED, CAST_EVERY, COUNT_ZP_PLUS, COUNT_ZP_PLUS_2005};

/// Whether a face casts.
pub fn casts(light: &ShadowLight, facing: bool) -> bool {
    light.casting == CAST_EVERY || (light.casting == CAST_AVERTED && !facing)
}

/// A light has four lists of cap faces: near caps of both classes, and other caps of both classes.
pub const LISTS: usize = 4;

pub(crate) fn has_near_cap(light: &ShadowLight) -> bool {
    matches!(light.counting, COUNT_ZP_PLUS | COUNT_ZP_PLUS_2005)
}

/// 0 if the cap counts up where its front is seen, 1 if it does where its back is seen. With ZP+ caps lie on the near
/// plane. There the front of a face that faces the light is seen if the light is on the eye's side.
pub fn cap_class(light: &ShadowLight, facing: bool) -> u32 {
    let turned = has_near_cap(light) && light_side(light) > 0.0;
    u32::from(facing == turned)
}

/// The list of the face's cap.
pub fn cap_kind(light: &ShadowLight, facing: bool) -> usize {
    cap_class(light, facing) as usize + if has_near_cap(light) { 0 } else { 2 }
}
