//! Shadow masks of scenes: against the stencil that a caller would draw, bit for bit, and against rays in `f64`.
//!
//! The stage is `shadow_masks`.

mod copied;
mod drawn;
mod frames;
mod partial;
mod rays;
mod refusals;
mod same;
mod world;

use rimline_testkit::harness::{self, Test};

fn main() {
    let tests: [&[Test]; 6] = [same::TESTS, rays::TESTS, copied::TESTS, frames::TESTS, partial::TESTS, refusals::TESTS];
    harness::run(harness::gpu_trials(tests.concat()));
}
