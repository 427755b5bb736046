//! The viewer's levels of skipping, as options of a scene.

use rimline::gpu::Measuring;

use crate::state::options::Skipping;

/// The levels that are off: the scene then does their work, which no picture needs.
pub(super) fn measuring(skipping: Skipping) -> Measuring {
    // Without `receivers` the renderer gives no `View::depth`, which has the same effect.
    let Skipping { range, view, casters, bits, lists, faces, receivers: _ } = skipping;
    let mut measuring = Measuring::default();
    for (level, is_on) in [
        (Measuring::CULLED_BY_RANGE, range),
        (Measuring::CULLED_BY_VIEW, view),
        (Measuring::CULLED_CASTERS, casters),
        (Measuring::CACHED_BITS, bits),
        (Measuring::CACHED_LISTS, lists),
        (Measuring::EVERY_FACE, faces),
    ] {
        measuring.set(level, !is_on);
    }
    measuring
}
