//! Signals that ask the command to end, Ctrl-C, termination, hang-up, and what is removed then.

use std::fs::File;
use std::io::{self, IsTerminal as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

static SIGNAL: AtomicU8 = AtomicU8::new(0);

/// Whether a signal is to be noticed instead of obeyed at once.
static IS_FINISHING: AtomicBool = AtomicBool::new(false);

static LAST_WORDS: Mutex<String> = Mutex::new(String::new());

/// Sets the text that is printed when a signal ends the command.
pub(crate) fn say_at_end(text: String) {
    *LAST_WORDS.lock().unwrap_or_else(PoisonError::into_inner) = text;
}

/// Files being written and folders that were made for them, each folder before what is in it.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Makes a file or folder that is removed at a signal. No signal is heeded meanwhile.
pub(crate) fn make_unfinished<T>(make: impl FnOnce() -> io::Result<(T, PathBuf)>) -> io::Result<T> {
    let mut unfinished = unfinished();
    let (made, path) = make()?;
    unfinished.push(path);
    Ok(made)
}

/// Makes a file that is removed at a signal. One that is there is an error.
pub(crate) fn create_unfinished(file: &Path) -> io::Result<File> {
    make_unfinished(|| Ok((File::create_new(file)?, file.to_owned())))
}

/// Runs what completes a file. No signal removes it from then on.
pub(crate) fn complete(file: &Path, run: impl FnOnce() -> io::Result<()>) -> io::Result<()> {
    let mut unfinished = unfinished();
    run()?;
    unfinished.retain(|path| path != file);
    Ok(())
}

pub(crate) fn remove_unfinished(path: &Path) {
    unfinished().extract_if(.., |unfinished| unfinished == path).for_each(|path| remove(&path));
}

/// Removes a file, or a folder if it is empty. Errors are ignored, because nothing can be done about them here.
fn remove(path: &Path) {
    let _ = std::fs::remove_file(path).or_else(|_| std::fs::remove_dir(path));
}

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// From now on a signal that asks to end removes what is unfinished, and ends the command with the code of the signal.
pub(crate) fn heed_signals() {
    if let Err(error) = listen() {
        log::warn!("Ctrl-C would leave a partial file: {error}");
    }
}

fn heed(signal: i32) {
    let is_first = SIGNAL.swap(signal as u8, Ordering::SeqCst) == 0;
    if IS_FINISHING.load(Ordering::SeqCst) && is_first {
        return;
    }
    // Locked until the end, or a result about to be renamed would be missed and reported as a failure.
    let mut unfinished = unfinished();
    unfinished.drain(..).rev().for_each(|path| remove(&path));
    let text = LAST_WORDS.lock().unwrap_or_else(PoisonError::into_inner).clone();
    if !text.is_empty() {
        // The line of progress may stand there.
        if io::stderr().is_terminal() {
            eprintln!();
        }
        eprintln!("rimline: {text}");
    }
    leave(interrupted_code());
}

/// From now on the first Ctrl-C only makes [`is_interrupted`] true, and leaves it to the work to end soon and to write
/// what it has; the second ends the command.
pub(crate) fn finish_at_interrupt() {
    IS_FINISHING.store(true, Ordering::SeqCst);
}

pub(crate) fn is_interrupted() -> bool {
    SIGNAL.load(Ordering::SeqCst) != 0
}

/// The exit code for the signal that came: 128 and its number, as shells have it.
pub(crate) fn interrupted_code() -> u8 {
    128 + SIGNAL.load(Ordering::SeqCst)
}

/// Ends the process at once. Where the system allows it, nothing else runs, destructors of libraries included: another
/// thread may be in the middle of a driver's compiler, whose destructors would take away what it works with.
fn leave(code: u8) -> ! {
    #[cfg(unix)]
    signal_hook::low_level::exit(code.into());
    #[cfg(not(unix))]
    std::process::exit(code.into())
}

/// Heeds each signal that asks to end. One that was ignored when the command started, as
/// `nohup` and shells do, stays ignored.
#[cfg(unix)]
fn listen() -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let heeded: Vec<i32> = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|&signal| !is_ignored(signal)).collect();
    let mut signals = signal_hook::iterator::Signals::new(heeded)?;
    let wait = move || signals.forever().for_each(heed);
    std::thread::Builder::new().name("signals".into()).spawn(wait)?;
    Ok(())
}

/// Heeds Ctrl-C, whose number elsewhere is 2.
#[cfg(not(unix))]
fn listen() -> io::Result<()> {
    ctrlc::set_handler(|| heed(2)).map_err(io::Error::other)
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
