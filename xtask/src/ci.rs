//! `cargo xtask ci`: what a change has to pass.

use std::process::Command;

use crate::summary::Summary;
use crate::test::BENCH;
use crate::{circles, drivers, fuzz, process, test, wgsl, words};

/// Every check runs, also after one that failed, so that one run shows all there is to mend.
pub(crate) fn run() -> Summary {
    let mut summary = Summary::default();
    let everything = ["--workspace", "--exclude", BENCH, "--all-features"];
    if is_installed(&mut summary, "fmt") {
        summary.check("format", process::run(&mut process::cargo(["fmt", "--all", "--check"])));
    }
    if is_installed(&mut summary, "clippy") {
        let mut clippy = process::cargo(["clippy", "--all-targets"]);
        clippy.args(everything).args(["--", "--deny", "warnings"]);
        summary.check("lints", process::run(&mut clippy));
    }
    let mut documentation: Command = process::cargo(["doc", "--no-deps"]);
    documentation.args(everything).env("RUSTDOCFLAGS", "-D warnings");
    summary.check("documentation", process::run(&mut documentation));
    summary.check("module circles", circles::run());
    summary.check("words of comments and names", words::run());
    test::add(&mut summary);
    drivers::add_swiftshader(&mut summary, &drivers::QUICK);
    wgsl::add(&mut summary);
    fuzz::add_after_tests(&mut summary, fuzz::CI_SECONDS);
    summary
}

/// A minimal toolchain lacks some of cargo's commands; that is said at the end, and no error.
fn is_installed(summary: &mut Summary, command: &str) -> bool {
    let found = process::output(&mut process::cargo([command, "--version"])).is_ok();
    if !found {
        summary.note(&format!("cargo {command} is not installed, so it checked nothing"));
    }
    found
}
