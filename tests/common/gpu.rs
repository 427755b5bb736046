//! What all subjects share on the GPU. Without an adapter these tests fail; they are never passed over.

mod pipelines;

use rimline_measure::harness;

fn main() {
    harness::run(harness::gpu_trials(pipelines::TESTS.iter().copied()));
}
