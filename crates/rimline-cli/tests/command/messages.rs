//! Errors in words of the command: where, with which name, and before long work.

use std::process::{Command, Stdio};

use super::archive::{array, write_zip};
use super::run::{is_empty, rimline, rimline_with, write_file};
use super::shadow::with_cube;
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("messages::lights_of_negative_weight_are_refused_whatever_casts", negative_weight),
    ("messages::extensions_of_wgsl_have_a_line", extensions),
    ("messages::lengths_of_arrays_are_told_in_sentences", array_lengths),
    ("messages::a_variable_that_hides_all_devices_is_named", hidden),
    ("messages::finite_vertices_without_a_face_are_not_denied", no_face),
    ("messages::negative_numbers_are_values", negative_values),
    ("messages::scenes_without_triangles_are_described_and_not_drawn", empty_scene),
    ("messages::extensions_that_only_a_node_names_are_warned_of", unlisted_extension),
    ("messages::faces_that_all_collapse_close_nothing", collapsed),
    ("messages::a_report_replaces_nothing_but_a_report", report),
    ("messages::a_folder_has_one_film_at_a_time", films),
    #[cfg(target_os = "linux")]
    ("messages::help_that_cannot_be_written_ends_with_4", help),
];

fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

fn negative_weight() -> Outcome {
    let folder = with_cube()?;
    for options in ["", "--from-depth 16", "--area disc:1", "--method z-fail", "--method zp+paper", "--hide-covered"] {
        let line = format!("shadow @cube.npz --size 32x32 --light point:1,9,2 --light hom:1,9,2,-1 {options}");
        folder.run(&format!("{line} --out @no.png")).expect(2, &["light 1", "w = -1", "negate"])?;
    }
    let line = "film @cube.npz --size 32x32 --frames 1 --light hom:1,9,2,-1 --out @no";
    folder.run(line).expect(2, &["light 0", "w = -1"])?;
    std::fs::remove_file(folder.path().join("cube.npz")).map_err(text)?;
    is_empty(folder.path())
}

/// Extracts with this displacement.
fn displaced(source: &str) -> Result<super::run::Run, String> {
    let folder = with_cube()?;
    folder.write("d.wgsl", source)?;
    Ok(folder.run("extract @cube.npz --light dir:0,1,0 --displace @d.wgsl --out @out.npz"))
}

const BODY: &str = "fn displace(position: vec3<f32>, vertex: u32, time: f32) -> vec3<f32> { return position; }";

fn extensions() -> Outcome {
    for names in ["f16", "dual_source_blending", "clip_distances", "subgroups", "f16, clip_distances", "nothing"] {
        displaced(&format!("// A comment.\n\nenable {names};\n{BODY}"))?
            .expect(1, &["d.wgsl", "line 3", &format!("`enable {names}`")])
            .map_err(|error| format!("{names}: {error}"))?;
    }
    // Negative control: what needs no feature of a device, and the word in a comment.
    displaced(&format!("/* enable f16; */ diagnostic(off, derivative_uniformity);\n{BODY}"))?.expect(0, &[])
}

fn array_lengths() -> Outcome {
    let with = |length: &str| displaced(&format!("\nvar<private> a: array<f32, {length}>;\n{BODY}"));
    let run = with("70000")?;
    run.expect(1, &["line 2", "70000 possible elements of an array, more than the 65536"])?;
    ensure!(!run.stderr.contains(",,"), "{}", run.stderr);
    let run = with("1 << 20")?;
    run.expect(1, &["line 2", "nothing bounds the length"])?;
    ensure!(!run.stderr.contains("18446744073709551615"), "{}", run.stderr);
    Ok(())
}

fn hidden() -> Outcome {
    let folder = with_cube()?;
    let at = |name: &str| folder.path().join(name).into_os_string();
    for value in ["noop", "vulcan"] {
        let variable = [("WGPU_BACKEND", value)];
        let parts = ["WGPU_BACKEND", value, "unset it"];
        rimline_with(["devices"], &variable).expect(3, &parts)?;
        let draw = ["draw".into(), at("cube.npz"), "--out".into(), at("out.png")];
        rimline_with(draw, &variable).expect(3, &parts)?;
        let extract = ["extract".into(), at("cube.npz"), "--light".into(), "dir:0,1,0".into()];
        let extract = extract.into_iter().chain(["--out".into(), at("out.npz")]);
        rimline_with(extract, &variable).expect(0, &["on the CPU", "WGPU_BACKEND", value])?;
    }
    Ok(())
}

/// Two vertices of the only face are finite.
fn no_face() -> Outcome {
    let folder = with_cube()?;
    let positions = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, f32::NAN, 1.0, 0.0].iter().flat_map(|c: &f32| c.to_le_bytes());
    let positions = array("positions", "<f4", "False", "(3, 3)", &positions.collect::<Vec<u8>>());
    let faces = array("faces", "|u1", "False", "(1, 3)", &[0, 1, 2]);
    folder.write("nan.npz", write_zip(&[positions, faces]))?;
    for line in ["draw @nan.npz --out @no.png", "shadow @nan.npz --out @no.png", "film @nan.npz --frames 1 --out @no"] {
        let run = folder.run(&format!("{line} --size 32x32"));
        run.expect(1, &["nan.npz", "no face has finite positions"])?;
        ensure!(!run.stderr.contains("no vertex"), "{}", run.stderr);
    }
    Ok(())
}

/// Writes a glTF of this text, and runs commands on it.
fn of_gltf(text: &str, lines: &[(&str, i32, &[&str])]) -> Outcome {
    let folder = super::run::folder();
    folder.write("a.gltf", text)?;
    for (line, code, words) in lines {
        folder.run(line).expect(*code, words).map_err(|error| format!("{line}: {error}"))?;
    }
    Ok(())
}

fn empty_scene() -> Outcome {
    let drawn: &[&str] = &["a.gltf", "its scene has no triangles", "info"];
    let text = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"name": "nothing"}]}"#;
    of_gltf(
        text,
        &[
            ("info @a.gltf", 0, &[]),
            ("info @a.gltf --json", 0, &[]),
            ("draw @a.gltf --size 16x16 --out @a.png", 1, drawn),
            ("shadow @a.gltf --size 16x16 --out @a.png", 1, drawn),
            ("extract @a.gltf --light dir:0,1,0 --device cpu --out @a.npz", 1, drawn),
        ],
    )?;
    of_gltf("[]", &[("info @a.gltf", 1, &["a.gltf: the file: expected an object"])])
}

fn unlisted_extension() -> Outcome {
    let text = |extension: &str| {
        format!(
            r#"{{"asset": {{"version": "2.0"}}, "scenes": [{{"nodes": [0]}}], "nodes": [{{"extensions": {{"{extension}": {{}}}}}}]}}"#
        )
    };
    of_gltf(&text("ACME_bend"), &[("info @a.gltf", 0, &["ACME_bend"])])?;
    // Negative control.
    let folder = super::run::folder();
    folder.write("a.gltf", text("KHR_node_hoverability"))?;
    let run = folder.run("info @a.gltf");
    ensure!(!run.stderr.contains("warning"), "{}", run.stderr);
    Ok(())
}

fn collapsed() -> Outcome {
    let folder = super::run::folder();
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")?;
    let run = folder.run("info @a.obj --weld-distance 2");
    run.expect(0, &[])?;
    ensure!(run.stdout.contains("nothing to close: no face has an area"), "{}", run.stdout);
    Ok(())
}

fn negative_values() -> Outcome {
    for (line, parts) in [
        ("shadow a.npz --from-depth --dangling -1,3", ["'-1,3'", "--dangling", "0 to 1"]),
        ("shadow a.npz --from-depth -5", ["'-5'", "--from-depth", "3..=4096"]),
        ("shadow a.npz --area -1", ["'-1'", "--area", "rect"]),
        ("film a.npz --frames -1", ["'-1'", "--frames", "1..=100000"]),
        ("verify --make d --faces 99999999999", ["'99999999999'", "--faces", "4194304"]),
        ("verify --make d --faces 0", ["'0'", "--faces", "4194304"]),
        ("bench --rounds -1", ["'-1'", "--rounds", "1000"]),
        ("info a.npz --memory-limit -1GiB", ["'-1GiB'", "--memory-limit", "512MiB"]),
    ] {
        rimline(line.split(' ')).expect(2, &parts).map_err(|error| format!("{line}: {error}"))?;
    }
    Ok(())
}

fn report() -> Outcome {
    let folder = with_cube()?;
    let report = folder.path().join("report");
    std::fs::create_dir(&report).map_err(text)?;
    let line = "bench --device cpu --meshes none --scenes three-sheets --scene-faces 60 --lights 1 --rounds 1 --report @report";
    for name in ["index.html", "data.json", "stages.png"] {
        let own = report.join(name);
        write_file(&own, "<title>My page</title>")?;
        folder.run(line).expect(2, &["report", name, "would be replaced"])?;
        let left = std::fs::read_to_string(&own).map_err(text)?;
        ensure!(left == "<title>My page</title>", "{name} is now {left}");
        std::fs::remove_file(own).map_err(text)?;
        is_empty(&report)?;
    }
    write_file(report.join("notes.txt"), "mine")?;
    // A report is replaced by another one.
    for _ in 0..2 {
        folder.run(line).expect(0, &[])?;
        ensure!(report.join("index.html").exists() && report.join("notes.txt").exists(), "files are missing");
    }
    Ok(())
}

/// The second film begins while the first one is under way.
fn films() -> Outcome {
    let folder = with_cube()?;
    let mut first = Command::new(env!("CARGO_BIN_EXE_rimline"))
        .arg("film")
        .arg(folder.path().join("cube.npz"))
        .args(["--frames", "400", "--size", "64x48", "--out"])
        .arg(folder.path().join("film"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .map_err(text)?;
    let claim = folder.path().join("film/.rimline-film.part");
    for _ in 0..1000 {
        if claim.exists() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let second = folder.run("film @cube.npz --frames 2 --size 64x48 --out @film");
    let _ = first.kill();
    first.wait().map_err(text)?;
    second.expect(2, &["another film", "choose another folder"])?;
    std::fs::remove_dir_all(folder.path().join("film")).map_err(text)?;
    // A place of a picture that cannot be replaced is known before the first is drawn.
    std::fs::create_dir_all(folder.path().join("film/0001.png")).map_err(text)?;
    folder.run("film @cube.npz --frames 2 --size 64x48 --out @film").expect(4, &["0001.png", "it is a folder"])?;
    ensure!(!folder.path().join("film/0000.png").exists(), "a picture was drawn");
    Ok(())
}

#[cfg(target_os = "linux")]
fn help() -> Outcome {
    for line in ["--help", "--version", "help", "shadow --help"] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").map_err(text)?;
        let output = Command::new(env!("CARGO_BIN_EXE_rimline")).args(line.split(' ')).stdout(full).output();
        let output = output.map_err(text)?;
        let message = String::from_utf8_lossy(&output.stderr);
        ensure!(output.status.code() == Some(4), "{line}: {}: {message}", output.status);
        ensure!(message.contains("standard output: cannot be written"), "{line}: {message}");
    }
    Ok(())
}
