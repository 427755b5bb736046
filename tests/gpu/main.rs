//! GPU tests. Without an adapter they fail; they are never passed over.

mod assets;
mod clipped;
mod closure;
#[path = "../common/mod.rs"]
mod common;
mod dark_caps;
mod deform;
mod draw;
mod exact;
mod facing;
mod include;
mod lights;
mod limits;
mod pipelines;
mod positions;
mod refusals;
mod shadow_chain;
mod shadow_query;
mod shadow_refusals;
mod shadow_stages;
mod stages;
mod stress;

use libtest_mimic::{Arguments, Failed, Trial};

/// A test's name and body.
type Test = (&'static str, fn() -> Result<(), String>);

fn main() {
    let tests: Vec<Test> = [
        stages::TESTS,
        exact::TESTS,
        facing::TESTS,
        closure::TESTS,
        stress::TESTS,
        lights::TESTS,
        positions::TESTS,
        deform::TESTS,
        include::TESTS,
        draw::TESTS,
        limits::TESTS,
        refusals::TESTS,
        shadow_stages::TESTS,
        shadow_chain::TESTS,
        clipped::TESTS,
        dark_caps::TESTS,
        shadow_query::TESTS,
        shadow_refusals::TESTS,
        pipelines::TESTS,
    ]
    .concat();
    let name = common::device::Gpu::shared().map_or_else(|error| error, |gpu| gpu.name.clone());
    println!("adapter: {name}");
    let trial = |(name, test): Test| Trial::test(name, move || test().map_err(Failed::from)).with_kind("gpu");
    let mut trials: Vec<Trial> = tests.into_iter().map(trial).collect();
    trials.extend(assets::trials());
    println!("gpu tests: {}", trials.iter().filter(|trial| !trial.has_ignored_flag()).count());
    let conclusion = libtest_mimic::run(&Arguments::from_args(), trials);
    common::device::Gpu::close();
    conclusion.exit();
}
