//! Queries of occluder counts on the GPU. Without an adapter these tests fail; they are never passed over.

mod shadow_query;

use rimline_testkit::harness;

fn main() {
    harness::run(harness::gpu_trials(shadow_query::TESTS.iter().copied()));
}
