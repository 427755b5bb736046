//! Scenes of many casters on the GPU. Without an adapter these tests fail; they are never passed over.

mod cached;
mod closure;
#[path = "../extract/rounding/cluster_cases.rs"]
mod cluster_cases;
mod cluster_decisions;
#[path = "../mesh/cluster_meshes.rs"]
mod cluster_meshes;
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
#[path = "../extract/rounding/pairs.rs"]
mod pairs;
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
