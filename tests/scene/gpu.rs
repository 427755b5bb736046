//! Scenes of many casters on the GPU. Without an adapter these tests fail; they are never passed over.

mod cached;
mod closure;
mod cluster_decisions;
mod clusters;
mod cones;
mod crowd;
mod exact;
mod found;
mod frames;
mod histories;
mod left_out;
mod needs;
mod occluded;
mod occluded_faces;
mod random_scene;
mod refusals;
mod scenes;
mod zero;

use rimline_testkit::harness;

fn main() {
    let tests = [
        scenes::TESTS,
        closure::TESTS,
        clusters::TESTS,
        cluster_decisions::TESTS,
        exact::TESTS,
        frames::TESTS,
        occluded_faces::TESTS,
        histories::TESTS,
        left_out::TESTS,
        cached::TESTS,
        needs::TESTS,
        occluded::TESTS,
        cones::TESTS,
        refusals::TESTS,
        zero::TESTS,
    ];
    harness::run(harness::gpu_trials(tests.concat()));
}
