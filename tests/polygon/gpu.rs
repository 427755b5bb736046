//! Polygons on the GPU. Without an adapter these tests fail; they are never passed over.

mod cut_limits;
mod depths;
mod lights;
mod limits;
mod pieces;
mod query_stages;
mod stages;
mod zero;

use rimline_testkit::harness;

fn main() {
    let tests = [stages::TESTS, pieces::TESTS, query_stages::TESTS, zero::TESTS, limits::TESTS, cut_limits::TESTS];
    harness::run(harness::gpu_trials(tests.into_iter().flatten().copied()));
}
