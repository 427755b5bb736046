//! The extraction's stages on the GPU. Without an adapter these tests fail; they are never passed over.

mod assets;
mod draw;
mod exact;
mod facing;
mod include;
mod limits;
mod positions;
mod read_edges;
mod refusals;
mod stages;

use rimline_testkit::harness;

fn main() {
    let tests = [
        stages::TESTS,
        exact::TESTS,
        facing::TESTS,
        positions::TESTS,
        include::TESTS,
        draw::TESTS,
        limits::TESTS,
        read_edges::TESTS,
        refusals::TESTS,
    ];
    let mut trials = harness::gpu_trials(tests.concat());
    trials.extend(assets::trials());
    harness::run(trials);
}
