//! Choices for the lights of a caster, as the stages keep them. The WGSL is `wgsl/shadow/choices.wgsl`.

use rimline::internals::layout::{ShadowLight, ShadowShape, ViewLight};
use rimline::internals::scene::CHOICE_WORDS;
use rimline::internals::shadow::{
    CAST_BACK_FACING, CAST_EVERY, CAST_NOTHING, COUNT_Z_FAIL, COUNT_Z_PASS, COUNT_ZP_PLUS, COUNT_ZP_PLUS_2005,
};

/// The lights of a single caster and view, with the choices that `counting_methods` left in `words`. Draws leave out near
/// caps where `CHOICE_LISTED_NEAR_CAP` is not set, too, which this does not read. Words that are missing count as 0.
pub fn chosen(shape: &ShadowShape, seen: &[ViewLight], words: &[u32]) -> Vec<ShadowLight> {
    let word = |at: usize| words.get(at).copied().unwrap_or(0);
    let light = |(number, seen): (usize, &ViewLight)| {
        let is_set = |kind: usize| word(CHOICE_WORDS * (number / 32) + kind) >> (number % 32) & 1 != 0;
        let [casts, every, near, excludes] = [0, 1, 2, 4].map(is_set);
        let mut light = seen.light;
        (light.casting, light.counting, light.excludes) = (CAST_NOTHING, COUNT_Z_PASS, 0);
        if casts {
            light.casting = if every { CAST_EVERY } else { CAST_BACK_FACING };
            light.excludes = u32::from(excludes);
            light.counting = match (shape.counting, near) {
                (COUNT_ZP_PLUS_2005, true) => COUNT_ZP_PLUS_2005,
                (COUNT_ZP_PLUS_2005, false) | (COUNT_Z_FAIL, _) => COUNT_Z_FAIL,
                (_, true) => COUNT_ZP_PLUS,
                (_, false) => COUNT_Z_PASS,
            };
        }
        if casts && (shape.end_at_range != 0 || shape.counting == COUNT_ZP_PLUS_2005) {
            let measures = CHOICE_WORDS * shape.batches as usize + 2 * number;
            [light.end, light.frustum_near] = [0, 1].map(|measure| f32::from_bits(word(measures + measure)));
        }
        light
    };
    seen.iter().enumerate().map(light).collect()
}
