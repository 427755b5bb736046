//! The command `rimline`: extract silhouettes, draw outlines, count shadow depths, look into models and devices, measure.
#![allow(clippy::doc_markdown, reason = "clap prints doc comments as they are")]

mod args;
mod bench;
mod chart;
mod device;
mod devices;
mod displacement;
mod draw;
mod extract;
mod failure;
mod film;
mod gpu_error;
mod image;
mod info;
mod input;
mod load_args;
mod moment;
mod npz;
mod output;
mod page;
mod positions;
mod progress;
mod query;
mod rays;
mod render;
mod shadow;
mod spec;
mod times;
mod verify;

use std::process::ExitCode;

use clap::Parser;

use crate::args::{Cli, Command};
use crate::failure::Failure;

fn main() -> ExitCode {
    // Drivers and wgpu talk a lot; whoever wants to hear them sets RUST_LOG.
    env_logger::Builder::from_env(env_logger::Env::default().default_filter_or("off,rimline=warn"))
        .format_timestamp(None)
        .init();
    let cli = Cli::parse();
    match run(&cli.command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            output::note(&format!("error: {failure}"));
            failure.exit_code()
        }
    }
}

fn run(command: &Command) -> Result<(), Failure> {
    match command {
        Command::Devices(args) => devices::run(args),
        Command::Extract(args) => extract::run(args),
        Command::Info(args) => info::run(args),
        Command::Draw(args) => draw::run(args),
        Command::Shadow(args) => shadow::run(args),
        Command::Film(args) => film::run(args),
        Command::Query(args) => query::run(args),
        Command::Verify(args) => verify::run(args),
        Command::Bench(args) => bench::run(args),
    }
}
