//! Keeps libwayland quiet where there is no desktop session.
//!
//! Mesa's Vulkan layer asks Wayland for the screen's GPU each time that adapters are listed. Without an absolute path in
//! `XDG_RUNTIME_DIR`, libwayland prints an error to standard error, although nothing is wrong. A process cannot safely
//! change its own environment, so the command replaces itself by a new run of itself that has the variable.

use std::ffi::OsStr;
use std::path::Path;

use crate::args::Command;
use crate::device::Wanted;

const VARIABLE: &str = "XDG_RUNTIME_DIR";

/// No session's folder. Nobody can make a file below it, so Wayland finds no socket and says nothing.
const NO_FOLDER: &str = "/dev/null";

/// Runs the command again with the variable, in this same process, if it may open a GPU and the variable is missing. Where
/// that fails, the command goes on as it is: the message is all that it costs.
#[cfg(all(unix, not(target_vendor = "apple")))]
pub(crate) fn run_again_quietly(command: &Command) {
    use std::os::unix::process::CommandExt;
    if !opens_gpu(command) || !is_missing(std::env::var_os(VARIABLE).as_deref()) {
        return;
    }
    let Ok(program) = std::env::current_exe() else { return };
    let mut arguments = std::env::args_os();
    let mut again = std::process::Command::new(program);
    if let Some(name) = arguments.next() {
        again.arg0(name);
    }
    let error = again.args(arguments).env(VARIABLE, NO_FOLDER).exec();
    log::debug!("cannot run again with {VARIABLE}: {error}");
}

/// Elsewhere there is no Wayland.
#[cfg(not(all(unix, not(target_vendor = "apple"))))]
pub(crate) fn run_again_quietly(_: &Command) {}

/// Whether libwayland complains of this value.
fn is_missing(value: Option<&OsStr>) -> bool {
    value.is_none_or(|value| !Path::new(value).is_absolute())
}

fn opens_gpu(command: &Command) -> bool {
    let on = |device: &str| Wanted::parse(device) != Wanted::Cpu;
    match command {
        Command::Info(_) => false,
        Command::Devices(_) => true,
        Command::Draw(args) => on(&args.posed.device.device),
        Command::Shadow(args) => on(&args.scene.posed.device.device),
        Command::Film(args) => on(&args.scene.posed.device.device),
        Command::Extract(args) => on(&args.posed.device.device),
        Command::Query(args) => on(&args.posed.device.device),
        Command::Verify(args) => on(args.device.as_deref().unwrap_or(if args.make { "cpu" } else { "all" })),
        #[cfg(feature = "bench")]
        Command::Bench(args) => !args.schema && on(&args.device.device),
        #[cfg(not(feature = "bench"))]
        Command::Bench(_) => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_an_absolute_path_is_there() {
        for (value, expected) in [
            (None, true),
            (Some(""), true),
            (Some("run"), true),
            (Some("/run/user/7"), false),
            (Some(NO_FOLDER), false),
        ] {
            assert_eq!(is_missing(value.map(OsStr::new)), expected, "{value:?}");
        }
    }
}
