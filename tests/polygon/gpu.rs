//! Polygons on the GPU. Without an adapter these tests fail; they are never passed over.

mod lights;
mod stages;

use rimline_measure::harness;

fn main() {
    harness::run(harness::gpu_trials(stages::TESTS.iter().copied()));
}
