//! The viewer alone: `rimline-view [FILE]...`. The command `rimline view` has options besides.

use std::path::PathBuf;
use std::process::ExitCode;

use rimline_view::desktop::{DesktopOptions, run};

fn main() -> ExitCode {
    let files: Vec<PathBuf> = std::env::args_os().skip(1).map(PathBuf::from).collect();
    match run(DesktopOptions { files, ..DesktopOptions::default() }) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("rimline-view: {error}");
            ExitCode::FAILURE
        }
    }
}
