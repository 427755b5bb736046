//! Running the command.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::pictures::Image;
use super::{Outcome, ensure};

pub(crate) struct Run {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

/// Runs `rimline` with these arguments.
pub(crate) fn rimline<A: AsRef<std::ffi::OsStr>>(arguments: impl IntoIterator<Item = A>) -> Run {
    rimline_with(arguments, &[])
}

/// Runs `rimline` with these arguments and environment variables.
pub(crate) fn rimline_with<A: AsRef<std::ffi::OsStr>>(
    arguments: impl IntoIterator<Item = A>,
    variables: &[(&str, &str)],
) -> Run {
    run_command(Command::new(env!("CARGO_BIN_EXE_rimline")).args(arguments).envs(variables.iter().copied()))
}

/// Runs a command to its end.
pub(crate) fn run_command(command: &mut Command) -> Run {
    let output = command.output().expect("the command was built");
    Run {
        // Killed by a signal: none of the command's own codes.
        code: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
        stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

impl Run {
    /// It ended with this code, without a panic, and its message has each of these parts.
    pub(crate) fn expect(&self, code: i32, parts: &[&str]) -> Outcome {
        let Self { stderr, .. } = self;
        ensure!(self.code == code, "exit code {} instead of {code}: {stderr}", self.code);
        ensure!(!stderr.contains("panicked"), "it panicked: {stderr}");
        for part in parts {
            ensure!(stderr.contains(part), "the message lacks `{part}`: {stderr}");
        }
        Ok(())
    }

    pub(crate) fn json(&self) -> Result<serde_json::Value, String> {
        self.expect(0, &[])?;
        serde_json::from_str(&self.stdout).map_err(|error| format!("{error} in: {}", self.stdout))
    }
}

/// A program that the usual signals end, also where whoever started the tests ignores them, as `nohup` and a shell's `&`
/// do. Only some systems' `env` can restore them.
pub(crate) fn with_signals(program: &str) -> Command {
    const RESTORES: &str = "--default-signal=HUP,INT,TERM";
    let mut trial = Command::new("env");
    trial.args([RESTORES, "true"]).stdout(Stdio::null()).stderr(Stdio::null());
    if trial.status().is_ok_and(|status| status.success()) {
        let mut command = Command::new("env");
        command.args([RESTORES, program]);
        return command;
    }
    Command::new(program)
}

/// Whether trials of many seeds, sizes and files were asked for.
pub(crate) fn is_long() -> bool {
    std::env::var_os("RIMLINE_LONG").is_some_and(|long| long == "1")
}

/// Writes a file.
pub(crate) fn write_file(file: impl AsRef<Path>, bytes: impl AsRef<[u8]>) -> Outcome {
    let file = file.as_ref();
    std::fs::write(file, bytes).map_err(|error| format!("{}: {error}", file.display()))
}

/// Reads a file.
pub(crate) fn read_file(file: impl AsRef<Path>) -> Result<Vec<u8>, String> {
    let file = file.as_ref();
    std::fs::read(file).map_err(|error| format!("{}: {error}", file.display()))
}

/// A folder for one test, removed with the value.
pub(crate) struct Folder(tempfile::TempDir);

pub(crate) fn folder() -> Folder {
    Folder(tempfile::tempdir().expect("there is room for temporary files"))
}

impl Folder {
    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    pub(crate) fn write(&self, name: impl AsRef<Path>, bytes: impl AsRef<[u8]>) -> Outcome {
        write_file(self.path().join(name), bytes)
    }

    pub(crate) fn read(&self, name: impl AsRef<Path>) -> Result<Vec<u8>, String> {
        read_file(self.path().join(name))
    }

    /// A picture of the folder.
    pub(crate) fn image(&self, name: impl AsRef<Path>) -> Result<Image, String> {
        Image::read(&self.path().join(name))
    }

    /// A mask of the folder.
    pub(crate) fn mask(&self, name: impl AsRef<Path>) -> Result<Image, String> {
        Image::mask(&self.path().join(name))
    }

    /// Contents of its files by name, with those of folders in it; empty for what is no regular file.
    pub(crate) fn contents(&self) -> Result<BTreeMap<String, Vec<u8>>, String> {
        contents(self.path())
    }

    /// A folder in it, for results.
    pub(crate) fn inner(&self, name: &str) -> Result<PathBuf, String> {
        let path = self.path().join(name);
        std::fs::create_dir(&path).map_err(|error| error.to_string())?;
        Ok(path)
    }

    /// Runs `rimline` in words, with paths in the folder where a word begins with `@`.
    pub(crate) fn run(&self, line: &str) -> Run {
        rimline(line.split_whitespace().map(|word| match word.strip_prefix('@') {
            Some(name) => self.path().join(name).into_os_string(),
            None => word.into(),
        }))
    }
}

/// Contents of a folder's files by name, with those of folders in it; empty for what is no regular file.
pub(crate) fn contents(folder: &Path) -> Result<BTreeMap<String, Vec<u8>>, String> {
    let text = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).map_err(text)? {
        let entry = entry.map_err(text)?;
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.file_type().map_err(text)?.is_dir() {
            let inner = contents(&entry.path())?;
            found.extend(inner.into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
            found.insert(name, Vec::new());
        } else {
            let is_file = entry.metadata().is_ok_and(|there| there.is_file());
            found.insert(name, if is_file { std::fs::read(entry.path()).unwrap_or_default() } else { Vec::new() });
        }
    }
    Ok(found)
}
