//! `cargo bench --features cli --bench extraction -- [OPTIONS]`: runs `rimline bench` with these options, see its
//! `--help`. What is measured and how stands in `src/bin/rimline/bench`.

use std::process::{Command, ExitCode};

fn main() -> ExitCode {
    // Cargo's own, for the standard harness.
    let options = std::env::args().skip(1).filter(|option| option != "--bench");
    let status = Command::new(env!("CARGO_BIN_EXE_rimline")).arg("bench").args(options).status();
    match status.map(|status| status.code()) {
        Ok(Some(code)) => ExitCode::from(u8::try_from(code).unwrap_or(1)),
        Ok(None) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("rimline cannot be run: {error}");
            ExitCode::FAILURE
        }
    }
}
