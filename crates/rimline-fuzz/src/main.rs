//! Fuzzing of what Rimline reads. `cargo xtask fuzz` runs it; `cargo fuzz` would need a nightly compiler.
//!
//! The supervisor starts a worker with a bounded address space. A worker makes case after case from `--seed`, each from a
//! seed file made by code and mutated, and tells the number of each before it runs it. A case that panics, ends the
//! process, takes more than `--slow` seconds or needs more memory ends its worker; the supervisor makes the same case
//! again from its number, writes it to `--out`, and starts another worker after it.

mod options;
mod supervisor;
mod target;
mod targets;
mod worker;

use std::process::ExitCode;

use options::Options;

fn main() -> ExitCode {
    let options = match Options::parse(std::env::args().skip(1)) {
        Ok(options) => options,
        Err(error) => {
            eprintln!("error: {error}\n\n{}", options::USAGE);
            return ExitCode::from(2);
        }
    };
    let outcome = match options.worker_from {
        Some(first) => worker::run(&options, first),
        None => supervisor::run(&options),
    };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
