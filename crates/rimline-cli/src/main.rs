//! The command `rimline`: extract silhouettes, draw outlines, count occluders, look into models and devices, measure.
#![allow(clippy::doc_markdown, reason = "clap prints doc comments as they are")]

mod args;
#[cfg(feature = "bench")]
mod bench;
mod camera;
mod coincident;
mod coordinates;
mod device;
mod devices;
mod draw;
mod extract;
mod failure;
mod files;
mod film;
mod image;
mod info;
mod input;
mod input_args;
mod jobs;
mod lines;
mod output;
mod parse;
mod query;
mod report;
mod shadow;
mod shell;
mod signals;
mod spec;
mod verify;
#[cfg(feature = "view")]
mod view;

use std::io::Write as _;
use std::process::ExitCode;

use clap::Parser as _;
use log::Level;

use crate::args::{Cli, Command};
use crate::failure::Failure;
use crate::jobs::Many;
use crate::output::{Line, Text};
use crate::parse::joined;

fn main() -> ExitCode {
    // Drivers and wgpu talk a lot; whoever wants to hear them sets RUST_LOG.
    env_logger::Builder::from_env(env_logger::Env::default().default_filter_or("off,rimline=warn"))
        .format(|to, record| match record.level() {
            // The command's own words, as those of `output::note`.
            Level::Warn => writeln!(to, "rimline: warning: {}", Text(record.args())),
            level => writeln!(to, "[{level:<5} {}] {}", record.target(), Text(record.args())),
        })
        .init();
    #[cfg(all(unix, not(target_vendor = "apple")))]
    keep_wayland_quiet();
    let arguments = joined(std::env::args_os().collect());
    let done = if let Some(many) = Many::given(&arguments) {
        begin(many.is_quiet);
        many.run()
    } else {
        let cli = Cli::try_parse_from(arguments).unwrap_or_else(|error| refuse(&error));
        begin(cli.quiet);
        run(&cli.command)
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            output::complain(&failure);
            failure.code().into()
        }
    }
}

fn begin(is_quiet: bool) {
    if is_quiet {
        output::be_quiet();
    }
    // Before anything is read: the code of a signal does not depend on when it comes.
    signals::heed_signals();
}

/// Runs the command again in this same process, with `XDG_RUNTIME_DIR`, if that is no absolute path. Mesa's Vulkan layer asks
/// Wayland for the screen's GPU each time that adapters are listed, and libwayland then prints an error without the variable,
/// although nothing is wrong; a process cannot safely change its own environment. Where that fails, the command goes on as it
/// is: the message is all that it costs. It runs again before it looks at its arguments, which takes a millisecond.
#[cfg(all(unix, not(target_vendor = "apple")))]
fn keep_wayland_quiet() {
    use std::os::unix::process::CommandExt as _;
    const VARIABLE: &str = "XDG_RUNTIME_DIR";
    if std::env::var_os(VARIABLE).is_some_and(|folder| std::path::Path::new(&folder).is_absolute()) {
        return;
    }
    let Ok(program) = std::env::current_exe() else { return };
    let mut arguments = std::env::args_os();
    let mut again = std::process::Command::new(program);
    if let Some(name) = arguments.next() {
        again.arg0(name);
    }
    // Nobody can make a file below it, so Wayland finds no socket and says nothing.
    let error = again.args(arguments).env(VARIABLE, "/dev/null").exec();
    log::debug!("cannot run again with {VARIABLE}: {error}");
}

/// Prints what the parser says, help too, and ends. It cites arguments as they are, and a shell puts names of files there.
pub(crate) fn refuse(error: &clap::Error) -> ! {
    if !error.use_stderr() {
        // Help and version are results like others.
        let printed = error.print().and_then(|()| std::io::stdout().flush());
        let Err(failure) = output::printed(printed) else { std::process::exit(error.exit_code()) };
        output::complain(&failure);
        std::process::exit(failure.code().into());
    }
    if std::env::args_os().all(|argument| is_tame(&argument.to_string_lossy())) {
        let _ = error.print();
    } else {
        let _ = writeln!(std::io::stderr(), "{}", Line(error.render()));
    }
    if let Some(file) = named_alone(error) {
        let _ = writeln!(std::io::stderr(), "tip: to see the model, `rimline view {file}`");
    }
    std::process::exit(error.exit_code());
}

fn is_tame(text: &str) -> bool {
    Line(text).to_string() == text
}

/// The file that is given instead of a subcommand.
fn named_alone(error: &clap::Error) -> Option<&str> {
    use clap::error::{ContextKind, ContextValue, ErrorKind};
    match error.get(ContextKind::InvalidSubcommand) {
        Some(ContextValue::String(wrong)) if error.kind() == ErrorKind::InvalidSubcommand && is_tame(wrong) => {
            std::path::Path::new(wrong).is_file().then_some(wrong.as_str())
        }
        _ => None,
    }
}

pub(crate) fn run(command: &Command) -> Result<(), Failure> {
    match command {
        Command::Devices(args) => devices::run(args),
        Command::Extract(args) => extract::run(args),
        Command::Info(args) => info::run(args),
        Command::Draw(args) => draw::run(args),
        Command::Lines(args) => lines::run(args),
        Command::Shadow(args) => shadow::run(args),
        Command::Film(args) => film::run(args),
        Command::Query(args) => query::run(args),
        Command::Verify(args) => verify::run(args),
        Command::Completions(args) => shell::completions(args),
        Command::Man(args) => shell::man(args),
        #[cfg(feature = "bench")]
        Command::Bench(args) => bench::run(args),
        #[cfg(not(feature = "bench"))]
        Command::Bench(_) => Err(Failure::usage(
            "this build of rimline leaves `bench` out; `cargo install --path crates/rimline-cli` builds one that has it, and \
             so does `--features bench`",
        )),
        #[cfg(feature = "view")]
        Command::View(args) => view::run(args),
        #[cfg(not(feature = "view"))]
        Command::View(_) => Err(Failure::usage(
            "this build of rimline leaves `view` out; `cargo install --path crates/rimline-cli` builds one that has it, and \
             so does `--features view`; `rimline shadow` draws to a file",
        )),
    }
}
