//! The command `rimline`: extract silhouettes, draw outlines, count shadow depths, look into models and devices, measure.
#![allow(clippy::doc_markdown, reason = "clap prints doc comments as they are")]

mod args;
mod begins;
#[cfg(feature = "bench")]
mod bench;
mod bench_args;
mod chosen_animations;
mod claim;
mod compiling;
mod coordinates;
mod device;
mod devices;
mod displacement;
mod draw;
mod ending;
mod extract;
mod failure;
mod film;
mod gpu_error;
mod help;
mod image;
mod info;
mod input;
mod input_args;
mod interrupt;
mod listed;
mod load_args;
mod origin;
mod output;
mod overwrite;
mod parse;
mod posed_input;
mod positions;
mod progress;
mod query;
mod quiet;
mod render;
mod shadow;
mod shown;
mod source;
mod spec;
mod target;
mod times;
mod verify;
mod warm_up;

use std::io::Write as _;
use std::process::ExitCode;

use log::Level;
use rimline_cli::{npz, obj};

use crate::args::Command;
use crate::failure::Failure;
use crate::shown::{Line, Text};

fn main() -> ExitCode {
    // Drivers and wgpu talk a lot; whoever wants to hear them sets RUST_LOG.
    env_logger::Builder::from_env(env_logger::Env::default().default_filter_or("off,rimline=warn"))
        .format(|to, record| match record.level() {
            // The command's own words, as those of `output::note`.
            Level::Warn => writeln!(to, "rimline: warning: {}", Text(record.args())),
            level => writeln!(to, "[{level:<5} {}] {}", record.target(), Text(record.args())),
        })
        .init();
    let cli = parse::parse(std::env::args_os()).unwrap_or_else(|error| refuse(&error));
    quiet::run_again_quietly(&cli.command);
    // Before anything is read: the code of a signal does not depend on when it comes.
    output::heed_signals();
    match run(&cli.command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            output::note(&format!("error: {failure}"));
            failure.exit_code()
        }
    }
}

/// Prints what the parser says, help too, and ends. It cites arguments as they are, and a shell puts names of files there.
fn refuse(error: &clap::Error) -> ! {
    if !error.use_stderr() {
        // Help and version are results like others.
        let printed = error.print().and_then(|()| std::io::stdout().flush());
        let Err(failure) = output::printed(printed) else { std::process::exit(error.exit_code()) };
        output::note(&format!("error: {failure}"));
        std::process::exit(failure.code().into());
    }
    let is_tame = |argument: std::ffi::OsString| {
        let argument = argument.to_string_lossy();
        Line(&argument).to_string() == argument
    };
    if std::env::args_os().all(is_tame) {
        error.exit();
    }
    let _ = writeln!(std::io::stderr(), "{}", Line(error.render()));
    std::process::exit(error.exit_code());
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
        #[cfg(feature = "bench")]
        Command::Bench(args) => bench::run(args),
        #[cfg(not(feature = "bench"))]
        Command::Bench(_) => Err(failure::UsageError::WithoutBench.into()),
    }
}
