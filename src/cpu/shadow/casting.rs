//! The faces that cast, and what their caps count. The WGSL is `wgsl/shadow/casting.wgsl`.

use super::shadow::light_side;
use crate::layout::ShadowLight;
use crate::shadow::{CAST_AVERTED, CAST_EVERY, COUNT_ZP_PLUS, COUNT_ZP_PLUS_2005};

/// Whether a face casts.
pub fn casts(light: &ShadowLight, facing: bool) -> bool {
    light.casting == CAST_EVERY || (light.casting == CAST_AVERTED && !facing)
}

/// A light has a list of cap faces for each class.
pub const LISTS: usize = 2;

/// 0 if the cap counts up where its front is seen, 1 if it does where its back is seen. With ZP+ caps lie on the near
/// plane. There the front of a face that faces the light is seen if the light is on the eye's side.
pub fn cap_class(light: &ShadowLight, facing: bool) -> u32 {
    let turned = matches!(light.counting, COUNT_ZP_PLUS | COUNT_ZP_PLUS_2005) && light_side(light) > 0.0;
    u32::from(facing == turned)
}
