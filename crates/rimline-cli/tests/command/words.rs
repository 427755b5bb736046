//! Examples of the help, which can be pasted.

use std::process::Command;

use super::run::{folder, rimline_with, run_command};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    #[cfg(unix)]
    ("words::examples_can_be_pasted_and_are_the_same_at_any_width", examples_work),
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
