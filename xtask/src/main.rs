//! Rimline's set-up and its commands: pictures, tests, and what continuous integration checks.

mod ci;
mod circles;
mod demo;
mod drivers;
mod features;
mod fuzz;
mod mutants;
mod packages;
mod process;
mod summary;
mod test;
mod vulkan;
mod web;
mod wgsl;
mod words;

use std::process::ExitCode;

const HELP: &str = "\
Rimline's commands

Usage: cargo xtask COMMAND

Commands:
  demo     Make a walking figure and other models by code, and draw their outlines, lines and shadows to files in demo/
  test     Run every test; ends with a line `N passed, N failed, N skipped`. With --drivers: run the tests that compare
           bits, on every driver of this machine (lavapipe, SwiftShader, OpenGL, a GPU's own). With --long [TARGET [TEXT]]:
           with the long trials, hours in all; TARGET is one such as shadow_gpu, TEXT a part of a test's name
  circles  Check that no modules of a crate import one another in a circle
  ci       Check format, lints, documentation and circles, then do what `test` does, then check the WGSL with other
           compilers, the bits on SwiftShader, then fuzz for 10 seconds a target
  fuzz     Feed mutated files, WGSL and arguments to what reads them; --seconds N for each target (60)
  web      Build the viewer as a page in target/web; --test tries it in headless Chromium, too
  mutants  Make the code wrong in a copy, in one place after the other, and tell which tests notice; --only TEXT for
           those whose names have it; --quick to end at the first test that notices (an hour instead of several)

demo, test and ci need a Vulkan driver on Linux. Where there is none, they install Mesa's software driver through the
system's package manager if that needs no password, and otherwise print the command that does.

Options:
  -h, --help  Print this
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments.as_slice() {
        ["-h" | "--help" | "help"] | [_, "-h" | "--help"] => {
            print!("{HELP}");
            ExitCode::SUCCESS
        }
        ["demo"] => finish(demo::run()),
        ["test"] => counted(test::add),
        ["test", "--long"] => counted(|all| test::add_long(all, None, None)),
        ["test", "--long", target] => counted(|all| test::add_long(all, Some(target), None)),
        ["test", "--long", target, filter] => counted(|all| test::add_long(all, Some(target), Some(filter))),
        ["test", "--drivers"] => counted(drivers::add_all),
        ["circles"] => finish(circles::run()),
        ["ci"] => counted(ci::add),
        ["fuzz"] => counted(|all| fuzz::add(all, 60, &[])),
        ["fuzz", "--seconds", seconds] => match seconds.parse() {
            Ok(seconds) => counted(|all| fuzz::add(all, seconds, &[])),
            Err(_) => misused(&format!("`--seconds {seconds}` is no number")),
        },
        ["web"] => finish(web::build().map(drop)),
        ["web", "--test"] => counted(test::add_page),
        ["mutants"] => finish(mutants::run(None, false)),
        ["mutants", "--quick"] => finish(mutants::run(None, true)),
        ["mutants", "--only", text] => finish(mutants::run(Some(text), false)),
        ["mutants", "--quick", "--only", text] | ["mutants", "--only", text, "--quick"] => {
            finish(mutants::run(Some(text), true))
        }
        ["test" | "fuzz" | "web" | "mutants", rest @ ..] => misused(&format!("unknown arguments `{}`", rest.join(" "))),
        [] => misused("no command given"),
        [command @ ("demo" | "circles" | "ci"), rest @ ..] => {
            misused(&format!("`{command}` takes no arguments, but was given `{}`", rest.join(" ")))
        }
        [command, ..] => misused(&format!("unknown command `{command}`")),
    }
}

fn counted(add: impl FnOnce(&mut summary::Summary)) -> ExitCode {
    let mut summary = summary::Summary::default();
    add(&mut summary);
    summary.finish()
}

fn finish(outcome: Result<(), String>) -> ExitCode {
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn misused(error: &str) -> ExitCode {
    eprintln!("error: {error}\n\n{HELP}");
    ExitCode::from(2)
}
