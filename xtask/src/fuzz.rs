//! `cargo xtask fuzz`.

use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::process;
use crate::summary::Summary;
use crate::test::BENCH;

const TARGETS: [&str; 7] = ["gltf", "npz", "obj", "ply", "stl", "wgsl", "args"];
/// A case that takes longer hangs. Software devices on a busy machine take seconds.
const SLOW_SECONDS: &str = "20";

/// Fuzzes each target for that long, and counts a check each in `summary`. The program is built together with others.
pub(crate) fn add(summary: &mut Summary, seconds: u64, and: &[&str]) {
    let mut build = process::cargo(["build", "--workspace", "--exclude", BENCH, "--all-features"]);
    build.args(["--bin", "rimline-fuzz", "--bin", "rimline"]).args(and);
    if let Err(error) = process::run(&mut build) {
        summary.fail(&error);
        return;
    }
    let program = process::built("rimline-fuzz");
    // A target keeps one core busy.
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let next = AtomicUsize::new(0);
    let worker = || {
        let mut done = Vec::new();
        while let Some(&name) = TARGETS.get(next.fetch_add(1, Ordering::Relaxed)) {
            done.push((name, fuzz(&program, name, seconds)));
        }
        done
    };
    let done = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..cores.min(TARGETS.len())).map(|_| scope.spawn(worker)).collect();
        workers.into_iter().map(std::thread::ScopedJoinHandle::join).collect::<Vec<_>>()
    });
    let done: Vec<_> = done.into_iter().flat_map(Result::unwrap_or_default).collect();
    for name in TARGETS {
        let worked = done.iter().find(|(target, _)| *target == name);
        let (last, outcome) =
            worked.map_or_else(|| (String::new(), Err("it panicked".to_owned())), |worked| worked.1.clone());
        summary.note(&last);
        summary.check(&format!("fuzzing of {name}"), outcome);
    }
}

/// Fuzzes one target. Its last line, and whether there were no findings.
fn fuzz(program: &Path, name: &str, seconds: u64) -> (String, Result<(), String>) {
    let out = process::target().join("fuzz");
    let mut fuzz = Command::new(program);
    fuzz.args(["--target", name, "--seconds", &seconds.to_string(), "--slow", SLOW_SECONDS, "--out"]).arg(&out);
    let mut last = String::new();
    let outcome = match process::run_looking(&mut fuzz, |line| line.clone_into(&mut last)) {
        Ok(true) => Ok(()),
        Ok(false) => Err(format!("there are findings in {}", out.display())),
        Err(error) => Err(error),
    };
    (last, outcome)
}
