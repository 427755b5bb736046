//! Signals that ask the command to end: while it measures, films, works through jobs, and compiles shaders.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use super::makers::{npz_model, tetrahedron};
use super::run::{Folder, contents, folder, is_long, with_signals};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    #[cfg(feature = "bench")]
    ("signals::each_ends_with_its_own_code_unless_it_is_ignored", codes),
    ("signals::a_film_says_how_far_it_came", film),
    ("signals::jobs_stop_between_two_and_resume_goes_on", jobs),
    ("signals::one_while_shaders_compile_ends_with_its_own_code", compiling),
];

fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

fn send(run: &Child, signal: &str) -> Outcome {
    let kill = Command::new("kill").args([signal, &run.id().to_string()]).status();
    ensure!(kill.is_ok_and(|status| status.success()), "no signal could be sent");
    Ok(())
}

/// Runs `rimline` in a folder, without waiting for its end.
fn start(folder: &Folder, line: &str) -> Result<Child, String> {
    let mut command = with_signals(env!("CARGO_BIN_EXE_rimline"));
    command.args(line.split(' ')).current_dir(folder.path()).env("MESA_SHADER_CACHE_DISABLE", "1");
    command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().map_err(text)
}

/// Exit code and messages.
fn end(run: Child) -> Result<(Option<i32>, String), String> {
    let output = run.wait_with_output().map_err(text)?;
    Ok((output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned()))
}

/// Sends signals to a measurement after its first row; exit code and messages.
#[cfg(feature = "bench")]
pub(crate) fn after_a_row(command: &mut Command, signals: &[&str]) -> Result<(i32, String), String> {
    let mut run = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().map_err(text)?;
    let mut messages = BufReader::new(run.stderr.take().ok_or("no standard error")?);
    let mut found = String::new();
    while !found.contains(" 1/") {
        ensure!(messages.read_line(&mut found).map_err(text)? > 0, "it ended before its first row: {found}");
    }
    signals.iter().try_for_each(|signal| send(&run, signal))?;
    messages.read_to_string(&mut found).map_err(text)?;
    Ok((run.wait().map_err(text)?.code().unwrap_or(-1), found))
}

/// A second signal removes what is unfinished. 60 rows are so many that no run ends before a signal comes.
#[cfg(feature = "bench")]
fn codes() -> Outcome {
    let line =
        "exec \"$0\" bench --quick --device cpu --scenes none --lights 1 --rounds 3 --json out.json --meshes \"$1\"";
    for (ignored, rows, signals, wanted) in [
        ("trap '' HUP INT;", 6, &["-HUP", "-INT"][..], &[0][..]),
        ("trap '' HUP;", 60, &["-HUP", "-INT"], &[130]),
        ("", 60, &["-HUP"], &[129]),
        ("", 60, &["-INT"], &[130]),
        ("", 60, &["-TERM"], &[143]),
        ("", 60, &["-TERM", "-INT"], &[130, 143]),
    ] {
        let folder = folder();
        let mut shell = with_signals("sh");
        shell.args(["-c", &format!("{ignored} {line}"), env!("CARGO_BIN_EXE_rimline")]);
        // A number that is there twice is measured once.
        let faces: Vec<_> = (0..rows).map(|row| (16_384 + 1024 * row).to_string()).collect();
        shell.arg(faces.join(",")).current_dir(folder.path());
        let (code, found) = after_a_row(&mut shell, signals)?;
        ensure!(wanted.contains(&code), "{ignored} {signals:?}: it ended with {code}: {found}");
        ensure!(found.contains(&format!(" {rows}/{rows}")) == (code == 0), "{signals:?}: {found}");
        let left: Vec<_> = folder.contents()?.into_keys().filter(|name| name != "out.json").collect();
        ensure!(left.is_empty(), "left behind: {left:?}");
    }
    Ok(())
}

/// Waits for a file.
fn wait_for(file: &Path) -> Outcome {
    let until = std::time::Instant::now() + std::time::Duration::from_secs(60);
    while !file.exists() {
        ensure!(std::time::Instant::now() < until, "{} was not written", file.display());
        std::thread::yield_now();
    }
    Ok(())
}

fn film() -> Outcome {
    let folder = folder();
    folder.write("m.npz", tetrahedron())?;
    let run = start(&folder, "film m.npz --orbit 360 --frames 5000 --size 16x12 --out film")?;
    wait_for(&folder.path().join("film/0002.png"))?;
    send(&run, "-INT")?;
    let (code, found) = end(run)?;
    ensure!(code == Some(130), "{code:?}: {found}");
    let pictures = contents(&folder.path().join("film"))?.len();
    // The signal may come between a picture's last byte and its count.
    let says = |count: usize| found.contains(&format!("{count} of 5000 pictures are in film; --resume goes on"));
    ensure!(says(pictures) || says(pictures - 1), "{pictures} pictures are there: {found}");
    Ok(())
}

/// The job that runs ends. All that is there is complete, and there is more to do.
fn jobs() -> Outcome {
    const JOBS: usize = 200;
    let folder = folder();
    folder.write("m.npz", tetrahedron())?;
    folder.write("jobs.jsonl", "{}\n".repeat(JOBS))?;
    let out = folder.inner("out")?;
    let count = || -> Result<usize, String> {
        let files = contents(&out)?;
        let first = files.values().next().ok_or("there is no file")?;
        let is_whole = |(name, bytes): (&String, &Vec<u8>)| name.len() == 8 && bytes == first && !bytes.is_empty();
        ensure!(files.iter().all(is_whole), "a file is not complete");
        Ok(files.len())
    };
    let line = "extract m.npz --jobs jobs.jsonl --device cpu --light dir:0,1,0 --out out/{index}.npz";
    let run = start(&folder, line)?;
    wait_for(&out.join("0002.npz"))?;
    send(&run, "-INT")?;
    let (code, found) = end(run)?;
    let there = count()?;
    ensure!(code == Some(130) && there < JOBS, "{there} files, {code:?}: {found}");
    let (code, found) = end(start(&folder, &format!("{line} --resume"))?)?;
    ensure!(code == Some(0) && count()? == JOBS, "{} files, {code:?}: {found}", count()?);
    Ok(())
}

/// Signals at many moments of runs that compile all their shaders anew. Libraries' destructors would end one run in ten by a
/// signal of its own.
fn compiling() -> Outcome {
    let (trials, apart) = if is_long() { (30, 37) } else { (8, 139) };
    let folder = folder();
    folder.write("cube.npz", npz_model(&rimline_testkit::shapes::cube(), 1.0, [0.0, 2.0, 0.0]))?;
    let mut stopped = 0;
    for trial in 0..trials {
        let (signal, wanted) = if trial % 2 == 0 { ("-INT", 130) } else { ("-TERM", 143) };
        let mut run = start(&folder, "shadow --size 64x48 cube.npz --out out.png")?;
        std::thread::sleep(std::time::Duration::from_millis(100 + apart * trial));
        if run.try_wait().map_err(text)?.is_none() {
            send(&run, signal)?;
        }
        // It may be done before the signal comes.
        let (code, found) = end(run)?;
        ensure!(code == Some(wanted) || code == Some(0), "trial {trial}: {code:?}: {found}");
        stopped += u64::from(code == Some(wanted));
        let left = folder.contents()?;
        ensure!(code == Some(0) || left.len() == 1, "trial {trial}: left behind: {:?}", left.keys());
        let _ = std::fs::remove_file(folder.path().join("out.png"));
    }
    ensure!(stopped > 3, "only {stopped} of {trials} runs were stopped");
    Ok(())
}
