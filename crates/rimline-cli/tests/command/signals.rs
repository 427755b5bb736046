//! Signals that ask the command to end, sent to a measurement after its first row.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Command, Stdio};

use super::run::{folder, is_empty, is_long, with_signals};
use super::shadow::with_cube;
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("signals::a_hang_up_that_is_ignored_stays_ignored", ignored),
    ("signals::each_ends_with_its_own_code", codes),
    ("signals::the_second_removes_what_is_unfinished", second),
    ("signals::a_film_says_how_far_it_came", film),
    ("signals::one_while_shaders_compile_ends_with_its_own_code", compiling),
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
    // A signal that is not ignored still ends the run.
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

fn film() -> Outcome {
    let folder = with_cube()?;
    let run = with_signals(env!("CARGO_BIN_EXE_rimline"))
        .args(["film", "cube.npz", "--orbit", "360", "--frames", "5000", "--size", "16x12", "--out", "film"])
        .current_dir(folder.path())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| error.to_string())?;
    let until = std::time::Instant::now() + std::time::Duration::from_secs(60);
    while !folder.path().join("film/0002.png").exists() {
        ensure!(std::time::Instant::now() < until, "no picture was written");
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let kill = Command::new("kill").args(["-INT", &run.id().to_string()]).status();
    ensure!(kill.is_ok_and(|status| status.success()), "no signal could be sent");
    let output = run.wait_with_output().map_err(|error| error.to_string())?;
    let text = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.code() == Some(130), "{}: {text}", output.status);
    let pictures = std::fs::read_dir(folder.path().join("film")).map_err(|error| error.to_string())?.count();
    // The signal may come between a picture's last byte and its count.
    let says = |count: usize| text.contains(&format!("{count} of 5000 pictures are in film; --resume goes on"));
    ensure!(says(pictures) || says(pictures - 1), "{pictures} pictures are there: {text}");
    Ok(())
}

/// Signals at many moments of runs that compile all their shaders anew. Libraries' destructors would end one run in ten by a
/// signal of its own.
fn compiling() -> Outcome {
    let (trials, apart) = if is_long() { (30, 37) } else { (8, 139) };
    let folder = with_cube()?;
    let results = folder.path().join("results");
    std::fs::create_dir(&results).map_err(|error| error.to_string())?;
    let mut stopped = 0;
    for trial in 0..trials {
        let (signal, wanted) = if trial % 2 == 0 { ("-INT", 130) } else { ("-TERM", 143) };
        let mut run = with_signals(env!("CARGO_BIN_EXE_rimline"))
            .env("MESA_SHADER_CACHE_DISABLE", "1")
            .args(["shadow", "--size", "64x48"])
            .arg(folder.path().join("cube.npz"))
            .arg("--out")
            .arg(results.join("out.png"))
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(|error| error.to_string())?;
        std::thread::sleep(std::time::Duration::from_millis(100 + apart * trial));
        if run.try_wait().map_err(|error| error.to_string())?.is_none() {
            let kill = Command::new("kill").args([signal, &run.id().to_string()]).status();
            ensure!(kill.is_ok_and(|status| status.success()), "no signal could be sent");
        }
        let output = run.wait_with_output().map_err(|error| error.to_string())?;
        let text = String::from_utf8_lossy(&output.stderr);
        // It may be done before the signal comes.
        let code = output.status.code();
        ensure!(code == Some(wanted) || code == Some(0), "trial {trial}: {}: {text}", output.status);
        stopped += u64::from(code == Some(wanted));
        if code == Some(wanted) {
            is_empty(&results).map_err(|error| format!("trial {trial}: {error}"))?;
        }
        let _ = std::fs::remove_file(results.join("out.png"));
    }
    ensure!(stopped > 3, "only {stopped} of {trials} runs were stopped");
    Ok(())
}
