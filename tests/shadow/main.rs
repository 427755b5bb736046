//! Shadows against rays. Without an adapter these tests fail; they are never passed over.

mod cameras;
mod classes;
#[path = "../common/mod.rs"]
mod common;
mod compare;
mod hairlines;
mod nested;
mod overflow;
mod paper;
mod query;
mod range;
mod rays;
mod render;
mod samples;
mod scene;
mod skinned;
mod trials;

use libtest_mimic::{Arguments, Failed, Trial};

use crate::classes::CLASSES;
use crate::common::device::Gpu;

fn main() {
    let name = Gpu::shared().map_or_else(|error| error, |gpu| gpu.name.clone());
    println!("adapter: {name}");
    let mut trials = Vec::new();
    for class in CLASSES {
        let run = move || trials::right(class).map_err(Failed::from);
        trials.push(Trial::test(class.name, run).with_kind("gpu"));
    }
    for &(name, test) in trials::TESTS
        .iter()
        .chain(paper::TESTS)
        .chain(range::TESTS)
        .chain(nested::TESTS)
        .chain(overflow::TESTS)
        .chain(hairlines::TESTS)
        .chain(query::TESTS)
        .chain(cameras::TESTS)
        .chain(skinned::TESTS)
    {
        trials.push(Trial::test(name, move || test().map_err(Failed::from)).with_kind("gpu"));
    }
    let known = move || nested::on_surface().map_err(Failed::from);
    trials.push(Trial::test("lights_on_a_surface (known to be wrong)", known).with_kind("gpu").with_ignored_flag(true));
    for &(test_name, test) in samples::TESTS {
        let trial = Trial::test(test_name, move || test().map_err(Failed::from)).with_kind("gpu");
        // OpenGL reads zeros for the stencil values of several samples.
        trials.push(trial.with_ignored_flag(name.ends_with("(Gl)")));
    }
    println!("gpu tests: {}", trials.iter().filter(|trial| !trial.has_ignored_flag()).count());
    let conclusion = libtest_mimic::run(&Arguments::from_args(), trials);
    Gpu::close();
    conclusion.exit();
}
