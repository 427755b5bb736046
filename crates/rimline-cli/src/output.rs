//! Output files that are whole or not there, and text for pipes.

use std::fs::{File, Metadata};
use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, Once, PoisonError};

use tempfile::TempPath;

use crate::failure::Failure;
use crate::interrupt;
use crate::shown::{Line, Text};
use crate::target::{self, Target, check_parent, end_of_links};

/// Whether a result goes to standard output, so that text cannot.
static HOLDS_RESULT: AtomicBool = AtomicBool::new(false);

/// The files being written, for the handler of Ctrl-C to remove.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// A result's file. It takes its name only once it is complete: it is written beside its target and then renamed. A
/// target that is no regular file, such as a pipe or device, gets the complete result instead. The partial file is
/// removed if this is dropped before, or if a signal stops the command.
#[derive(Debug)]
pub(crate) struct Output {
    name: PathBuf,
    place: Place,
    file: Option<BufWriter<File>>,
}

#[derive(Debug)]
enum Place {
    Beside { temporary: TempPath, target: PathBuf },
    Through { to: File, is_cut: bool },
}

impl Output {
    /// Starts a file; done before any long work, so that an unwritable place is known at once.
    pub(crate) fn create(target: &Path) -> Result<Self, Failure> {
        Self::start(target).map_err(|source| Failure::Output { file: target.to_owned(), source })
    }

    fn start(name: &Path) -> io::Result<Self> {
        let (place, file) = match target::find(name)? {
            Target::Replace { path, existing } => {
                let (temporary, file) = beside(&path, existing.as_ref())?;
                (Place::Beside { temporary, target: path }, file)
            }
            Target::Through { file, is_cut, is_stdout } => {
                HOLDS_RESULT.fetch_or(is_stdout, Ordering::SeqCst);
                // Archives are written back and forth, which pipes cannot.
                (Place::Through { to: file, is_cut }, tempfile::tempfile().map_err(|error| on_the_way(&error))?)
            }
        };
        Ok(Self { name: name.to_owned(), place, file: Some(BufWriter::with_capacity(1 << 18, file)) })
    }

    /// Lets `write` fill the file and puts it in its place.
    pub(crate) fn finish<E: Into<io::Error>>(
        mut self,
        write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
    ) -> Result<(), Failure> {
        let complete = |output: &mut Self| -> io::Result<()> {
            let Some(mut file) = output.file.take() else { return Ok(()) };
            let written = write(&mut file).map_err(Into::into);
            let written = written.and_then(|()| file.into_inner().map_err(io::IntoInnerError::into_error));
            let mut file = match output.place {
                Place::Beside { .. } => written?,
                Place::Through { .. } => written.map_err(|error| on_the_way(&error))?,
            };
            match &mut output.place {
                Place::Beside { temporary, target } => {
                    file.sync_all()?;
                    // Closed before it is renamed: some systems refuse to rename an open file.
                    drop(file);
                    let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
                    std::fs::rename(&*temporary, target)?;
                    unfinished.retain(|path| **path != **temporary);
                    temporary.disable_cleanup(true);
                }
                Place::Through { to, is_cut } => {
                    if *is_cut {
                        to.set_len(0)?;
                    }
                    file.rewind()?;
                    io::copy(&mut file, to)?;
                }
            }
            Ok(())
        };
        complete(&mut self).map_err(|source| Failure::Output { file: self.name.clone(), source })
    }
}

/// A file in the making beside its target, by a name that nobody has, with the rights of what it is to replace.
fn beside(target: &Path, existing: Option<&Metadata>) -> io::Result<(TempPath, File)> {
    let folder = target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    // Short, so that every name that the system takes can be a result's.
    builder.prefix(".rimline-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let plain = || std::fs::Permissions::from_mode(0o666);
        builder.permissions(existing.map_or_else(plain, Metadata::permissions));
    }
    heed_signals();
    let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    let (file, temporary) = builder.tempfile_in(folder).map_err(|error| unwritable(&error))?.into_parts();
    unfinished.push(temporary.to_path_buf());
    drop(unfinished);
    if let Some(existing) = existing {
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt;
            // Only who may give files away can; whoever cannot still has the result.
            let _ = std::os::unix::fs::fchown(&file, Some(existing.uid()), Some(existing.gid()));
        }
        file.set_permissions(existing.permissions())?;
    }
    Ok((temporary, file))
}

/// Describes an error of the temporary file in which a result for a pipe or device is made.
fn on_the_way(error: &io::Error) -> io::Error {
    let folder = std::env::temp_dir();
    let text = format!("a temporary file in {}: {error}; TMPDIR can name another folder", folder.display());
    io::Error::new(error.kind(), text)
}

/// Why no file can be made beside the target, without the name that it would have had for a moment.
fn unwritable(error: &io::Error) -> io::Error {
    let text = error.to_string();
    let reason = text.split_once(" at path ").map_or(&*text, |(reason, _)| reason);
    io::Error::new(error.kind(), format!("no file can be made in its folder: {reason}"))
}

impl Drop for Output {
    fn drop(&mut self) {
        self.file = None;
        if let Place::Beside { temporary, .. } = &self.place {
            remove_unfinished(|path| **path == **temporary);
        }
    }
}

/// A folder for results: made where it is not there, and removed again if it was and nothing was finished in it.
#[derive(Debug)]
pub(crate) struct Folder {
    /// The folders that were made, the innermost first.
    made: Vec<PathBuf>,
}

/// The folders made, for the handler of Ctrl-C to remove where they are empty.
static MADE: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

impl Folder {
    /// Its parent must be there.
    pub(crate) fn create(path: &Path) -> Result<Self, Failure> {
        let start = || match std::fs::metadata(path) {
            Ok(there) if there.is_dir() => Ok(path.to_owned()),
            Ok(_) => Err(io::Error::other("it exists and is not a folder; choose another name")),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let path = end_of_links(path)?;
                check_parent(&path)?;
                heed_signals();
                let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
                match std::fs::create_dir(&path) {
                    Ok(()) => made.push(path.clone()),
                    // Another run made it meanwhile, and removes it if it has to be.
                    Err(error) if error.kind() == io::ErrorKind::AlreadyExists && path.is_dir() => {}
                    Err(error) => return Err(error),
                }
                Ok(path)
            }
            Err(error) => Err(error),
        };
        let place = start().map_err(|source| Failure::Output { file: path.to_owned(), source })?;
        Ok(Self { made: vec![place] })
    }

    #[cfg(feature = "bench")]
    /// With the folders that it is in.
    pub(crate) fn create_all(path: &Path) -> Result<Self, Failure> {
        let mut folder = Self { made: Vec::new() };
        let missing = path.ancestors().take_while(|path| !path.as_os_str().is_empty() && !path.exists());
        for path in missing.collect::<Vec<_>>().into_iter().rev() {
            folder.made.splice(0..0, std::mem::take(&mut Self::create(path)?.made));
        }
        folder.made.append(&mut Self::create(path)?.made);
        Ok(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        for folder in &self.made {
            remove_empty(|path| path == folder);
        }
    }
}

/// Removes those of the folders made that are empty; the system keeps the others.
fn remove_empty(is_meant: impl Fn(&PathBuf) -> bool) {
    let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
    for path in made.extract_if(.., |path| is_meant(path)) {
        let _ = std::fs::remove_dir(path);
    }
}

/// Makes a file that is removed at a signal, by a name that nobody has.
pub(crate) fn create_unfinished(file: &Path) -> io::Result<File> {
    heed_signals();
    let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    let made = File::create_new(file)?;
    unfinished.push(file.to_owned());
    Ok(made)
}

/// Removes those of the files being written. Errors are ignored, because nothing can be done about them here.
pub(crate) fn remove_unfinished(is_meant: impl Fn(&PathBuf) -> bool) {
    let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    for path in unfinished.extract_if(.., |path| is_meant(path)) {
        let _ = std::fs::remove_file(path);
    }
}

/// Whether a signal is to be noticed instead of obeyed at once, and its number once it came.
static IS_FINISHING: AtomicBool = AtomicBool::new(false);

#[cfg(feature = "bench")]
/// From now on the first Ctrl-C only makes [`is_interrupted`] true, and leaves it to the work to end soon and to write
/// what it has; the second ends the command.
pub(crate) fn finish_at_interrupt() {
    heed_signals();
    IS_FINISHING.store(true, Ordering::SeqCst);
}

#[cfg(feature = "bench")]
/// Whether Ctrl-C came.
pub(crate) fn is_interrupted() -> bool {
    interrupt::SIGNAL.load(Ordering::SeqCst) != 0
}

/// From now on a signal that asks to end removes unfinished files, and ends the command with the code of the signal.
pub(crate) fn heed_signals() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let handler = |signal: i32| {
            let is_first = interrupt::SIGNAL.swap(signal as u8, Ordering::SeqCst) == 0;
            if IS_FINISHING.load(Ordering::SeqCst) && is_first {
                return;
            }
            // Locked until the end, or a result about to be renamed would be missed and reported as a failure.
            let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
            for path in unfinished.drain(..) {
                let _ = std::fs::remove_file(path);
            }
            remove_empty(|_| true);
            interrupt::leave(interrupt::interrupted_code());
        };
        if let Err(error) = interrupt::listen(handler) {
            log::warn!("Ctrl-C would leave a partial file: {error}");
        }
    });
}

/// Prints to standard output, or to standard error where a result goes to standard output. A reader that has gone away
/// (`| head`) is no failure.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let text = Text(text).to_string();
    if HOLDS_RESULT.load(Ordering::SeqCst) {
        let _ = io::stderr().write_all(text.as_bytes());
        return Ok(());
    }
    let mut stdout = io::stdout().lock();
    printed(stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()))
}

/// Turns the result of writing to standard output into the command's. A closed pipe is no error.
pub(crate) fn printed(result: io::Result<()>) -> Result<(), Failure> {
    match result {
        Err(source) if source.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::Output { file: "standard output".into(), source })
        }
        _ => Ok(()),
    }
}

/// Prints a remark for the user to standard error, which carries no results.
pub(crate) fn note(text: &str) {
    let _ = writeln!(io::stderr(), "rimline: {}", Line(text));
}
