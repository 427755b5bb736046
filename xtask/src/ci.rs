//! `cargo xtask ci`: what a change has to pass.

use std::process::Command;

use crate::summary::Summary;
use crate::test::BENCH;
use crate::{circles, drivers, fuzz, process, test, wgsl, words};

/// Every check runs, also after one that failed, so that one run shows all there is to mend.
pub(crate) fn add(summary: &mut Summary) {
    let everything = ["--workspace", "--exclude", BENCH, "--all-features"];
    if is_installed(summary, "fmt") {
        summary.check("format", process::run(&mut process::cargo(["fmt", "--all", "--check"])));
    }
    if is_installed(summary, "clippy") {
        let mut clippy = process::cargo(["clippy", "--all-targets"]);
        clippy.args(everything).args(["--", "--deny", "warnings"]);
        summary.check("lints", process::run(&mut clippy));
    }
    let mut documentation: Command = process::cargo(["doc", "--no-deps"]);
    documentation.args(everything).env("RUSTDOCFLAGS", "-D warnings");
    summary.check("documentation", process::run(&mut documentation));
    summary.check("module circles", circles::run());
    summary.check("words of comments and names", words::run());
    test::add(summary);
    drivers::add_swiftshader(summary);
    wgsl::add(summary);
    // With the tests in the same build, packages have the features that these were built with, so that none is built again.
    fuzz::add(summary, 10, &["--tests"]);
}

/// A minimal toolchain lacks some of cargo's commands; that is said at the end, and no error.
fn is_installed(summary: &mut Summary, command: &str) -> bool {
    let found = process::output(&mut process::cargo([command, "--version"])).is_ok();
    if !found {
        summary.note(&format!("cargo {command} is not installed, so it checked nothing"));
    }
    found
}
