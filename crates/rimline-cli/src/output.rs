//! Output files that are whole or not there, and text for pipes.

use std::fmt::Display;
use std::fs::{File, Metadata};
use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use tempfile::TempPath;

use crate::failure::Failure;
use crate::shown::{Line, Text};
use crate::signals::{self, make_unfinished, remove_unfinished};
use crate::target::{self, Target, check_parent, end_of_links, find, folder_of};

pub(crate) use crate::signals::{finish_at_interrupt, is_interrupted};

/// Prints to standard output, or to standard error where a result goes to standard output. A reader that has gone away
/// (`| head`) is no failure.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let text = Text(text).to_string();
    if let Some(collected) = &mut *COLLECTED.lock().unwrap_or_else(PoisonError::into_inner) {
        collected.push_str(&text);
        return Ok(());
    }
    if target::holds_result() {
        let _ = io::stderr().write_all(text.as_bytes());
        return Ok(());
    }
    let mut stdout = io::stdout().lock();
    printed(stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()))
}

/// Text that is collected instead of printed.
static COLLECTED: Mutex<Option<String>> = Mutex::new(None);

/// Runs work, and returns the text that it would have printed.
pub(crate) fn collected<T>(work: impl FnOnce() -> T) -> (T, String) {
    let exchange = |text| std::mem::replace(&mut *COLLECTED.lock().unwrap_or_else(PoisonError::into_inner), text);
    exchange(Some(String::new()));
    let done = work();
    (done, exchange(None).unwrap_or_default())
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

/// Whether only results and errors are printed.
static IS_QUIET: AtomicBool = AtomicBool::new(false);

/// Prints only results and errors from now on.
pub(crate) fn be_quiet() {
    IS_QUIET.store(true, Ordering::Relaxed);
    log::set_max_level(log::LevelFilter::Error);
}

pub(crate) fn is_quiet() -> bool {
    IS_QUIET.load(Ordering::Relaxed)
}

/// Prints what was done, which is no result: that is in a file.
pub(crate) fn say(text: &str) -> Result<(), Failure> {
    if is_quiet() { Ok(()) } else { print(text) }
}

/// Prints a remark for the user to standard error, which carries no results.
pub(crate) fn note(text: &str) {
    if !is_quiet() {
        let _ = writeln!(io::stderr(), "rimline: {}", Line(text));
    }
}

/// Prints why the command stops.
pub(crate) fn complain(failure: &impl Display) {
    let _ = writeln!(io::stderr(), "rimline: {}", Line(format!("error: {failure}")));
}

/// A result's file. It takes its name only once it is complete: it is written beside its target and then renamed. A
/// target that is no regular file, such as a pipe or device, gets the complete result instead. The partial file is
/// removed if this is dropped before, or if a signal stops the command.
#[derive(Debug)]
pub(crate) struct Output {
    name: PathBuf,
    destination: Destination,
    file: Option<BufWriter<File>>,
}

#[derive(Debug)]
enum Destination {
    Beside { temporary: TempPath, target: PathBuf },
    Through { to: File, is_cut: bool },
}

impl Output {
    /// Starts a file; done before any long work, so that an unwritable place is known at once.
    pub(crate) fn create(target: &Path) -> Result<Self, Failure> {
        Self::start(target).map_err(|source| Failure::Output { file: target.to_owned(), source })
    }

    fn start(name: &Path) -> io::Result<Self> {
        let (destination, file) = match find(name)? {
            Target::Replace(target, existing) => {
                let (temporary, file) = beside(&target, existing.as_ref())?;
                (Destination::Beside { temporary, target }, file)
            }
            Target::Through(to, is_cut) => {
                // Archives are written back and forth, which pipes cannot.
                (Destination::Through { to, is_cut }, tempfile::tempfile().map_err(|error| on_the_way(&error))?)
            }
        };
        Ok(Self { name: name.to_owned(), destination, file: Some(BufWriter::with_capacity(1 << 18, file)) })
    }

    /// The file, for a program that writes it piece by piece. `finish` has to come after.
    pub(crate) fn handle(&self) -> Result<File, Failure> {
        let file = self.file.as_ref().ok_or_else(|| io::Error::other("it is complete"));
        let handle = file.and_then(|file| file.get_ref().try_clone());
        handle.map_err(|source| Failure::Output { file: self.name.clone(), source })
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
            let mut file = match output.destination {
                Destination::Beside { .. } => written?,
                Destination::Through { .. } => written.map_err(|error| on_the_way(&error))?,
            };
            match &mut output.destination {
                Destination::Beside { temporary, target } => {
                    file.sync_all()?;
                    // Closed before it is renamed: some systems refuse to rename an open file.
                    drop(file);
                    signals::complete(temporary, || std::fs::rename(&*temporary, target))?;
                    temporary.disable_cleanup(true);
                }
                Destination::Through { to, is_cut } => {
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
    let folder = folder_of(target);
    let mut builder = tempfile::Builder::new();
    // Short, so that every name that the system takes can be a result's.
    builder.prefix(".rimline-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let plain = || std::fs::Permissions::from_mode(0o666);
        builder.permissions(existing.map_or_else(plain, Metadata::permissions));
    }
    let (file, temporary) = make_unfinished(|| {
        let made = builder.tempfile_in(folder).map_err(|error| unwritable(&error))?.into_parts();
        let path = made.1.to_path_buf();
        Ok((made, path))
    })?;
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
        if let Destination::Beside { temporary, .. } = &self.destination {
            remove_unfinished(temporary);
        }
    }
}

/// A folder for results: made where it is not there, and removed again if it was and nothing was finished in it.
#[derive(Debug)]
pub(crate) struct Folder {
    /// The folders that were made, the innermost first.
    made: Vec<PathBuf>,
}

impl Folder {
    /// Its parent must be there.
    pub(crate) fn create(path: &Path) -> Result<Self, Failure> {
        let start = || match std::fs::metadata(path) {
            Ok(there) if there.is_dir() => Ok(Vec::new()),
            Ok(_) => Err(io::Error::other("it exists and is not a folder; choose another name")),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let path = end_of_links(path)?;
                check_parent(&path)?;
                match make_unfinished(|| std::fs::create_dir(&path).map(|()| ((), path.clone()))) {
                    Ok(()) => Ok(vec![path]),
                    // Another run made it meanwhile, and removes it if it has to be.
                    Err(error) if error.kind() == io::ErrorKind::AlreadyExists && path.is_dir() => Ok(Vec::new()),
                    Err(error) => Err(error),
                }
            }
            Err(error) => Err(error),
        };
        Ok(Self { made: start().map_err(|source| Failure::Output { file: path.to_owned(), source })? })
    }

    /// With the folders that it is in.
    #[cfg(feature = "bench")]
    pub(crate) fn create_all(path: &Path) -> Result<Self, Failure> {
        let mut folder = Self { made: Vec::new() };
        let missing = path.ancestors().skip(1).take_while(|path| !path.as_os_str().is_empty() && !path.exists());
        for path in missing.collect::<Vec<_>>().into_iter().rev().chain([path]) {
            folder.made.splice(0..0, std::mem::take(&mut Self::create(path)?.made));
        }
        Ok(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        self.made.iter().for_each(|folder| remove_unfinished(folder));
    }
}
