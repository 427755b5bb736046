//! Models that a GPU cannot take, and pictures.

use std::fs;
use std::path::Path;

use super::archive::{array, write_zip};
use super::run::{Run, folder, is_long, rimline, rimline_with, write_file};
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[
    ("fallback::auto_takes_the_cpu_for_a_model_that_does_not_fit", model),
    ("fallback::a_picture_that_does_not_fit_has_advice", picture),
    ("fallback::a_model_that_pictures_cannot_take_has_advice", large),
];

/// Makes a small device of any.
const SMALL: &[(&str, &str)] = &[("RIMLINE_BUFFER_LIMIT", "4096")];

/// A strip of triangles with so many vertices, of which only the first few have faces.
fn strip(vertices: usize) -> Vec<u8> {
    let positions: Vec<u8> =
        (0..vertices).flat_map(|v| [(v / 2) as f32, (v % 2) as f32, 0.0]).flat_map(f32::to_le_bytes).collect();
    let faces: Vec<u8> = (0..64_u32).flat_map(|f| [f, f + 1, f + 2]).flat_map(u32::to_le_bytes).collect();
    write_zip(&[
        array("positions", "<f4", "False", &format!("({vertices}, 3)"), &positions),
        array("faces", "<u4", "False", "(64, 3)", &faces),
    ])
}

fn model() -> Outcome {
    falls_back(4096, SMALL)?;
    // More than four bindings of 128 MiB hold; adapters with larger ones take it.
    if is_long() { falls_back(60_000_000, &[]) } else { Ok(()) }
}

fn falls_back(vertices: usize, variables: &[(&str, &str)]) -> Outcome {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    write_file(at("model.npz"), strip(vertices))?;
    let points = write_zip(&[array("points", "<f4", "False", "(1, 3)", &[0; 12])]);
    write_file(at("points.npz"), points)?;
    write_file(at("still.wgsl"), "fn displace(p: vec3<f32>, v: u32, t: f32) -> vec3<f32> { return p; }")?;
    for command in [&["extract"][..], &["query", "--points", &at("points.npz")]] {
        let run = |device: &str, more: &[&str]| -> Run {
            let model = at("model.npz");
            let out = at(device);
            let line = ["--no-weld", "--light", "point:1,2,3", "--device", device, "--out", &out];
            rimline_with(command.iter().copied().chain([&*model]).chain(line).chain(more.iter().copied()), variables)
        };
        run("cpu", &[]).expect(0, &[])?;
        let auto = run("auto", &["--json"]);
        let json = auto.json()?;
        if !variables.is_empty() {
            auto.expect(0, &["working on the CPU", "does not fit"])?;
            ensure!(json["adapter"] == "cpu", "{json}");
            run("gpu", &[]).expect(3, &["does not fit", "--device cpu"])?;
            // Only a GPU can displace.
            run("auto", &["--displace", &at("still.wgsl")]).expect(3, &["does not fit"])?;
        }
        let [cpu, auto] = ["cpu", "auto"].map(|name| fs::read(Path::new(&at(name))));
        ensure!(cpu.map_err(|e| e.to_string())? == auto.map_err(|e| e.to_string())?, "other bytes than the CPU's");
        if variables.is_empty() {
            continue;
        }
        ensure!(!Path::new(&at("gpu")).exists(), "there is a result that no device made");
    }
    Ok(())
}

fn picture() -> Outcome {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    write_file(at("model.npz"), strip(66))?;
    for command in ["draw", "shadow"] {
        let line = [command, &at("model.npz"), "--size", "16384x16384", "--out", &at("out.png")];
        let run = rimline(line);
        if run.code == 0 {
            // A large device.
            continue;
        }
        run.expect(2, &["--size 16384x16384", "try --size "])?;
        let (_, advice) = run.stderr.rsplit_once("try --size ").ok_or("no advice")?;
        let sides: Vec<u32> = advice.trim().split('x').filter_map(|side| side.parse().ok()).collect();
        ensure!(matches!(sides[..], [w, h] if w == h && (1..=8192).contains(&w)), "{command}: {}", run.stderr);
        ensure!(!Path::new(&at("out.png")).exists(), "there is a picture");
    }
    Ok(())
}

/// A model that is too large to be drawn is reported in words of the command, before anything is drawn.
fn large() -> Outcome {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    // More faces than a binding holds, and more vertices.
    let faces: Vec<u8> =
        (0..60_000_u32).flat_map(|f| [f % 90, f % 90 + 1, f % 90 + 2]).flat_map(u32::to_le_bytes).collect();
    let corners: Vec<u8> =
        (0..92_u8).flat_map(|v| [f32::from(v / 2), f32::from(v % 2), 0.0]).flat_map(f32::to_le_bytes).collect();
    let file = write_zip(&[
        array("positions", "<f4", "False", "(92, 3)", &corners),
        array("faces", "<u4", "False", "(60000, 3)", &faces),
    ]);
    write_file(at("faces.npz"), file)?;
    write_file(at("vertices.npz"), strip(60_000))?;
    for (model, what) in [("faces.npz", "faces"), ("vertices.npz", "positions")] {
        for command in ["draw", "shadow"] {
            let line = [command, &at(model), "--no-weld", "--size", "32x32", "--out", &at("out.png")];
            let run = rimline_with(line, &[("RIMLINE_BUFFER_LIMIT", "524288")]);
            run.expect(3, &["does not fit the device", what, "KiB", "a smaller model or another device"])?;
            for foreign in ["request a larger limit", "wgpu", "alidation", "panicked"] {
                ensure!(!run.stderr.contains(foreign), "{command} {model}: {}", run.stderr);
            }
            ensure!(!Path::new(&at("out.png")).exists(), "there is a picture");
        }
    }
    Ok(())
}
