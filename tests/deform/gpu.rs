//! The deform stage on the GPU. Without an adapter these tests fail; they are never passed over.

mod stage;

use rimline_measure::harness;

fn main() {
    harness::run(harness::gpu_trials(stage::TESTS.iter().copied()));
}
