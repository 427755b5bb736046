//! GPU tests that concern all subjects. Without an adapter these tests fail; they are never skipped.

mod other_devices;
mod pipelines;
mod reading;
mod requirements;
mod slivers;
mod warm_up;
mod watched;

use rimline_testkit::harness;

fn main() {
    let tests =
        [pipelines::TESTS, requirements::TESTS, other_devices::TESTS, reading::TESTS, slivers::TESTS, warm_up::TESTS];
    harness::run(harness::gpu_trials(tests.concat()));
}
