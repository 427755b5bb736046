//! Texts of the command: nothing but its own words, examples that can be pasted, messages that name what to do.

use std::path::Path;
use std::process::Command;

use super::makers::tetrahedron;
use super::run::{folder, rimline_with};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("words::examples_are_the_same_at_any_width", widths),
    #[cfg(unix)]
    ("words::examples_can_be_pasted", pasted),
    ("words::set_up_and_work_are_timed_apart", times),
];

const COMMANDS: [&str; 10] =
    ["draw", "lines", "shadow", "film", "extract", "query", "info", "devices", "verify", "bench"];

/// The command without a desktop session, by a shell that runs `script`.
#[cfg(unix)]
fn by_shell(script: &str, folder: &Path, width: &str) -> std::process::Output {
    let program = Path::new(env!("CARGO_BIN_EXE_rimline"));
    let path = std::env::var("PATH").unwrap_or_default();
    Command::new("sh")
        .args(["-c", script])
        .current_dir(folder)
        .env_remove("XDG_RUNTIME_DIR")
        .env_remove("NODEVICE_SELECT")
        .env("COLUMNS", width)
        .env("PATH", format!("{}:{path}", program.parent().unwrap_or(program).display()))
        .output()
        .expect("there is a shell")
}

/// The examples in a command's help: each with its broken lines.
fn examples(help: &str) -> Vec<String> {
    let mut examples: Vec<String> = Vec::new();
    let mut lines = help.lines().skip_while(|line| !line.starts_with("Example")).skip(1).peekable();
    while let Some(line) = lines.next_if(|line| line.starts_with("  ")) {
        match examples.last_mut() {
            Some(last) if last.ends_with('\\') => {
                last.push('\n');
                last.push_str(line);
            }
            _ => examples.push(line.to_owned()),
        }
    }
    examples
}

fn help(command: &str, option: &str, width: &str) -> Result<String, String> {
    let run = rimline_with([command, option], &[("COLUMNS", width)]);
    run.expect(0, &[])?;
    Ok(run.stdout)
}

fn widths() -> Outcome {
    for command in COMMANDS.into_iter().filter(|command| *command != "devices") {
        for option in ["-h", "--help"] {
            let [narrow, wide] = ["40", "300"].map(|width| help(command, option, width));
            let [narrow, wide] = [examples(&narrow?), examples(&wide?)];
            ensure!(!wide.is_empty(), "{command} {option} has no example");
            ensure!(narrow == wide, "{command} {option}: {narrow:?} instead of {wide:?}");
        }
    }
    Ok(())
}

#[cfg(unix)]
fn pasted() -> Outcome {
    let folder = folder();
    for command in COMMANDS.into_iter().filter(|command| *command != "devices") {
        let help = help(command, "--help", "40")?;
        for example in examples(&help) {
            ensure!(example.trim_start().starts_with(&format!("rimline {command} ")), "{example}");
            ensure!(example.lines().all(|line| line.chars().count() <= 90), "{example} is too long for a terminal");
            for option in example.split_whitespace().filter(|word| word.starts_with("--")) {
                ensure!(help.contains(&format!(" {option}")), "{example}: there is no {option}");
            }
            // Measurements would run; the others have no input here, which is not an error of the line.
            let would_run = command == "bench" || example.contains("--built-in");
            let (script, codes) =
                if would_run { (format!("sh -n <<'_'\n{example}\n_"), [0; 2]) } else { (example, [1, 4]) };
            let run = by_shell(&script, folder.path(), "80");
            let code = run.status.code().unwrap_or(-1);
            ensure!(codes.contains(&code), "{script}: {code}, {}", String::from_utf8_lossy(&run.stderr));
        }
    }
    Ok(())
}

fn times() -> Outcome {
    let folder = folder();
    folder.write("m.npz", tetrahedron())?;
    let lines = [
        "extract @m.npz --device gpu --light dir:0,1,0 --out @a.npz",
        "shadow @m.npz --size 64x64 --light dir:0,1,0 --out @a.png",
    ];
    for line in lines {
        let json = folder.run(&format!("{line} --json")).json()?;
        let stages = json["milliseconds"].as_object().ok_or("no milliseconds")?;
        ensure!(stages.contains_key("compile") && stages.contains_key("device"), "{json}");
        let sum: f64 = stages.values().filter_map(serde_json::Value::as_f64).sum();
        let of = |key: &str| json[key].as_f64().ok_or(format!("no {key}: {json}"));
        let (set_up, work) = (of("set_up_milliseconds")?, of("work_milliseconds")?);
        ensure!(set_up > 0.0 && work > 0.0 && (set_up + work - sum).abs() < 1e-6 * sum, "{json}");
        let text = folder.run(line);
        text.expect(0, &[])?;
        ensure!(text.stdout.contains("set-up ") && text.stdout.contains(", work "), "{}", text.stdout);
    }
    Ok(())
}
