//! The deform stage on the GPU. Without an adapter these tests fail; they are never passed over.

mod many_terms;
mod poser;
mod stage;
mod zero;

use rimline_testkit::harness;

fn main() {
    let mut trials = harness::gpu_trials([stage::TESTS, poser::TESTS, many_terms::TESTS, zero::TESTS].concat());
    trials.extend(poser::trials());
    harness::run(trials);
}
