//! Examples of the help, which can be pasted.

use std::process::Command;

#[cfg(target_os = "linux")]
use super::makers::tetrahedron;
use super::run::{folder, rimline_with, run_command};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    #[cfg(unix)]
    ("words::examples_can_be_pasted_and_are_the_same_at_any_width", examples_work),
    #[cfg(target_os = "linux")]
    ("words::no_color_is_heeded_on_a_terminal", no_color),
];

/// The examples in a command's help: each with its broken lines.
fn examples(command: &str, option: &str, width: &str) -> Result<(Vec<String>, String), String> {
    let run = rimline_with([command, option], &[("COLUMNS", width)]);
    run.expect(0, &[])?;
    let mut examples: Vec<String> = Vec::new();
    let mut lines = run.stdout.lines().skip_while(|line| !line.starts_with("Example")).skip(1).peekable();
    while let Some(line) = lines.next_if(|line| line.starts_with("  ")) {
        match examples.last_mut() {
            Some(last) if last.ends_with('\\') => last.extend(["\n", line]),
            _ => examples.push(line.to_owned()),
        }
    }
    Ok((examples, run.stdout))
}

#[cfg(unix)]
fn examples_work() -> Outcome {
    let folder = folder();
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_rimline")).parent().ok_or("no folder")?;
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap_or_default());
    for command in ["draw", "lines", "shadow", "film", "extract", "query", "info", "verify", "bench"] {
        let (found, help) = examples(command, "--help", "300")?;
        ensure!(!found.is_empty() && found == examples(command, "--help", "40")?.0, "{command}: {found:?}");
        ensure!(examples(command, "-h", "40")?.0 == examples(command, "-h", "300")?.0, "{command} -h");
        for example in found {
            ensure!(example.trim_start().starts_with(&format!("rimline {command} ")), "{example}");
            ensure!(example.lines().all(|line| line.chars().count() <= 90), "{example} is too long for a terminal");
            let mut options = example.split_whitespace().filter(|word| word.starts_with("--"));
            ensure!(options.all(|option| help.contains(&format!(" {option}"))), "{example}: an option is not there");
            // Measurements would run; the others have no input here, which is not an error of the line.
            let would_run = command == "bench" || example.contains("--built-in");
            let (script, codes) =
                if would_run { (format!("sh -n <<'_'\n{example}\n_"), [0; 2]) } else { (example, [1, 4]) };
            let mut shell = Command::new("sh");
            shell.args(["-c", &script]).current_dir(folder.path()).env("COLUMNS", "80").env("PATH", &path);
            let run = run_command(&mut shell);
            ensure!(codes.contains(&run.code), "{script}: {}, {}", run.code, run.stderr);
        }
    }
    Ok(())
}

/// The output of a command line on a terminal, which `script` of util-linux makes.
#[cfg(target_os = "linux")]
fn on_terminal(line: &str, no_color: &str) -> Result<String, String> {
    let folder = folder();
    folder.write("m.npz", tetrahedron())?;
    let line = format!("{} {line}", env!("CARGO_BIN_EXE_rimline"));
    let mut script = Command::new("script");
    script.args(["-qc", &line, "/dev/null"]).current_dir(folder.path()).stdin(std::process::Stdio::null());
    script.env("TERM", "xterm").env("NO_COLOR", no_color).env_remove("CLICOLOR").env_remove("CLICOLOR_FORCE");
    let output = script.output().map_err(|error| format!("`script` cannot be run: {error}"))?;
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Whether a text has a sequence that sets colours or weight: ESC [ numbers m.
#[cfg(target_os = "linux")]
fn is_colored(text: &str) -> bool {
    let numbers = |c: char| c.is_ascii_digit() || c == ';';
    text.split("\u{1b}[").skip(1).any(|rest| rest.trim_start_matches(numbers).starts_with('m'))
}

#[cfg(target_os = "linux")]
fn no_color() -> Outcome {
    if Command::new("script").arg("--version").output().is_err() {
        println!("left out: `script` is not installed");
        return Ok(());
    }
    // Errors of the parser are coloured. The line of progress clears itself, but has no colours either way.
    let (refused, worked) = ("extract m.npz", "extract m.npz --device cpu --light dir:0,1,0 --out out.npz");
    for (line, part) in [(refused, "--light <SPEC>"), (worked, "wrote out.npz")] {
        let plain = on_terminal(line, "1")?;
        ensure!(plain.contains(part) && !is_colored(&plain), "{line}: {plain:?}");
        let usual = on_terminal(line, "")?;
        ensure!(is_colored(&usual) == (line == refused), "{line} without NO_COLOR: {usual:?}");
    }
    // ESC [ 2 K clears the line of progress.
    for (line, is_shown) in [(worked.to_owned(), true), (format!("{worked} --quiet"), false)] {
        let found = on_terminal(&line, "1")?;
        ensure!(found.contains("\u{1b}[2K") == is_shown, "{line}: {found:?}");
    }
    Ok(())
}
