//! `cargo xtask mutants`: which tests notice changes that make the code wrong. Nothing here is touched. A shader is
//! changed in a copy of `wgsl`, which tests that are built already read. Other code is changed, and built, in a copy of
//! the repository.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::process;
use crate::test::BENCH;

/// Several times what the slowest program takes on two cores. A mutation may make a loop endless.
const TIME_LIMIT: Duration = Duration::from_secs(20 * 60);

/// Tries all mutations, or those whose names have `only` in them, and writes `target/mutants.txt`. A quick run ends the
/// tests of each mutation at the first failure, and then runs those that failed without a mutation.
pub(crate) fn run(only: Option<&str>, is_quick: bool) -> Result<(), String> {
    let mut mutations = all()?;
    mutations.retain(|mutation| only.is_none_or(|only| mutation.name.contains(only)));
    if mutations.is_empty() {
        return Err("no mutation has such a name".to_owned());
    }
    let wrong: Vec<_> = mutations.iter().filter_map(|mutation| mutation.mutated().err()).collect();
    if !wrong.is_empty() {
        return Err(format!("mutations that do not fit the code:\n{}", wrong.join("\n")));
    }
    let copies = [(true, "mutants/shaders"), (false, "mutants/tree")].map(|(is_of_shaders, name)| WorkingCopy {
        is_of_shaders,
        is_quick,
        files: process::target().join(name),
    });
    let (mut report, mut noticed) = (String::new(), 0);
    for of_subject in mutations.chunk_by(|a, b| a.subject() == b.subject()) {
        let first = if is_quick { "building" } else { "without a mutation" };
        println!("\n{}: {first}", of_subject[0].subject());
        let mut tests = Vec::new();
        for copy in &copies {
            if of_subject.iter().all(|mutation| mutation.is_shader() != copy.is_of_shaders) {
                continue;
            }
            copy.renew()?;
            // This builds them, too, so that no build counts in the time limit.
            tests = copy.tests(&of_subject[0])?;
            let failures = if is_quick { Vec::new() } else { copy.failures(&of_subject[0])? };
            if let [(target, name), ..] = &*failures {
                return Err(format!("without a mutation, a test of `{target}` fails: {name}"));
            }
        }
        let (mut columns, mut part) = (Vec::new(), String::new());
        for mutation in of_subject {
            let outcome = copies[usize::from(!mutation.is_shader())].attempt(mutation)?;
            println!("{}: {}", mutation.name, described(&outcome));
            noticed += usize::from(outcome.as_ref().is_ok_and(|failed| !failed.is_empty()));
            columns.push((mutation, outcome));
            part = shown((!is_quick).then_some(&*tests), &columns) + "\n";
            // Written after each, because a whole run takes hours.
            write(&process::target().join("mutants.txt"), format!("{report}{part}"))?;
        }
        if is_quick {
            pass_without(&copies, &columns)?;
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
    is_quick: bool,
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
            tests.extend(listed(&output).map(|name| (target, name)));
        }
        Ok(tests)
    }

    /// The tests of the mutation's subject that fail; in a quick run the first of them.
    fn failures(&self, mutation: &Mutation) -> Result<Vec<Test>, String> {
        let mut failures = Vec::new();
        for &target in &mutation.targets {
            let said = self.files.with_extension("txt");
            let file = std::fs::File::create(&said).map_err(|error| at(&said, &error))?;
            let output = || std::fs::read(&said).map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
            let is_enough = || self.is_quick && output().is_ok_and(|output| first_failed(&output).is_some());
            let succeeded = succeeds_in_time(self.cargo(target).stdout(file).stderr(Stdio::null()), is_enough)?;
            let output = output().map_err(|error| at(&said, &error))?;
            let first = if self.is_quick { first_failed(&output) } else { None };
            let mut failed = first.map_or_else(|| failed(&output), |name| vec![name]);
            if succeeded != Some(true) && failed.is_empty() {
                failed.push(if succeeded.is_some() { "(ended early)" } else { "(did not end)" }.to_owned());
            }
            failures.extend(failed.into_iter().map(|name| (target, name)));
            if self.is_quick && !failures.is_empty() {
                failures.truncate(1);
                break;
            }
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

/// Whether a command succeeds, or `None` if it is ended: after [`TIME_LIMIT`], or as soon as its output `is_enough`.
fn succeeds_in_time(command: &mut Command, is_enough: impl Fn() -> bool) -> Result<Option<bool>, String> {
    // A group of its own, so that the test programs end with cargo.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    let mut child = command.spawn().map_err(|error| format!("cannot run cargo: {error}"))?;
    let start = Instant::now();
    while start.elapsed() < TIME_LIMIT && !is_enough() {
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

/// A single change that makes the code wrong.
#[derive(Debug)]
struct Mutation {
    /// The subject, and what is wrong: `SUBJECT: WRONG`.
    name: &'static str,
    /// Cargo's arguments for each target whose tests ought to notice.
    targets: Vec<&'static str>,
    /// From the repository's root.
    file: &'static str,
    /// A text that stands in the file once.
    from: String,
    /// The text that replaces it.
    to: String,
}

impl Mutation {
    fn is_shader(&self) -> bool {
        self.file.starts_with("wgsl/")
    }

    fn subject(&self) -> &'static str {
        self.name.split(": ").next().unwrap_or_default()
    }

    /// The file's text with the mutation. It is an error if the old text is not there once, or the new one is the same.
    fn mutated(&self) -> Result<String, String> {
        let text = std::fs::read_to_string(process::root().join(self.file)).unwrap_or_default();
        match text.matches(&self.from).count() {
            1 if self.from != self.to => Ok(text.replacen(&self.from, &self.to, 1)),
            count => Err(format!("{}: {} has `{}` {count} times, or keeps it", self.name, self.file, self.from)),
        }
    }
}

/// All mutations of `xtask/mutations.txt`. Mutations of a subject are neighbours.
fn all() -> Result<Vec<Mutation>, String> {
    parse(include_str!("../mutations.txt"))
}

fn parse(text: &'static str) -> Result<Vec<Mutation>, String> {
    let mut mutations = Vec::new();
    for block in text.split("\n= ").skip(1) {
        let mut lines = block.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
        let (name, file) = lines.next().and_then(|line| line.rsplit_once(" @ ")).unwrap_or_default();
        let mut subjects = text.lines().filter_map(|line| line.strip_prefix("@ ")?.split_once(": "));
        let subject = subjects.find(|(subject, _)| name.split(": ").next() == Some(subject));
        let (mut from, mut to) = (Vec::new(), Vec::new());
        for line in lines {
            match (line.strip_prefix("- "), line.strip_prefix("+ ")) {
                (Some(old), _) if to.is_empty() => from.push(old),
                (_, Some(new)) => to.push(new),
                _ => return Err(format!("{name}: `{line}` is out of place")),
            }
        }
        let targets = subject.ok_or_else(|| format!("`{name}` does not begin with a subject"))?.1.split(", ").collect();
        mutations.push(Mutation { name, targets, file, from: from.join("\n"), to: to.join("\n") });
    }
    mutations.sort_by_key(Mutation::subject);
    Ok(mutations)
}

/// A test: its target, and its name there.
type Test = (&'static str, String);

/// The tests that fail with a mutation, or why it could not be tried.
type Outcome = Result<Vec<Test>, String>;

fn described(outcome: &Outcome) -> String {
    match outcome.as_deref() {
        Ok([]) => "SURVIVED".into(),
        Ok([test]) => format!("killed by {}", named(test)),
        Ok(failed) => format!("killed by {}", failed.len()),
        Err(why) => format!("NOT TRIED, {why}"),
    }
}

/// Runs each test that noticed a mutation without one, where it must pass.
fn pass_without(copies: &[WorkingCopy; 2], columns: &[(&Mutation, Outcome)]) -> Result<(), String> {
    let mut noticing = BTreeSet::new();
    for (mutation, outcome) in columns {
        noticing.extend(outcome.iter().flatten().map(|test| (mutation.is_shader(), test)));
    }
    for (is_shader, test) in noticing.into_iter().filter(|(_, (_, name))| !name.starts_with('(')) {
        let mut command = copies[usize::from(!is_shader)].cargo(test.0);
        process::output(command.args(["--", "--exact", &test.1]))
            .map_err(|_| format!("without a mutation, this test fails, too: {}", named(test)))?;
    }
    Ok(())
}

/// A test as the report has it.
fn named((target, name): &Test) -> String {
    format!("{} {name}", target.trim_start_matches("--test "))
}

/// The mutations with a number each, then a row for each test, with an `x` below the mutations that it notices. A quick
/// run, without `tests`, has no rows.
fn shown(tests: Option<&[Test]>, columns: &[(&Mutation, Outcome)]) -> String {
    let legend = columns.iter().map(|(mutation, result)| format!("{}: {}", mutation.name, described(result)));
    let mut lines: Vec<_> = (1..).zip(legend).map(|(number, line)| format!("{number:3}  {line}")).collect();
    let Some(tests) = tests else { return lines.join("\n") + "\n" };
    lines.push((1..=columns.len()).fold("\n".into(), |line, number| format!("{line}{number:3}")));
    // Tests, and programs that ended early or had to be ended.
    let failed = columns.iter().filter_map(|(_, result)| result.as_ref().ok()).flatten();
    let rows: BTreeSet<_> = tests.iter().chain(failed).collect();
    lines.extend(rows.into_iter().map(|test| {
        let is_noticed = |result: &Outcome| result.as_ref().is_ok_and(|failed| failed.contains(test));
        let marks: String = columns.iter().map(|(_, result)| if is_noticed(result) { "  x" } else { "  ." }).collect();
        format!("{marks}  {}", named(test))
    }));
    lines.join("\n") + "\n"
}

/// The names in the lists of failed tests that test programs print at their ends.
fn failed(output: &str) -> Vec<String> {
    let (mut names, mut is_list) = (Vec::new(), false);
    for line in output.lines() {
        match line.strip_prefix("    ") {
            Some(name) if is_list => names.push(name.to_owned()),
            _ => is_list = line == "failures:" || (is_list && line.is_empty()),
        }
    }
    names
}

/// The name in the first line about a failed test, which test programs print while they run.
fn first_failed(output: &str) -> Option<String> {
    let name = output.lines().find_map(|line| line.strip_prefix("test ")?.strip_suffix(" ... FAILED"))?;
    Some(without_kind(name.trim()).to_owned())
}

/// The names that test programs print when they are asked for a list.
fn listed(output: &str) -> impl Iterator<Item = String> {
    output.lines().filter_map(|line| line.strip_suffix(": test")).map(|name| without_kind(name).to_owned())
}

/// `name` of `[gpu] name`.
fn without_kind(name: &str) -> &str {
    name.split_once("] ").map_or(name, |(_kind, name)| name.trim_start())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names come from the list at the end, not from what failed tests said before it.
    #[test]
    fn failed_tests_are_read() {
        let output = "test a::b ... FAILED\n\nfailures:\n\n---- a::b ----\nleft:\n    1\n\n\nfailures:\n    a::b\n    c d\n\n\
                      test result: FAILED. 1 passed; 2 failed;\n    x\n";
        assert_eq!(failed(output), ["a::b", "c d"]);
        assert_eq!(first_failed(output).as_deref(), Some("a::b"));
        let while_running = "test [gpu] a   ... ok\ntest [gpu] b c ... FAILED\ntest d ... FAILED\n";
        assert_eq!(first_failed(while_running).as_deref(), Some("b c"));
        let good = "test a ... ok\n\ntest result: ok. 1 passed;\n";
        assert!(failed(good).is_empty() && first_failed(good).is_none());
        let listed: Vec<_> = listed("adapter: x\n[gpu] a: b: test\nc::d: test\n\n2 tests, 0 benchmarks\n").collect();
        assert_eq!(listed, ["a: b", "c::d"]);
    }

    /// A row tells which mutations its test notices.
    #[test]
    fn rows_are_marked() {
        let [a, b] = ["a", "b"].map(|name| ("--lib", name.to_owned()));
        let mutations = all().expect("the list is well-formed");
        assert_eq!(described(&Ok(vec![a.clone(), b.clone()])), "killed by 2");
        let outcomes: [Outcome; 2] = [vec![b.clone()], Vec::new()].map(Ok);
        let columns: Vec<_> = mutations.iter().zip(outcomes).collect();
        let matrix = shown(Some(&[a, b]), &columns);
        assert!(matrix.ends_with(": SURVIVED\n\n  1  2\n  .  .  --lib a\n  x  .  --lib b\n"), "{matrix}");
        assert!(matrix.contains(": killed by --lib b\n"), "{matrix}");
        let quick = shown(None, &columns);
        assert!(quick.ends_with(": SURVIVED\n") && matrix.starts_with(&quick), "{quick}");
    }

    /// Each mutation changes the code of today.
    #[test]
    fn every_mutation_fits_the_code_once() {
        let mutations = all().expect("the list is well-formed");
        let wrong: Vec<_> = mutations.iter().filter_map(|mutation| mutation.mutated().err()).collect();
        assert!(mutations.len() > 50, "only {} mutations found", mutations.len());
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }

    /// Negative controls.
    #[test]
    fn what_does_not_fit_is_noticed() {
        for wrong in ["\n= b: x @ f\n- a", "\n@ a: t\n= a: x @ f\n+ b\n- a", "\n@ a: t\n= a: x @ f\nb"] {
            assert!(parse(wrong).is_err(), "{wrong:?}");
        }
        let text = "# c\n@ a: t, u\n\n= a: x @ Cargo.toml\n- e\n- f\n+ g\n\n# d\n= a: y @ Cargo.toml\n- e\n";
        let two = parse(text).expect("well-formed");
        assert_eq!((&*two[0].targets, &*two[0].from, &*two[0].to, &*two[1].to), (&["t", "u"][..], "e\nf", "g", ""));
        assert!(two.iter().all(|mutation| mutation.mutated().is_err()));
    }
}
