//! Polygons on the GPU. Without an adapter these tests fail; they are never passed over.

mod depths;
mod lights;
mod query_stages;
mod stages;
mod zero;

use rimline_measure::harness;

fn main() {
    harness::run(harness::gpu_trials(stages::TESTS.iter().chain(query_stages::TESTS).chain(zero::TESTS).copied()));
}
