//! `cargo xtask fuzz`.

use std::process::Command;

use crate::process;
use crate::summary::Summary;
use crate::test::BENCH;

const TARGETS: [&str; 5] = ["gltf", "npz", "obj", "wgsl", "args"];
/// What continuous integration takes for each target.
pub(crate) const CI_SECONDS: u64 = 60;

/// A case that takes longer hangs. Software devices on a busy machine take seconds.
const SLOW_SECONDS: &str = "20";

/// Fuzzes each target for that long.
pub(crate) fn run(seconds: u64) -> Summary {
    let mut summary = Summary::default();
    add(&mut summary, seconds, &[]);
    summary
}

/// Fuzzes each target for that long after the tests, and counts a check each in `summary`. With the tests in the same build,
/// packages have the features that these were built with, so that none is built again.
pub(crate) fn add_after_tests(summary: &mut Summary, seconds: u64) {
    add(summary, seconds, &["--tests"]);
}

fn add(summary: &mut Summary, seconds: u64, and: &[&str]) {
    let mut build = process::cargo(["build", "--workspace", "--exclude", BENCH, "--all-features"]);
    build.args(["--bin", "rimline-fuzz", "--bin", "rimline"]).args(and);
    if let Err(error) = process::run(&mut build) {
        summary.fail(&error);
        return;
    }
    let target = process::target();
    let program = target.join("debug").join(format!("rimline-fuzz{}", std::env::consts::EXE_SUFFIX));
    for name in TARGETS {
        let mut fuzz = Command::new(&program);
        fuzz.args(["--target", name, "--seconds", &seconds.to_string(), "--slow", SLOW_SECONDS, "--out"]);
        fuzz.arg(target.join("fuzz"));
        let mut last = String::new();
        let outcome = process::run_looking(&mut fuzz, |line| line.clone_into(&mut last));
        let outcome = match outcome {
            Ok(true) => Ok(()),
            Ok(false) => Err(format!("there are findings in {}", target.join("fuzz").display())),
            Err(error) => Err(error),
        };
        summary.note(&last);
        summary.check(&format!("fuzzing of {name}"), outcome);
    }
}
