//! Inputs that are no regular files, standard input, and names that would steer a terminal.

use std::ffi::OsString;
use std::fs;
use std::path::Path;
use std::process::Command;

use super::archive::write_zip;
use super::makers::{rows, tetrahedron};
use super::run::{HIDDEN, Run, folder, rimline, rimline_with, write_file};
use super::small_gltf;
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("inputs::names_in_files_do_not_steer_the_terminal", names),
    ("inputs::names_of_files_do_not_steer_the_terminal", file_names),
    #[cfg(unix)]
    ("inputs::pipes_and_devices_are_refused", pipes),
];

fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

fn points() -> Vec<u8> {
    write_zip(&[rows("points", &[[0.0; 3]])])
}

/// Sets colours, clears, rings, by one byte, by two, by one of Latin-1; turns text around; begins a line of its own.
const HOSTILE: &str = "a\x1b[2Jb\x07c\u{9b}31md\u{202e}e\r\nrimline: all is well\x7f";

/// Nothing that steers, and no line that a name began.
fn is_tame(run: &Run, what: &str) -> Outcome {
    for text in [&run.stdout, &run.stderr] {
        let wild = text.chars().find(|&c| c != '\n' && (c.is_control() || c == '\u{202e}'));
        ensure!(wild.is_none(), "{what}: {wild:?} in {text:?}");
        let begun = text.lines().find(|line| line.starts_with("rimline: all is well"));
        ensure!(begun.is_none(), "{what}: a name began a line of {text:?}");
    }
    ensure!(!run.stderr.contains("panicked"), "{what}: it panicked: {}", run.stderr);
    Ok(())
}

fn names() -> Outcome {
    let folder = folder();
    let mut value = small_gltf::value();
    for named in ["/meshes/0", "/animations/0", "/extensions/KHR_lights_punctual/lights/0"] {
        value.pointer_mut(named).ok_or("it has a name")?["name"] = HOSTILE.into();
    }
    small_gltf::write(&folder, "body.gltf", &value)?;
    let model = folder.path().join("body.gltf");
    let out = folder.path().join("out");
    let lines = [
        ("info", 0),
        ("info --json", 0),
        ("extract --device cpu --light file:none --out", 2),
        ("extract --device cpu --light file:all --animation none --out", 2),
        ("extract --device cpu --light file:all --out", 0),
        ("shadow --light file:all,exponent=2 --out", 3),
        ("film --out", 3),
    ];
    for (number, (line, code)) in lines.into_iter().enumerate() {
        let mut line: Vec<OsString> = line.split(' ').map(OsString::from).collect();
        if line.last().is_some_and(|word| word == "--out") {
            line.push(folder.path().join(format!("out{number}")).into());
        }
        line.push(model.clone().into());
        let run = rimline_with(&line, HIDDEN);
        run.expect(code, &[])?;
        is_tame(&run, &format!("{line:?}"))?;
    }
    let json = rimline([Path::new("info"), &model, Path::new("--json")]).json()?;
    ensure!(json["meshes"][0]["name"] == HOSTILE, "JSON has another name: {}", json["meshes"][0]["name"]);
    let shown = rimline([Path::new("info"), &model]).stdout;
    ensure!(shown.contains("\\u001b[2J"), "the name is not shown: {shown}");

    // Texts that errors cite.
    let cited = serde_json::json!({ "asset": { "version": HOSTILE }, "extensionsRequired": [HOSTILE] });
    let version = serde_json::json!({ "asset": { "version": "2.0" }, "extensionsRequired": [HOSTILE] });
    let uri = serde_json::json!({ "asset": { "version": "2.0" }, "buffers": [{ "uri": HOSTILE, "byteLength": 4 }] });
    let wgsl = format!("fn displace(p: vec3<f32>, v: u32, t: f32) -> vec3<f32> {{ return {HOSTILE}; }}");
    // A buffer that nothing needs is a warning.
    for (number, (file, code)) in [(cited, 1), (version, 1), (uri, 0)].iter().enumerate() {
        write_file(&model, file.to_string())?;
        let run = rimline([Path::new("info"), &model]);
        run.expect(*code, &[if *code == 0 { "warning" } else { "error" }])?;
        is_tame(&run, &format!("file {number}"))?;
    }
    let (archive, wave) = (folder.path().join("model.npz"), folder.path().join("wave.wgsl"));
    write_file(&archive, tetrahedron())?;
    write_file(&wave, wgsl)?;
    let run = rimline(["draw".into(), archive, "--displace".into(), wave, "--out".into(), out]);
    run.expect(1, &["wave.wgsl"])?;
    is_tame(&run, "displacement")
}

#[cfg_attr(not(unix), expect(clippy::unnecessary_wraps, reason = "such names are not allowed here"))]
fn file_names() -> Outcome {
    if cfg!(not(unix)) {
        return Ok(());
    }
    let folder = folder();
    let name = HOSTILE.replace("\r\n", "\n");
    let bits = folder.inner(&name)?;
    let file = bits.join(format!("{name}.npz"));
    write_file(&file, tetrahedron())?;
    for (line, code) in [
        // The parser of options says this.
        ("query FILE FILE", 2),
        ("info FILE", 0),
        ("info FILE OTHER", 6),
        ("info FILE OTHER --json", 6),
        ("extract FILE FILE --device cpu --light dir:0,1,0 --out OTHER", 2),
        ("info OTHER", 1),
        ("verify --device cpu BITS", 1),
        ("verify --device cpu --json BITS", 1),
        ("extract FILE --device cpu --light dir:0,1,0 --out OTHER", 0),
        ("draw FILE --out FILE", 2),
    ] {
        let run = rimline(line.split(' ').map(|word| match word {
            "FILE" => file.clone().into_os_string(),
            "BITS" => bits.clone().into(),
            "OTHER" => folder.path().join(format!("{name}x")).into(),
            word => word.into(),
        }));
        run.expect(code, &[])?;
        is_tame(&run, line)?;
    }
    Ok(())
}

#[cfg(unix)]
fn pipes() -> Outcome {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    write_file(at("model.npz"), tetrahedron())?;
    write_file(at("points.npz"), points())?;
    fs::create_dir(at("bits")).map_err(text)?;
    for pipe in ["pipe", "pipe.npz", "pipe.glb", "bits/pipe.npz"] {
        ensure!(Command::new("mkfifo").arg(at(pipe)).status().is_ok_and(|status| status.success()), "no {pipe}");
    }
    std::os::unix::fs::symlink("/dev/null", at("null.npz")).map_err(text)?;
    let (model, points, out) = (at("model.npz"), at("points.npz"), at("out"));
    let query = ["--light", "dir:0,1,0", "--device", "cpu", "--out", &out];
    let mut cases: Vec<(Vec<&str>, String)> = Vec::new();
    for file in ["pipe", "pipe.npz", "pipe.glb", "null.npz"] {
        cases.push((vec!["info"], at(file)));
        cases.push(([&["query", &model][..], &query, &["--points"]].concat(), at(file)));
        cases.push(([&["query", "--points", &points][..], &query].concat(), at(file)));
        cases.push((vec!["draw", &model, "--out", &out, "--displace"], at(file)));
    }
    for (line, file) in cases {
        // Whoever opens the pipe finds it empty, and does not wait.
        let run = with_writer(&file, || rimline(line.iter().copied().chain([&*file])))?;
        run.expect(1, &[&file, "regular file"]).map_err(|error| format!("{line:?} {file}: {error}"))?;
    }
    let run = with_writer(&at("bits/pipe.npz"), || rimline(["verify", "--device", "cpu", &at("bits")]))?;
    run.expect(1, &["pipe.npz", "regular file"])
}

/// Runs what may read a pipe, while somebody waits to open it and to write nothing.
#[cfg(unix)]
fn with_writer(file: &str, run: impl FnOnce() -> Run) -> Result<Run, String> {
    use std::os::unix::fs::FileTypeExt;
    if !fs::metadata(file).is_ok_and(|there| there.file_type().is_fifo()) {
        return Ok(run());
    }
    let writer = std::thread::spawn({
        let file = file.to_owned();
        move || drop(fs::File::options().write(true).open(file))
    });
    let ended = run();
    // Lets the writer end if nobody read, also one that has not come to open the pipe yet.
    let both_ends = fs::File::options().read(true).write(true).open(file).map_err(text)?;
    writer.join().map_err(|_| "the writer panicked")?;
    drop(both_ends);
    Ok(ended)
}
