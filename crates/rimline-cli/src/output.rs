//! Output files that are whole or not there, and text for pipes.

use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, Once, PoisonError};

use crate::failure::Failure;

/// The files being written, for the handler of Ctrl-C to remove.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A file that takes its name only once it is complete: it is written beside its target and then renamed. Dropped
/// before, or stopped by Ctrl-C, it is removed.
#[derive(Debug)]
pub(crate) struct Output {
    target: PathBuf,
    temporary: PathBuf,
    file: Option<BufWriter<File>>,
}

impl Output {
    /// Starts a file; done before any long work, so that an unwritable place is known at once.
    pub(crate) fn create(target: &Path) -> Result<Self, Failure> {
        Self::start(target).map_err(|source| Failure::Output { file: target.to_owned(), source })
    }

    fn start(target: &Path) -> io::Result<Self> {
        // Through links, so that the link stays and what it names is replaced.
        let target = match target.canonicalize() {
            Ok(existing) if existing.is_file() => existing,
            Ok(_) => return Err(io::Error::other("it exists and is not a file; choose another name")),
            Err(error) if error.kind() == io::ErrorKind::NotFound => target.to_owned(),
            Err(error) => return Err(error),
        };
        check_parent(&target)?;
        let name = target.file_name().ok_or_else(|| io::Error::other("it is not the name of a file"))?;
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}.part", std::process::id()));
        let temporary = target.with_file_name(hidden);
        remove_at_interrupt();
        let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
        let file = OpenOptions::new().write(true).create_new(true).open(&temporary)?;
        unfinished.push(temporary.clone());
        Ok(Self { target, temporary, file: Some(BufWriter::with_capacity(1 << 18, file)) })
    }

    /// Lets `write` fill the file and puts it in its place.
    pub(crate) fn finish<E: Into<io::Error>>(
        mut self,
        write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
    ) -> Result<(), Failure> {
        let complete = |output: &mut Self| -> io::Result<()> {
            if let Some(mut file) = output.file.take() {
                write(&mut file).map_err(Into::into)?;
                // Closed before it is renamed: some systems refuse to rename an open file.
                file.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()?;
            }
            let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
            std::fs::rename(&output.temporary, &output.target)?;
            unfinished.retain(|path| *path != output.temporary);
            Ok(())
        };
        complete(&mut self).map_err(|source| Failure::Output { file: self.target.clone(), source })
    }
}

impl Drop for Output {
    fn drop(&mut self) {
        self.file = None;
        remove_unfinished(|path| *path == self.temporary);
    }
}

/// A folder for results: made where it is not there, and removed again if it was and nothing was finished in it.
#[derive(Debug)]
pub(crate) struct Folder(PathBuf);

/// The folders made, for the handler of Ctrl-C to remove where they are empty.
static MADE: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

impl Folder {
    /// Its parent must be there.
    pub(crate) fn create(path: &Path) -> Result<Self, Failure> {
        let start = || match std::fs::metadata(path) {
            Ok(there) if there.is_dir() => Ok(()),
            Ok(_) => Err(io::Error::other("it exists and is not a folder; choose another name")),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                check_parent(path)?;
                remove_at_interrupt();
                let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
                std::fs::create_dir(path)?;
                made.push(path.to_owned());
                Ok(())
            }
            Err(error) => Err(error),
        };
        start().map_err(|source| Failure::Output { file: path.to_owned(), source })?;
        Ok(Self(path.to_owned()))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        remove_empty(|path| *path == self.0);
    }
}

/// Removes those of the folders made that are empty; the system keeps the others.
fn remove_empty(is_meant: impl Fn(&PathBuf) -> bool) {
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    for path in made.extract_if(.., |path| is_meant(path)) {
        let _ = std::fs::remove_dir(path);
    }
}

/// Whether both name one file, be it there or not.
pub(crate) fn is_same_file(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let named = || Some(folder.canonicalize().ok()?.join(path.file_name()?));
        path.canonicalize().ok().or_else(named)
    };
    a == b || place(a).is_some_and(|a| Some(a) == place(b))
}

/// Where a result goes to must be there.
fn check_parent(target: &Path) -> io::Result<()> {
    match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            Err(io::Error::other("its folder does not exist; make it first"))
        }
        _ => Ok(()),
    }
}

/// Removes those of the files being written. That it fails can have no remedy here.
fn remove_unfinished(is_meant: impl Fn(&PathBuf) -> bool) {
    let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    for path in unfinished.extract_if(.., |path| is_meant(path)) {
        let _ = std::fs::remove_file(path);
    }
}

/// Whether Ctrl-C is to be noticed instead of obeyed at once, and whether it came.
static IS_FINISHING: AtomicBool = AtomicBool::new(false);
static IS_INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// From now on the first Ctrl-C only makes [`is_interrupted`] true, and leaves it to the work to end soon and to write
/// what it has; the second ends the command.
pub(crate) fn finish_at_interrupt() {
    remove_at_interrupt();
    IS_FINISHING.store(true, Ordering::SeqCst);
}

/// Whether Ctrl-C came.
pub(crate) fn is_interrupted() -> bool {
    IS_INTERRUPTED.load(Ordering::SeqCst)
}

fn remove_at_interrupt() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let handler = || {
            if IS_FINISHING.load(Ordering::SeqCst) && !IS_INTERRUPTED.swap(true, Ordering::SeqCst) {
                return;
            }
            remove_unfinished(|_| true);
            remove_empty(|_| true);
            // 128 and the number of the signal, as shells have it.
            std::process::exit(130);
        };
        if let Err(error) = ctrlc::set_handler(handler) {
            log::warn!("Ctrl-C would leave a partial file: {error}");
        }
    });
}

/// Prints to standard output. A reader that has gone away (`| head`) is no failure.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(source) if source.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::Output { file: "standard output".into(), source })
        }
        _ => Ok(()),
    }
}

/// Prints a remark for the user to standard error, which carries no results.
pub(crate) fn note(text: &str) {
    let _ = writeln!(io::stderr(), "rimline: {text}");
}
