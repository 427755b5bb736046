//! Output files that are whole or not there, and text for pipes.

use std::borrow::Cow;
use std::fmt::{self, Display, Formatter, Write as _};
use std::fs::{File, Metadata};
use std::io::{self, BufWriter, Seek as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rimline::gltf::Asset;
use tempfile::TempPath;

use crate::failure::Failure;
use crate::files::{HOLDS_RESULT, Target, check_parent, end_of_links, find, folder_of};
use crate::signals::{self, make_unfinished, remove_unfinished};
pub(crate) use crate::signals::{finish_at_interrupt, is_interrupted};

/// Prints to standard output, or to standard error where a result goes to standard output; within [`collected`] to neither. A
/// reader that has gone away (`| head`) is no failure.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let text = Text(text).to_string();
    if let Some(collected) = &mut *COLLECTED.lock().unwrap_or_else(PoisonError::into_inner) {
        collected.push_str(&text);
        return Ok(());
    }
    if HOLDS_RESULT.load(Ordering::SeqCst) {
        let _ = io::stderr().write_all(text.as_bytes());
        return Ok(());
    }
    let mut stdout = io::stdout().lock();
    printed(stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()))
}

static COLLECTED: Mutex<Option<String>> = Mutex::new(None);

/// Runs work, and returns the text that it would have printed.
pub(crate) fn collected<T>(work: impl FnOnce() -> T) -> (T, String) {
    let exchange = |text| std::mem::replace(&mut *COLLECTED.lock().unwrap_or_else(PoisonError::into_inner), text);
    exchange(Some(String::new()));
    let done = work();
    (done, exchange(None).unwrap_or_default())
}

pub(crate) fn printed(result: io::Result<()>) -> Result<(), Failure> {
    match result {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::output("standard output".as_ref())(error))
        }
        _ => Ok(()),
    }
}

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

/// `full` is the temporary file once it is complete.
#[derive(Debug)]
enum Destination {
    Beside { temporary: TempPath, target: PathBuf },
    Through { to: File, is_cut: bool, full: Option<File> },
}

impl Output {
    /// Starts a file; done before any long work, so that an unwritable path is known at once.
    pub(crate) fn create(target: &Path) -> Result<Self, Failure> {
        Self::start(target).map_err(Failure::output(target))
    }

    /// Whether a file can be made. A pipe is not opened, because its reader would take it for the end when it is closed.
    pub(crate) fn check(target: &Path) -> Result<(), Failure> {
        let is_other = std::fs::metadata(target).is_ok_and(|there| !there.is_file() && !there.is_dir());
        if is_other { Ok(()) } else { Self::create(target).map(drop) }
    }

    fn start(name: &Path) -> io::Result<Self> {
        let (destination, file) = match find(name)? {
            Target::Replace(target, existing) => {
                let (temporary, file) = beside(&target, existing.as_ref())?;
                (Destination::Beside { temporary, target }, file)
            }
            Target::Through(to, is_cut) => {
                // Archives are written back and forth, which pipes cannot.
                let file = tempfile::tempfile().map_err(|error| on_the_way(&error))?;
                (Destination::Through { to, is_cut, full: None }, file)
            }
        };
        Ok(Self { name: name.to_owned(), destination, file: Some(BufWriter::with_capacity(1 << 18, file)) })
    }

    /// The file, for a program that writes it piece by piece. `finish` has to come after.
    pub(crate) fn handle(&self) -> Result<File, Failure> {
        let file = self.file.as_ref().ok_or_else(|| io::Error::other("it is complete"));
        let handle = file.and_then(|file| file.get_ref().try_clone());
        handle.map_err(Failure::output(&self.name))
    }

    /// Lets `write` fill the file and finishes it.
    pub(crate) fn finish<E: Into<io::Error>>(
        self,
        write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
    ) -> Result<(), Failure> {
        self.fill(write)?.finish()
    }

    /// Lets `write` fill the file, for results that are finished together.
    pub(crate) fn fill<E: Into<io::Error>>(
        mut self,
        write: impl FnOnce(&mut BufWriter<File>) -> Result<(), E>,
    ) -> Result<Filled, Failure> {
        let fill = |output: &mut Self| -> io::Result<()> {
            let Some(mut file) = output.file.take() else { return Ok(()) };
            let written = write(&mut file).map_err(Into::into);
            let written = written.and_then(|()| file.into_inner().map_err(io::IntoInnerError::into_error));
            match &mut output.destination {
                // Closed before it is renamed: some systems refuse to rename an open file.
                Destination::Beside { .. } => written?.sync_all()?,
                Destination::Through { full, .. } => *full = Some(written.map_err(|error| on_the_way(&error))?),
            }
            Ok(())
        };
        let filled = fill(&mut self);
        filled.map_err(Failure::output(&self.name))?;
        Ok(Filled(self))
    }
}

/// A result's file that is complete and not yet at its path. It is removed if this is dropped.
#[must_use]
#[derive(Debug)]
pub(crate) struct Filled(Output);

impl Filled {
    /// Finishes results together. Pipes and devices come first, because a rename hardly fails.
    pub(crate) fn finish_all(mut files: Vec<Self>) -> Result<(), Failure> {
        files.sort_by_key(|Self(output)| matches!(output.destination, Destination::Beside { .. }));
        files.into_iter().try_for_each(Self::finish)
    }

    fn finish(mut self) -> Result<(), Failure> {
        let finish = |destination: &mut Destination| -> io::Result<()> {
            match destination {
                Destination::Beside { temporary, target } => {
                    signals::complete(temporary, || std::fs::rename(&*temporary, target))?;
                    temporary.disable_cleanup(true);
                }
                Destination::Through { to, is_cut, full } => {
                    let Some(mut full) = full.take() else { return Ok(()) };
                    if *is_cut {
                        to.set_len(0)?;
                    }
                    full.rewind()?;
                    io::copy(&mut full, to)?;
                }
            }
            Ok(())
        };
        let finished = finish(&mut self.0.destination);
        finished.map_err(Failure::output(&self.0.name))
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

/// A folder for results. One that was not there is made, and removed again when this is dropped, if nothing is in it.
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
        Ok(Self { made: start().map_err(Failure::output(path))? })
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

/// One line, for any text.
pub(crate) struct Line<T>(pub(crate) T);

/// Text whose line breaks are meant.
pub(crate) struct Text<T>(pub(crate) T);

impl<T: Display> Display for Line<T> {
    fn fmt(&self, to: &mut Formatter<'_>) -> fmt::Result {
        to.write_str(&escaped(&self.0, false))
    }
}

impl<T: Display> Display for Text<T> {
    fn fmt(&self, to: &mut Formatter<'_>) -> fmt::Result {
        to.write_str(&escaped(&self.0, true))
    }
}

/// Text that cannot steer a terminal. JSON has the same escapes, so JSON stays JSON.
fn escaped(text: &impl Display, keeps_lines: bool) -> String {
    let mut shown = String::new();
    for c in text.to_string().chars() {
        match c {
            c if steers(c) && !(keeps_lines && c == '\n') => _ = write!(shown, "\\u{:04x}", u32::from(c)),
            c => shown.push(c),
        }
    }
    shown
}

/// Control characters, and those that turn the direction of text around or break lines.
fn steers(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

pub(crate) fn listed_animations(asset: &Asset) -> String {
    format!("the file has {}", listed("animation", asset.animations().iter().map(|info| info.name.as_deref())))
}

/// Lists what there is of a kind: `2 lights: 0 (without a name), 1 `sun``.
pub(crate) fn listed<'a>(kind: &str, names: impl ExactSizeIterator<Item = Option<&'a str>>) -> String {
    const SHOWN: usize = 20;
    let count = names.len();
    if count == 0 {
        return "none".into();
    }
    let more = if count > SHOWN { ", …" } else { "" };
    let numbered = |(index, name): (usize, Option<&str>)| numbered_name(index, name);
    let shown: Vec<String> = names.take(SHOWN).enumerate().map(numbered).collect();
    format!("{}: {}{more}", counted(count, kind), shown.join(", "))
}

/// A number of things: `1 file`, `2 files`.
pub(crate) fn counted(count: usize, what: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {what}{plural}")
}

/// A number, and the name if there is one.
pub(crate) fn numbered_name(index: usize, name: Option<&str>) -> String {
    name.map_or_else(|| format!("{index} (without a name)"), |name| format!("{index} `{name}`"))
}

/// A line on standard error that says what is being done; hidden where that is not a terminal.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    pub(crate) fn start() -> Self {
        Self::with(ProgressBar::new_spinner(), "{spinner} {msg} {elapsed}")
    }

    #[cfg(feature = "bench")]
    pub(crate) fn rows(count: usize) -> Self {
        Self::with(ProgressBar::new(count as u64), "{wide_bar} {pos}/{len}, {eta} left: {msg}")
    }

    fn with(bar: ProgressBar, template: &str) -> Self {
        if let Ok(style) = ProgressStyle::with_template(template) {
            bar.set_style(style);
        }
        if is_quiet() {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(100));
        }
        Self(bar)
    }

    pub(crate) fn pictures(count: u64) -> Self {
        Self::with(ProgressBar::new(count), "{wide_bar} {pos}/{len} pictures, {eta} left")
    }

    pub(crate) fn picture_done(&self) {
        self.0.inc(1);
    }

    pub(crate) fn step(&self, what: impl Into<Cow<'static, str>>) {
        self.0.set_message(Line(what.into()).to_string());
    }

    /// Counts a row as done; where there is no terminal for a bar, a line says so.
    #[cfg(feature = "bench")]
    pub(crate) fn advance(&self, what: &str) {
        self.0.inc(1);
        if self.0.is_hidden() {
            note(&format!("{}/{} {what}", self.0.position(), self.0.length().unwrap_or_default()));
        }
    }

    pub(crate) fn is_shown(&self) -> bool {
        !self.0.is_hidden()
    }

    /// Runs what prints to the terminal, the line out of its way.
    pub(crate) fn aside<T>(&self, print: impl FnOnce() -> T) -> T {
        self.0.suspend(print)
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_names() {
        assert_eq!(listed("light", [].into_iter()), "none");
        assert_eq!(listed("light", [Some("sun")].into_iter()), "1 light: 0 `sun`");
        assert_eq!(listed("light", [None, Some("sun")].into_iter()), "2 lights: 0 (without a name), 1 `sun`");
        let many = listed("light", vec![None; 30].into_iter());
        assert!(many.starts_with("30 lights: 0 ") && many.ends_with("19 (without a name), …"), "{many}");
    }
}
