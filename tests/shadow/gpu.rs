//! Shadow volumes on the GPU: pictures against rays, stages against oracles and goldens. Without an adapter these tests
//! fail; they are never passed over.

mod cameras;
mod compare;
mod culled;
mod hairlines;
mod in_scene;
mod levels;
mod margins;
mod mixed;
mod most_turns;
mod nested;
mod overflow;
mod passes;
mod polygons;
mod proxies;
mod range;
mod rays;
mod receivers;
mod refusals;
mod render;
mod samples;
mod thousands;
mod trials;
mod twisted;
mod vertices;

use libtest_mimic::{Failed, Trial};
use rimline_testkit::frame_classes::CLASSES;
use rimline_testkit::harness;

fn main() {
    let right = |class: &'static _| move || trials::right(class).map_err(Failed::from);
    let mut all: Vec<_> = CLASSES.iter().map(|class| Trial::test(class.name, right(class)).with_kind("gpu")).collect();
    let tests = [
        trials::TESTS,
        range::TESTS,
        nested::TESTS,
        overflow::TESTS,
        hairlines::TESTS,
        in_scene::TESTS,
        thousands::TESTS,
        passes::TESTS,
        proxies::TESTS,
        polygons::TESTS,
        twisted::TESTS,
        culled::TESTS,
        receivers::TESTS,
        levels::TESTS,
        mixed::TESTS,
        cameras::TESTS,
        most_turns::TESTS,
        vertices::TESTS,
        &margins::tests(),
        refusals::TESTS,
    ];
    all.extend(harness::gpu_trials(tests.concat()));
    // OpenGL reads zeros for the stencil values of several samples.
    let is_gl = harness::adapter_name().ends_with("(Gl)");
    let samples = harness::gpu_trials(samples::TESTS.iter().copied());
    all.extend(samples.into_iter().map(|trial| trial.with_ignored_flag(is_gl)));
    harness::run(all);
}
