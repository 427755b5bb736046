//! Many jobs in one run: shards, signals, keys, and one device for all. `data/jobs.txt` has more.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value;

use super::makers::tetrahedron;
use super::run::{Folder, folder, rimline_with};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("jobs::each_job_is_in_one_shard", shards),
    ("jobs::one_device_does_all", device),
    #[cfg(unix)]
    ("jobs::a_signal_stops_between_jobs_and_resume_goes_on", stopped),
    ("jobs::keys_are_described", keys),
];

/// A folder with a file of so many jobs for one model.
fn jobs(count: usize, job: impl Fn(usize) -> String) -> Result<Folder, String> {
    let folder = folder();
    folder.write("m.npz", tetrahedron())?;
    let lines: Vec<String> = (0..count).map(job).collect();
    folder.write("jobs.jsonl", lines.join("\n"))?;
    Ok(folder)
}

/// The lines of JSON that a run prints, without the last, and that.
fn lines(stdout: &str) -> Result<(Vec<Value>, Value), String> {
    let read = |line| serde_json::from_str(line).map_err(|error| format!("{error} in: {line}"));
    let mut lines: Vec<Value> = stdout.lines().map(read).collect::<Result<_, _>>()?;
    let last = lines.pop().ok_or("nothing is printed")?;
    Ok((lines, last["totals"].clone()))
}

fn shards() -> Outcome {
    const JOBS: u64 = 7;
    let folder = jobs(JOBS as usize, |_| "{}".into())?;
    for count in 1..=9 {
        let mut met = BTreeSet::new();
        for number in 1..=count {
            let run = folder.run(&format!("info @m.npz --jobs @jobs.jsonl --json --shard {number}/{count}"));
            run.expect(0, &[])?;
            let (lines, totals) = lines(&run.stdout)?;
            ensure!(totals["jobs"] == lines.len() && totals["done"] == lines.len(), "{totals}");
            for line in lines {
                let job = line["job"].as_u64().ok_or("no number")?;
                ensure!(job % count + 1 == number, "{job} is in {number}/{count}");
                ensure!(met.insert(job), "{job} is in two shards of {count}");
            }
        }
        ensure!(met.into_iter().eq(0..JOBS), "a job is in no shard of {count}");
    }
    Ok(())
}

/// The log says how often a device is opened.
fn device() -> Outcome {
    let folder = jobs(3, |_| "{}".into())?;
    let inner = folder.path().join("").display().to_string();
    for line in ["draw --size 16x16 --out @{index}.png", "extract --device gpu --light dir:0,1,0 --out @{index}.npz"] {
        let line = format!("{line} --jobs @jobs.jsonl @m.npz").replace('@', &inner);
        let run = rimline_with(line.split(' '), &[("RUST_LOG", "off,rimline=debug")]);
        run.expect(0, &[])?;
        let opened = run.stderr.matches("] opened ").count();
        ensure!(opened == 1, "{line}: opened {opened} times");
    }
    Ok(())
}

/// The first signal lets the job that runs end. All that is there is complete, and there is more to do.
#[cfg(unix)]
fn stopped() -> Outcome {
    use super::run::with_signals;
    use std::process::{Command, Stdio};
    const JOBS: usize = 500;
    let folder = jobs(JOBS, |_| "{}".into())?;
    let out = folder.inner("out")?;
    let arguments = |resume: &str| {
        let line = "extract m.npz --jobs jobs.jsonl --device cpu --light dir:0,1,0 --out out/{index}.npz --json";
        line.split(' ').chain(resume.split_whitespace()).map(str::to_owned).collect::<Vec<_>>()
    };
    let count = || std::fs::read_dir(&out).map_or(0, Iterator::count);
    let run = with_signals(env!("CARGO_BIN_EXE_rimline"))
        .args(arguments(""))
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| error.to_string())?;
    while count() < 3 {
        std::thread::yield_now();
    }
    let kill = Command::new("kill").args(["-INT", &run.id().to_string()]).status();
    ensure!(kill.is_ok_and(|status| status.success()), "no signal could be sent");
    let output = run.wait_with_output().map_err(|error| error.to_string())?;
    let text = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.code() == Some(130), "it ended with {}: {text}", output.status);
    let (done, totals) = lines(&String::from_utf8_lossy(&output.stdout))?;
    let there = count();
    ensure!(there < JOBS && there == done.len() && totals["done"] == there, "{there} files, and {totals}");
    ensure!(totals["not_run"] == JOBS - there, "{totals}");
    complete(&out)?;
    let run =
        Command::new(env!("CARGO_BIN_EXE_rimline")).args(arguments("--resume")).current_dir(folder.path()).output();
    let run = run.map_err(|error| error.to_string())?;
    let (_, totals) = lines(&String::from_utf8_lossy(&run.stdout))?;
    ensure!(totals["skipped"] == there && totals["done"] == JOBS - there, "{totals}");
    ensure!(count() == JOBS, "{} files", count());
    complete(&out)
}

/// All files of the folder are the same, and results.
fn complete(folder: &Path) -> Outcome {
    let files = super::run::contents(folder)?;
    let first = files.values().next().ok_or("there is no file")?;
    for (name, bytes) in &files {
        ensure!(name.len() == "0000.npz".len() && bytes == first && !bytes.is_empty(), "{name} is not complete");
    }
    Ok(())
}

fn keys() -> Outcome {
    let folder = jobs(2, |_| "{}".into())?;
    folder.write("jobs.jsonl", "{}\n{\"file\": \"none\"}")?;
    let run = folder.run("info @m.npz --jobs @jobs.jsonl --json");
    run.expect(6, &["1 of 2 jobs failed"])?;
    let (mut lines, totals) = lines(&run.stdout)?;
    lines.push(totals);
    let document = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/formats.md"));
    let document = document.map_err(|error| error.to_string())?;
    let (_, section) = document.split_once("\n## Many files in one run\n").ok_or("no section")?;
    let section = section.split_once("\n## ").map_or(section, |(section, _)| section);
    for line in &lines {
        for key in line.as_object().ok_or("no object")?.keys() {
            ensure!(section.contains(&format!("`{key}`")), "docs/formats.md lacks {key}");
        }
    }
    Ok(())
}
