//! `cargo xtask test`.

use std::process::Command;

use crate::packages::Manager;
use crate::summary::Summary;
use crate::{features, process, vulkan, web};

/// The member that needs a C++ compiler and is measured, not tested.
pub(crate) const BENCH: &str = "rimline-bench-adjacency";

/// Every test of the workspace.
const EVERYTHING: [&str; 6] = ["test", "--workspace", "--exclude", BENCH, "--all-features", "--no-fail-fast"];

/// Runs every test, or those of a target whose names have a text, with the long trials among them.
pub(crate) fn add_long(summary: &mut Summary, target: Option<&str>, filter: Option<&str>) {
    ensure_driver(summary);
    let mut command = process::cargo(EVERYTHING);
    command.env("RIMLINE_LONG", "1").args(target.iter().flat_map(|target| ["--test", target]));
    run_tests(command.arg("--").args(filter), summary, target.is_none());
}

/// Builds the page, and tries it in a browser.
pub(crate) fn add_page(summary: &mut Summary) {
    ensure_driver(summary);
    ensure_display();
    let tested = web::build().and_then(|page| {
        let mut command = process::cargo(EVERYTHING);
        // The tables of the check are worth reading.
        command.env("RIMLINE_PAGE", page).args(["--test", "page", "--", "--nocapture"]);
        let succeeded = process::run_looking(&mut command, |line| summary.read(line))?;
        let failed = "the page does not pass in Chromium: see above (on Debian `apt-get install chromium`)";
        if succeeded { Ok(()) } else { Err(failed.to_owned()) }
    });
    if let Err(error) = tested {
        summary.fail(&error);
    }
}

/// Without a driver, tests that need none still have something to say.
pub(crate) fn ensure_driver(summary: &mut Summary) {
    if let Err(error) = vulkan::ensure() {
        println!("error: {error}");
        summary.fail(&error);
    }
}

/// Tests of windows need a display. Without one they fail, or are ignored by name where none can be installed.
fn ensure_display() {
    if !cfg!(target_os = "linux") || process::output(Command::new("Xvfb").arg("-help")).is_ok() {
        return;
    }
    if let Some(Err(error)) = Manager::of_this_system().map(|manager| manager.install("Xvfb", manager.xvfb)) {
        println!("note: {error}");
    }
}

/// Runs every test and counts it in `summary`.
pub(crate) fn add(summary: &mut Summary) {
    ensure_driver(summary);
    ensure_display();
    run_tests(&mut process::cargo(EVERYTHING), summary, true);
    features::add(summary);
}

/// Runs a command of tests and counts them in `summary`.
fn run_tests(command: &mut Command, summary: &mut Summary, needs_gpu_tests: bool) {
    let outcome = process::run_looking(command, |line| summary.read(line));
    if let Err(error) = &outcome {
        println!("error: {error}");
    }
    summary.tests_ended(outcome.unwrap_or(false), needs_gpu_tests);
}
