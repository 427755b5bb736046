//! Signals that ask the command to end: Ctrl-C, termination, hang-up.

use std::io;
use std::sync::atomic::{AtomicU8, Ordering};

/// The signal that came first; 0: none did.
pub(crate) static SIGNAL: AtomicU8 = AtomicU8::new(0);

/// The exit code for the signal that came: 128 and its number, as shells have it.
pub(crate) fn interrupted_code() -> u8 {
    128 + SIGNAL.load(Ordering::SeqCst)
}

/// Ends the process at once. Nothing else runs, destructors of libraries included: another thread may be in the middle of
/// a driver's compiler, whose destructors would take away what it works with.
#[cfg(unix)]
pub(crate) fn leave(code: u8) -> ! {
    signal_hook::low_level::exit(code.into())
}

/// Ends the process; this system's handler of Ctrl-C cannot leave destructors out.
#[cfg(not(unix))]
pub(crate) fn leave(code: u8) -> ! {
    std::process::exit(code.into())
}

/// Calls `handler` with the number of each signal that asks to end. One that was ignored when the command started, as
/// `nohup` and shells do, stays ignored.
#[cfg(unix)]
pub(crate) fn listen(handler: impl Fn(i32) + Send + 'static) -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let heeded: Vec<i32> = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|&signal| !is_ignored(signal)).collect();
    let mut signals = signal_hook::iterator::Signals::new(heeded)?;
    let wait = move || signals.forever().for_each(handler);
    std::thread::Builder::new().name("signals".into()).spawn(wait)?;
    Ok(())
}

/// Calls `handler` with 2, the number of Ctrl-C elsewhere.
#[cfg(not(unix))]
pub(crate) fn listen(handler: impl Fn(i32) + Send + 'static) -> io::Result<()> {
    ctrlc::set_handler(move || handler(2)).map_err(io::Error::other)
}

/// Whether this process ignores a signal; asked before it has a handler.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status");
    status.ok().and_then(|status| in_status(&status, signal)).unwrap_or_else(|| by_shell(signal))
}

/// Whether a process ignores a signal, from its status file on Linux.
#[cfg(unix)]
fn in_status(status: &str, signal: i32) -> Option<bool> {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
    let mask = u64::from_str_radix(mask.trim(), 16).ok()?;
    Some(mask >> (signal - 1) & 1 == 1)
}

/// A shell inherits what is ignored and, by POSIX, cannot trap it: it lives on after sending itself the signal.
#[cfg(unix)]
fn by_shell(signal: i32) -> bool {
    let test = format!("kill -{signal} $$; exit 7");
    let shell = std::process::Command::new("/bin/sh").args(["-c", &test]).status();
    shell.is_ok_and(|status| status.code() == Some(7))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn the_mask_of_ignored_signals() {
        let status =
            "Name:\trimline\nSigBlk:\tffffffffffffffff\nSigIgn:\t0000000000001001\nSigCgt:\t0000000000000002\n";
        assert_eq!([1, 2, 13, 15].map(|signal| in_status(status, signal)), [true, false, true, false].map(Some));
        assert_eq!(in_status("Name:\trimline\n", 1), None);
    }

    #[test]
    fn the_shell_and_the_system_agree() {
        // SIGPIPE is one that Rust programs ignore; the shell gets it restored by `Command`.
        for signal in [1, 15] {
            assert_eq!(by_shell(signal), is_ignored(signal), "signal {signal}");
        }
    }
}
