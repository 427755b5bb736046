//! Cases of `data/*.txt`: command lines, and what must come of them.
//!
//! A case begins with `= NAME` and has an empty folder for itself, in which its command lines run. Its paragraphs, parted by
//! empty lines, have steps: input files (`makers.rs`), then command lines: `$` for the command itself, with `< FILE` for
//! standard input, `%` for the shell. Rows follow, each with an exit code, words that stand for `{}` in the steps, and after
//! `!` the one line of standard error. Under a row are more lines of standard error (`!`), those of standard output (`>`), and
//! facts (`facts.rs`), parted by `; `. Facts above the rows hold for each of them. All holds for each of the paragraph's
//! command lines; facts of files hold after the last. `[..]` stands for any text, a line `...` for any lines.
//!
//! Standard error must be just as it is written, but for clap's usage and hint at `--help`; standard output wherever something
//! is written for it. Neither may steer a terminal. What fails must leave the folder as it was, unless only some of many jobs failed (6). `RIMLINE_CASES=write`
//! writes the lines that differ anew.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;

use libtest_mimic::{Failed, Trial};

use super::run::{Folder, Run, folder, run_command};
use super::{Outcome, ensure, facts, makers};

/// A message that makes the line longer has one of its own.
const WIDTH: usize = 150;

/// A trial for each case.
pub(crate) fn trials() -> Vec<Trial> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/command/data");
    let mut files: Vec<PathBuf> = std::fs::read_dir(&folder)
        .unwrap_or_else(|error| panic!("{}: {error}", folder.display()))
        .filter_map(|entry| Some(entry.ok()?.path()))
        .collect();
    files.sort();
    files.into_iter().flat_map(|file| of_file(&file)).collect()
}

fn of_file(file: &Path) -> Vec<Trial> {
    let text = std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let cases = text.split("\n= ").skip(1).map(|case| runnable(case.trim_end())).filter(|case| !case.is_empty());
    let trial = |case: String| {
        let file = file.to_owned();
        let name = format!("{stem}::{}", case.lines().next().unwrap_or_default().replace(' ', "_"));
        Trial::test(name, move || {
            let found = check(&case)?;
            if found != case && std::env::var_os("RIMLINE_CASES").is_some_and(|word| word == "write") {
                static WRITING: Mutex<()> = Mutex::new(());
                let _one = WRITING.lock();
                let text = std::fs::read_to_string(&file)?.replace(&case, &found);
                return Ok(std::fs::write(&file, text)?);
            }
            differences(&case, &found).map_err(Failed::from)
        })
    };
    cases.map(trial).collect()
}

/// A case up to the first paragraph with a step that cannot run here, and without such rows.
fn runnable(case: &str) -> String {
    let is_out = |line: &str| {
        (cfg!(not(unix)) && line.starts_with('%'))
            || (cfg!(not(feature = "bench")) && line.contains("bench --"))
            || (cfg!(not(feature = "view")) && line.contains("rimline view"))
    };
    let kept = |part: &str| {
        let mut is_kept = true;
        let lines = part.lines().filter(|line| {
            if is_row(line) {
                is_kept = !is_out(line);
            }
            is_kept
        });
        lines.collect::<Vec<_>>().join("\n")
    };
    let parts = case.split("\n\n").take_while(|part| !part.lines().any(|line| is_step(line) && is_out(line)));
    parts.map(kept).collect::<Vec<_>>().join("\n\n")
}

/// The lines that a case should have. Facts that do not hold are errors.
pub(crate) fn check(case: &str) -> Result<String, String> {
    let folder = folder();
    let found: Result<Vec<String>, String> = case.split("\n\n").map(|part| paragraph(&folder, part)).collect();
    Ok(found?.join("\n\n"))
}

/// Nothing, or the lines that differ.
pub(crate) fn differences(case: &str, found: &str) -> Outcome {
    let [mut old, mut new]: [Vec<&str>; 2] = [case, found].map(|text| text.lines().collect());
    let alike = old.iter().zip(&new).take_while(|(old, new)| old == new).count();
    let [last, context] = [alike, alike.saturating_sub(3)];
    let before = old[context..last].join("\n");
    (old, new) = (old.split_off(alike), new.split_off(alike));
    while old.last().is_some_and(|line| new.last() == Some(line)) {
        old.pop();
        new.pop();
    }
    let side =
        |sign: char, lines: &[&str]| lines.iter().map(|line| format!("\n{sign}{line}")).collect::<Vec<_>>().concat();
    ensure!(old.is_empty() && new.is_empty(), "{before}{}{}", side('-', &old), side('+', &new));
    Ok(())
}

/// Whether a line is a step: it makes something or runs it.
fn is_step(line: &str) -> bool {
    line.starts_with(['$', '%', ' ', '#']) || makers::is_one(line)
}

/// Whether a line begins a row: it has an exit code.
fn is_row(line: &str) -> bool {
    line.starts_with(|c: char| c.is_ascii_digit())
}

/// Runs a paragraph, and returns it with the lines that it should have.
fn paragraph(folder: &Folder, text: &str) -> Result<String, String> {
    let all: Vec<&str> = text.lines().collect();
    // The name of the case comes first.
    let start = usize::from(!all.first().is_some_and(|line| is_step(line)));
    let end = start + all[start..].iter().take_while(|line| is_step(line)).count();
    let steps = &all[start..end];
    let first = all.iter().position(|line| is_row(line)).filter(|at| *at >= end);
    let shared = &all[end..first.unwrap_or(end)];
    let mut rows: Vec<Vec<&str>> = if first.is_none() { vec![vec!["0"]] } else { Vec::new() };
    for line in &all[end + shared.len()..] {
        match rows.last_mut() {
            Some(row) if !is_row(line) => row.push(line),
            _ => rows.push(vec![line]),
        }
    }
    let mut found = all[..end + shared.len()].join("\n");
    for row in rows {
        let lines = of_row(folder, steps, shared, &row);
        let lines = lines.map_err(|error| format!("{}\n{}: {error}", steps.join("\n"), row[0]))?;
        let skipped = usize::from(first.is_none() && lines[0] == "0");
        found.extend(lines[skipped..].iter().flat_map(|line| ["\n", line]));
    }
    Ok(found)
}

/// Runs the steps for a row, and returns the lines that it should have.
fn of_row(folder: &Folder, steps: &[&str], shared: &[&str], row: &[&str]) -> Result<Vec<String>, String> {
    let (head, message) = row[0].split_once(" ! ").map_or((row[0], None), |(head, message)| (head, Some(message)));
    let words = head.split_once(' ').map_or("", |(_, words)| words);
    let steps: Vec<String> = steps.iter().map(|line| line.replace("{}", words)).collect();
    let lines_of = |sign: char| row[1..].iter().filter_map(move |line| line.strip_prefix(sign)).map(str::trim);
    let lines_of_row: Vec<&str> = row[1..].iter().filter(|line| !line.starts_with(['!', '>'])).copied().collect();
    let facts =
        || shared.iter().chain(&lines_of_row).filter(|line| !line.starts_with('#')).flat_map(|line| line.split("; "));
    let mut found = Vec::new();
    for at in 0..steps.len() {
        let Some(command) = steps[at].strip_prefix(['$', '%']) else {
            makers::step(folder, &steps[at..])?;
            continue;
        };
        let before = folder.contents()?;
        let run = if steps[at].starts_with('$') { run_line(folder, command)? } else { by_shell(folder, command) };
        let after = folder.contents()?;
        ensure!([0, 6].contains(&run.code) || before == after, "the folder is not as it was: {:?}", after.keys());
        let mut lines = vec![format!("{} {words}", run.code).trim_end().to_owned()];
        let wild =
            |text: &str| text.contains(|c: char| c == '\u{202e}' || c.is_control() && !['\n', '\t'].contains(&c));
        ensure!(!wild(&run.stdout) && !wild(&run.stderr), "it steers a terminal: {:?} {:?}", run.stdout, run.stderr);
        let mut stderr = run.stderr.replace("\n\nFor more information, try '--help'.", "");
        if let Some(at) = stderr.find("\n\nUsage: ").filter(|_| stderr.starts_with("error: ")) {
            let end = stderr[at + 2..].find('\n').map_or(stderr.len(), |end| at + 2 + end);
            stderr.replace_range(at..end, "");
        }
        for (sign, stream) in [('!', &stderr), ('>', &run.stdout)] {
            let expected: Vec<&str> = message.filter(|_| sign == '!').into_iter().chain(lines_of(sign)).collect();
            let got: Vec<&str> = stream.lines().map(str::trim).collect();
            let is_right = matches(&expected, &got) || sign == '>' && expected.is_empty();
            match &(if is_right { expected } else { got })[..] {
                [one] if sign == '!' && lines[0].len() + one.len() < WIDTH => lines[0].extend([" ! ", *one]),
                right => lines.extend(right.iter().map(|line| format!("{sign} {line}").trim_end().to_owned())),
            }
        }
        let new: Vec<&str> = after.keys().filter(|name| !before.contains_key(*name)).map(String::as_str).collect();
        let is_last = !steps[at + 1..].iter().any(|line| line.starts_with(['$', '%']));
        for fact in facts().filter(|fact| is_last || facts::is_of_output(fact)) {
            facts::check(folder, &run.stdout, &new, fact)
                .map_err(|error| format!("{command}\n{fact}: {error}\n{}{}", run.stdout, run.stderr))?;
        }
        lines.extend(lines_of_row.iter().map(|fact| (*fact).to_owned()));
        // A line that is wrong for one of the commands is shown as that one has it.
        if found.is_empty() || differences(&row.join("\n"), &found.join("\n")).is_ok() {
            found = lines;
        }
    }
    if found.is_empty() {
        // Nothing ran.
        found.extend(row.iter().map(|line| (*line).to_owned()));
    }
    Ok(found)
}

fn matches(pattern: &[&str], lines: &[&str]) -> bool {
    match pattern {
        [] => lines.is_empty(),
        ["...", rest @ ..] => (0..=lines.len()).any(|at| matches(rest, &lines[at..])),
        [first, rest @ ..] => lines.first().is_some_and(|line| fits(first, line)) && matches(rest, &lines[1..]),
    }
}

fn fits(pattern: &str, line: &str) -> bool {
    let Some((start, rest)) = pattern.split_once("[..]") else { return pattern == line };
    line.strip_prefix(start)
        .is_some_and(|line| (0..=line.len()).any(|at| line.is_char_boundary(at) && fits(rest, &line[at..])))
}

/// `rimline WORDS`, with `NAME=VALUE` before it and `< FILE` at its end.
fn run_line(folder: &Folder, line: &str) -> Result<Run, String> {
    let (line, input) = line.split_once(" < ").map_or((line, None), |(line, file)| (line, Some(file)));
    let (variables, words) = line.trim().split_once("rimline").ok_or("no `rimline`")?;
    let mut command = Command::new(env!("CARGO_BIN_EXE_rimline"));
    // Else it runs itself again with this (src/main.rs), as it does from the shell.
    command.args(words.split_whitespace()).current_dir(folder.path()).env("XDG_RUNTIME_DIR", "/dev/null");
    command.envs(variables.split_whitespace().filter_map(|word| word.split_once('=')));
    let file = input.map(|file| std::fs::File::open(folder.path().join(file))).transpose();
    command.stdin(file.map_err(|error| error.to_string())?.map_or_else(Stdio::null, Stdio::from));
    Ok(run_command(&mut command))
}

/// A line for the shell, which finds `rimline`.
fn by_shell(folder: &Folder, script: &str) -> Run {
    let program = Path::new(env!("CARGO_BIN_EXE_rimline")).parent().unwrap_or(Path::new("."));
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap_or_default());
    let mut command = Command::new("sh");
    run_command(command.args(["-c", script]).current_dir(folder.path()).env("PATH", path).stdin(Stdio::null()))
}
