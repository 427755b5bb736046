//! Levels of skipping as the library has them.

use rimline::gpu::Measuring;

use crate::state::options::Skipping;

/// Work that no picture needs: the levels of skipping that are off.
pub(super) fn measuring(skipping: Skipping) -> Measuring {
    let Skipping { range, view, bits, lists, faces } = skipping;
    let mut measuring = Measuring::default();
    for (level, is_on) in [
        (Measuring::UNREACHED, range),
        (Measuring::UNSEEN, view),
        (Measuring::BITS, bits),
        (Measuring::LISTS, lists),
        (Measuring::EVERY_FACE, faces),
    ] {
        measuring.set(level, !is_on);
    }
    measuring
}
