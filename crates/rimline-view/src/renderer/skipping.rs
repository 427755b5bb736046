//! Levels of skipping as the library has them.

use rimline::gpu::Measuring;

use crate::state::options::Skipping;

/// Work that no picture needs: the levels of skipping that are off.
pub(super) fn measuring(skipping: Skipping) -> Measuring {
    // Receivers are culled by where depth is given.
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
