//! The margins of shadow volumes: where a rounding more or less decides whether something is skipped, where volumes end,
//! and what no count exceeds. Each against `f64` or counting by hand, written apart from `src/` and `wgsl/`.

mod boxes;
mod counts;
mod near_plane;
mod ranges;
pub(crate) mod view;

use rimline_testkit::harness::Test;

pub(crate) fn tests() -> Vec<Test> {
    [boxes::TESTS, counts::TESTS, near_plane::TESTS, ranges::TESTS].concat()
}
