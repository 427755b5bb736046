//! `cargo xtask mutants`: which tests notice changes that make the code wrong. Nothing here is touched. A shader is
//! changed in a copy of `wgsl`, which tests that are built already read. Other code is changed, and built, in a copy of
//! the repository.

mod matrix;
mod mutation;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::process;
use crate::test::BENCH;
use matrix::{Outcome, Test};
use mutation::Mutation;

/// Several times what the slowest program takes on two cores. A mutation may make a loop endless.
const TIME_LIMIT: Duration = Duration::from_secs(20 * 60);

/// Tries all mutations, or those whose names have `only` in them, and writes `target/mutants.txt`.
pub(crate) fn run(only: Option<&str>) -> Result<(), String> {
    let mut mutations = mutation::all()?;
    mutations.retain(|mutation| only.is_none_or(|only| mutation.name.contains(only)));
    if mutations.is_empty() {
        return Err("no mutation has such a name".to_owned());
    }
    let wrong: Vec<_> = mutations.iter().filter_map(|mutation| mutation.mutated().err()).collect();
    if !wrong.is_empty() {
        return Err(format!("mutations that do not fit the code:\n{}", wrong.join("\n")));
    }
    let copies = [(true, "mutants/shaders"), (false, "mutants/tree")]
        .map(|(is_of_shaders, name)| WorkingCopy { is_of_shaders, files: process::target().join(name) });
    let (mut report, mut noticed) = (String::new(), 0);
    for of_subject in mutations.chunk_by(|a, b| a.subject() == b.subject()) {
        println!("\n{}: without a mutation", of_subject[0].subject());
        let mut tests = Vec::new();
        for copy in &copies {
            if of_subject.iter().all(|mutation| mutation.is_shader() != copy.is_of_shaders) {
                continue;
            }
            copy.renew()?;
            tests = copy.tests(&of_subject[0])?;
            if let [(target, name), ..] = &*copy.failures(&of_subject[0])? {
                return Err(format!("without a mutation, a test of `{target}` fails: {name}"));
            }
        }
        let (mut columns, mut part) = (Vec::new(), String::new());
        for mutation in of_subject {
            let outcome = copies[usize::from(!mutation.is_shader())].attempt(mutation)?;
            println!("{}: {}", mutation.name, matrix::outcome(&outcome));
            noticed += usize::from(outcome.as_ref().is_ok_and(|failed| !failed.is_empty()));
            columns.push((mutation, outcome));
            part = matrix::shown(&tests, &columns) + "\n";
            // Written after each, because a whole run takes hours.
            write(&process::target().join("mutants.txt"), format!("{report}{part}"))?;
        }
        println!("\n{part}");
        report += &part;
    }
    println!("{noticed} of {} mutations are noticed", mutations.len());
    if noticed == mutations.len() { Ok(()) } else { Err("not every mutation is noticed".to_owned()) }
}

/// Where mutations of one kind are made.
struct WorkingCopy {
    is_of_shaders: bool,
    /// A copy of the repository, or of its shaders.
    files: PathBuf,
}

impl WorkingCopy {
    /// Makes or renews the copy. Files that are as they were keep their time, so that cargo builds little.
    fn renew(&self) -> Result<(), String> {
        for name in process::names(if self.is_of_shaders { &["wgsl/"] } else { &[] })? {
            let (from, to) = (process::root().join(&name), self.files.join(&name));
            // A file that is removed but not committed.
            let Ok(bytes) = std::fs::read(&from) else { continue };
            if !std::fs::read(&to).is_ok_and(|old| old == bytes) {
                write(&to, bytes)?;
            }
        }
        Ok(())
    }

    /// Changes the file, runs the tests, and puts the file back.
    fn attempt(&self, mutation: &Mutation) -> Result<Outcome, String> {
        let file = self.files.join(mutation.file);
        let original = std::fs::read(&file).map_err(|error| at(&file, &error))?;
        write(&file, mutation.mutated()?)?;
        let outcome = self.compiles(mutation).map_or_else(|why| Ok(Err(why)), |()| self.failures(mutation).map(Ok));
        write(&file, original)?;
        outcome
    }

    /// Whether the mutation makes code that compiles, or the compiler's first error.
    fn compiles(&self, mutation: &Mutation) -> Result<(), String> {
        let compiled = if self.is_of_shaders {
            process::output(self.cargo("--test wgsl").args(["--", "wgsl_composes"])).map(drop)
        } else {
            let mut targets = mutation.targets.iter();
            targets.try_for_each(|target| process::output(self.cargo(target).arg("--no-run")).map(drop))
        };
        compiled.map_err(|said| said.lines().find(|line| line.contains("error")).unwrap_or(&said).to_owned())
    }

    /// All tests of the mutation's subject.
    fn tests(&self, mutation: &Mutation) -> Result<Vec<Test>, String> {
        let mut tests = Vec::new();
        for &target in &mutation.targets {
            let output = process::output(self.cargo(target).args(["--", "--list"]))?;
            tests.extend(matrix::listed(&output).map(|name| (target, name)));
        }
        Ok(tests)
    }

    /// The tests of the mutation's subject that fail.
    fn failures(&self, mutation: &Mutation) -> Result<Vec<Test>, String> {
        let mut failures = Vec::new();
        for &target in &mutation.targets {
            let said = self.files.with_extension("txt");
            let file = std::fs::File::create(&said).map_err(|error| at(&said, &error))?;
            let succeeded = succeeds_in_time(self.cargo(target).stdout(file).stderr(Stdio::null()))?;
            let output = std::fs::read(&said).map_err(|error| at(&said, &error))?;
            let mut failed = matrix::failed(&String::from_utf8_lossy(&output));
            if succeeded != Some(true) && failed.is_empty() {
                failed.push(if succeeded.is_some() { "(ended early)" } else { "(did not end)" }.to_owned());
            }
            failures.extend(failed.into_iter().map(|name| (target, name)));
        }
        Ok(failures)
    }

    /// `cargo test` for a target.
    fn cargo(&self, target: &str) -> Command {
        let mut command =
            process::cargo(["test", "--workspace", "--exclude", BENCH, "--all-features", "--no-fail-fast"]);
        command.args(target.split(' ')).env("RUST_BACKTRACE", "0");
        if self.is_of_shaders {
            command.env("RIMLINE_WGSL", self.files.join("wgsl"));
        } else {
            command.current_dir(&self.files).env("CARGO_TARGET_DIR", self.files.with_file_name("target"));
        }
        if std::env::var_os("RIMLINE_ASSETS").is_none() {
            command.env("RIMLINE_ASSETS", process::root().join("../shared/assets"));
        }
        command
    }
}

fn at(file: &Path, error: &std::io::Error) -> String {
    format!("{}: {error}", file.display())
}

fn write(file: &Path, bytes: impl AsRef<[u8]>) -> Result<(), String> {
    let made = std::fs::create_dir_all(file.parent().unwrap_or(file));
    made.and_then(|()| std::fs::write(file, bytes)).map_err(|error| at(file, &error))
}

/// Whether a command succeeds, or `None` if it does not end within [`TIME_LIMIT`].
fn succeeds_in_time(command: &mut Command) -> Result<Option<bool>, String> {
    // A group of its own, so that the test programs end with cargo.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    let mut child = command.spawn().map_err(|error| format!("cannot run cargo: {error}"))?;
    let start = Instant::now();
    while start.elapsed() < TIME_LIMIT {
        if let Some(status) = child.try_wait().map_err(|error| format!("cannot wait for cargo: {error}"))? {
            return Ok(Some(status.success()));
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    #[cfg(unix)]
    let _ = Command::new("kill").args(["-KILL", "--", &format!("-{}", child.id())]).status();
    let _ = child.kill();
    let _ = child.wait();
    Ok(None)
}
