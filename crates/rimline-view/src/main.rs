//! The viewer alone: `rimline-view [FILE]...`. The command `rimline view` has options, too. Compiled for wasm32 it
//! is the page.

#[cfg(not(target_arch = "wasm32"))]
fn main() -> std::process::ExitCode {
    use rimline_view::desktop::{DesktopOptions, run};

    let files = std::env::args_os().skip(1).map(Into::into).collect();
    match run(DesktopOptions { files, ..DesktopOptions::default() }) {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("rimline-view: {error}");
            std::process::ExitCode::FAILURE
        }
    }
}

#[cfg(target_arch = "wasm32")]
fn main() {
    rimline_view::web::start();
}
