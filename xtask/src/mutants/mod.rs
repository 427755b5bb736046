//! `cargo xtask mutants`: whether the tests notice changes that make the code wrong. Each is made in a copy of the working
//! tree, so nothing here is touched.

mod contours;
mod depth_inputs;
mod depth_map;
mod depth_map_vertices;
mod list;
mod occluded;
mod origin;
mod polygons;
mod scene_clusters;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::process;
use crate::test::BENCH;
use list::Mutation;

/// Several times what the slowest program takes on two cores.
const TIME_LIMIT: Duration = Duration::from_secs(20 * 60);

/// All mutations.
fn all() -> impl Iterator<Item = &'static Mutation> {
    let lists = [
        list::MUTATIONS,
        depth_map::MUTATIONS,
        depth_inputs::MUTATIONS,
        depth_map_vertices::MUTATIONS,
        contours::MUTATIONS,
        occluded::MUTATIONS,
        origin::MUTATIONS,
        polygons::MUTATIONS,
        scene_clusters::MUTATIONS,
    ];
    lists.into_iter().flatten()
}

enum Outcome {
    /// By the tests of these arguments.
    Killed(&'static str),
    Survived,
    /// The mutation does not fit the code, or it does not compile.
    Unusable(String),
}

/// Tries all mutations, or those whose names have `only` in them.
pub(crate) fn run(only: Option<&str>) -> Result<(), String> {
    let (tree, target) = (process::target().join("mutants/tree"), process::target().join("mutants/target"));
    copy(&tree)?;
    let is_wanted = |mutation: &&Mutation| only.is_none_or(|only| mutation.name.contains(only));
    let mutations: Vec<_> = self::all().filter(is_wanted).collect();
    let mut all: Vec<_> = mutations.iter().flat_map(|mutation| mutation.tests).copied().collect();
    all.sort_unstable();
    all.dedup();
    for tests in all {
        println!("unchanged: cargo test {tests}");
        run_tests(&tree, &target, tests)?.then_some(()).ok_or_else(|| format!("{tests} fails without a mutation"))?;
    }
    let mut rows = Vec::new();
    for mutation in mutations {
        println!("\n{}", mutation.name);
        let outcome = attempt(&tree, &target, mutation)?;
        let row = match &outcome {
            Outcome::Killed(by) => format!("| {} | killed by `{by}` |", mutation.name),
            Outcome::Survived => format!("| {} | **survived** |", mutation.name),
            Outcome::Unusable(why) => {
                format!("| {} | not tried: {} |", mutation.name, why.lines().last().unwrap_or(""))
            }
        };
        println!("{row}");
        rows.push((row, outcome));
    }
    println!("\n| mutation | outcome |\n|---|---|");
    for (row, _) in &rows {
        println!("{row}");
    }
    let count = |is: fn(&Outcome) -> bool| rows.iter().filter(|(_, outcome)| is(outcome)).count();
    let survived = count(|outcome| matches!(outcome, Outcome::Survived));
    let unusable = count(|outcome| matches!(outcome, Outcome::Unusable(_)));
    println!("\n{} killed, {survived} survived, {unusable} not tried", rows.len() - survived - unusable);
    if survived + unusable == 0 { Ok(()) } else { Err("not every mutation is noticed".to_owned()) }
}

/// Makes or renews the copy. Files that are as they were keep their time, so that cargo builds little.
fn copy(tree: &Path) -> Result<(), String> {
    let mut git = Command::new("git");
    git.args(["ls-files", "--cached", "--others", "--exclude-standard", "-z"]).current_dir(process::root());
    for name in process::output(&mut git)?.split('\0').filter(|name| !name.is_empty()) {
        let (from, to) = (process::root().join(name), tree.join(name));
        // A file that is removed but not committed.
        let Ok(bytes) = std::fs::read(&from) else { continue };
        if std::fs::read(&to).is_ok_and(|old| old == bytes) {
            continue;
        }
        let folder = to.parent().unwrap_or(tree);
        std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        write(&to, &bytes)?;
    }
    Ok(())
}

fn write(file: &Path, bytes: &[u8]) -> Result<(), String> {
    std::fs::write(file, bytes).map_err(|error| format!("{}: {error}", file.display()))
}

/// Changes the files, runs the tests, and puts the files back.
fn attempt(tree: &Path, target: &Path, mutation: &Mutation) -> Result<Outcome, String> {
    let mut files: Vec<(PathBuf, String)> = Vec::new();
    let mut problem = None;
    for &(name, from, to) in mutation.changes {
        let file = tree.join(name);
        let text = std::fs::read_to_string(&file).unwrap_or_default();
        let found = text.matches(from).count();
        if found != 1 {
            problem = Some(format!("{name} has `{from}` {found} times"));
            break;
        }
        write(&file, text.replacen(from, to, 1).as_bytes())?;
        files.push((file, text));
    }
    let outcome = match problem {
        Some(problem) => Ok(Outcome::Unusable(problem)),
        None => tried(tree, target, mutation),
    };
    for (file, text) in files {
        write(&file, text.as_bytes())?;
    }
    outcome
}

fn tried(tree: &Path, target: &Path, mutation: &Mutation) -> Result<Outcome, String> {
    for &tests in mutation.tests {
        if let Err(error) = process::output(cargo(tree, target, tests, true).arg("--no-run")) {
            return Ok(Outcome::Unusable(error));
        }
        if !run_tests(tree, target, tests)? {
            return Ok(Outcome::Killed(tests));
        }
    }
    Ok(Outcome::Survived)
}

/// Whether the tests pass. Tests that do not end within [`TIME_LIMIT`] do not: a mutation may make a loop endless.
fn run_tests(tree: &Path, target: &Path, tests: &str) -> Result<bool, String> {
    let mut command = cargo(tree, target, tests, false);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    // A group of its own, so that the test programs end with cargo.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let mut child = command.spawn().map_err(|error| format!("cannot run cargo: {error}"))?;
    let start = Instant::now();
    while start.elapsed() < TIME_LIMIT {
        if let Some(status) = child.try_wait().map_err(|error| format!("cannot wait for cargo: {error}"))? {
            return Ok(status.success());
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    #[cfg(unix)]
    let _ = Command::new("kill").args(["-KILL", "--", &format!("-{}", child.id())]).status();
    let _ = child.kill();
    let _ = child.wait();
    Ok(false)
}

/// `cargo test` in the copy; `tests` is a target, and perhaps a filter of its tests.
fn cargo(tree: &Path, target: &Path, tests: &str, builds_only: bool) -> Command {
    let mut words = tests.split(' ');
    let mut command = process::cargo(["test", "--quiet", "--workspace", "--exclude", BENCH, "--all-features"]);
    match words.next() {
        Some("--lib") => {
            command.arg("--lib");
        }
        Some(kind) => {
            command.arg(kind).args(words.next());
        }
        None => {}
    }
    if !builds_only {
        command.arg("--").args(words);
    }
    command.current_dir(tree).env("CARGO_TARGET_DIR", target).env("RUST_BACKTRACE", "0");
    if std::env::var_os("RIMLINE_ASSETS").is_none() {
        command.env("RIMLINE_ASSETS", process::root().join("../shared/assets"));
    }
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Text that has changed since would make mutations that try nothing.
    #[test]
    fn every_mutation_fits_the_code_once() {
        for mutation in super::all() {
            for &(name, from, to) in mutation.changes {
                let text = std::fs::read_to_string(process::root().join(name)).unwrap_or_default();
                assert_eq!(text.matches(from).count(), 1, "{}: {name} has `{from}`", mutation.name);
                assert_ne!(from, to, "{}", mutation.name);
            }
        }
    }
}
