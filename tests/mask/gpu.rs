//! Shadow masks of scenes against the stencil that a caller would draw, bit for bit. `tests/shadow/` compares stencils
//! with rays.
//!
//! The stage is `shadow_masks`.

mod copied;
mod drawn;
mod frames;
mod partial;
mod refusals;
mod same;
mod world;

use rimline_testkit::harness::{self, Test};

fn main() {
    let tests: [&[Test]; 5] = [same::TESTS, copied::TESTS, frames::TESTS, partial::TESTS, refusals::TESTS];
    harness::run(harness::gpu_trials(tests.concat()));
}
