//! Scenes of many casters on the GPU. Without an adapter these tests fail; they are never passed over.

mod closure;
#[path = "../mesh/cluster_meshes.rs"]
mod cluster_meshes;
mod clusters;
mod cones;
mod crowd;
mod exact;
mod found;
mod frames;
mod hidden;
mod histories;
mod kept;
mod lists;
mod needs;
mod occluded;
mod random_scene;
mod refusals;
mod scenes;
mod stages;
mod zero;

use rimline_measure::harness;

fn main() {
    let tests = [
        scenes::TESTS,
        closure::TESTS,
        clusters::TESTS,
        exact::TESTS,
        stages::TESTS,
        frames::TESTS,
        hidden::TESTS,
        histories::TESTS,
        kept::TESTS,
        needs::TESTS,
        occluded::TESTS,
        cones::TESTS,
        refusals::TESTS,
        zero::TESTS,
    ];
    harness::run(harness::gpu_trials(tests.concat()));
}
