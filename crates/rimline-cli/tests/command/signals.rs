//! Signals that ask the command to end, sent to a measurement after its first row.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, Stdio};

use super::run::{folder, with_signals};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("signals::a_hang_up_that_is_ignored_stays_ignored", ignored),
    ("signals::each_ends_with_its_own_code", codes),
    ("signals::the_second_removes_what_is_unfinished", second),
];

/// Measures rows on the CPU after `script`, sends the signals after the first row; exit code and messages.
fn measured(script: &str, folder: &Path, meshes: &str, signals: &[&str]) -> Result<(i32, String), String> {
    let line =
        "exec \"$0\" bench --quick --device cpu --scenes none --lights 1 --rounds 3 --meshes \"$1\" --json \"$2\"";
    let mut run = with_signals("sh")
        .args(["-c", &format!("{script} {line}"), env!("CARGO_BIN_EXE_rimline"), meshes])
        .arg(folder.join("out.json"))
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| error.to_string())?;
    let mut messages = BufReader::new(run.stderr.take().ok_or("no standard error")?);
    let mut text = String::new();
    while !text.contains(" 1/") {
        let read = messages.read_line(&mut text).map_err(|error| error.to_string())?;
        ensure!(read > 0, "it ended before its first row: {text}");
    }
    let pid = run.id().to_string();
    for signal in signals {
        let kill = Command::new("kill").args([*signal, &pid]).status();
        ensure!(kill.is_ok_and(|status| status.success()), "no signal could be sent: {text}");
    }
    messages.read_to_string(&mut text).map_err(|error| error.to_string())?;
    let status = run.wait().map_err(|error| error.to_string())?;
    Ok((status.code().unwrap_or(-1), text))
}

/// Rows enough that no run ends before the signal comes.
fn rows(count: usize) -> String {
    vec!["65536"; count].join(",")
}

fn ignored() -> Outcome {
    let folder = folder();
    let (code, text) = measured("trap '' HUP;", folder.path(), &rows(6), &["-HUP"])?;
    ensure!(code == 0 && text.contains(" 6/6"), "it ended with {code}: {text}");
    let (code, text) = measured("trap '' HUP INT;", folder.path(), &rows(6), &["-HUP", "-INT"])?;
    ensure!(code == 0 && text.contains(" 6/6"), "it ended with {code}: {text}");
    // What is not ignored still ends it.
    let (code, text) = measured("trap '' HUP;", folder.path(), &rows(60), &["-HUP", "-INT"])?;
    ensure!(code == 130 && !text.contains(" 60/"), "it ended with {code}: {text}");
    Ok(())
}

fn codes() -> Outcome {
    for (signal, wanted) in [("-HUP", 129), ("-INT", 130), ("-TERM", 143)] {
        let folder = folder();
        let (code, text) = measured("", folder.path(), &rows(60), &[signal])?;
        ensure!(code == wanted, "{signal}: it ended with {code}: {text}");
        only_data(folder.path())?;
    }
    Ok(())
}

fn second() -> Outcome {
    let folder = folder();
    let (code, text) = measured("", folder.path(), &rows(60), &["-TERM", "-INT"])?;
    ensure!([130, 143].contains(&code), "it ended with {code}: {text}");
    only_data(folder.path())
}

/// No part of a file is there.
fn only_data(folder: &Path) -> Outcome {
    for entry in std::fs::read_dir(folder).map_err(|error| error.to_string())? {
        let name = entry.map_err(|error| error.to_string())?.file_name();
        ensure!(name == OsStr::new("out.json"), "left behind: {name:?}");
    }
    Ok(())
}
