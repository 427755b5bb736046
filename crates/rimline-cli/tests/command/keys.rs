//! The keys of each JSON output are those that the help and the documents list.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value;

use super::archive::{array, write_zip};
use super::makers::tetrahedron;
use super::run::{folder, read_file, rimline, write_file};
use super::small_gltf;
use super::{Outcome, Test, ensure};

pub(crate) const TESTS: &[Test] = &[("keys::every_key_is_described", described)];

/// All keys in a value, those of stages left out and returned apart.
fn keys(value: &Value, found: &mut BTreeSet<String>, stages: &mut BTreeSet<String>) {
    match value {
        Value::Array(list) => list.iter().for_each(|item| keys(item, found, stages)),
        Value::Object(object) => {
            for (key, item) in object {
                found.insert(key.clone());
                match (key.as_str(), item) {
                    ("milliseconds", Value::Object(times)) => stages.extend(times.keys().cloned()),
                    // Named by the standard of WebGPU.
                    ("limits", _) => {}
                    _ => keys(item, found, stages),
                }
            }
        }
        _ => {}
    }
}

fn described() -> Outcome {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let text = |error: std::io::Error| error.to_string();
    let document = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/formats.md"));
    let document = document.map_err(text)?;
    let section = |title: &str| -> Result<&str, String> {
        let (_, after) = document.split_once(&format!("\n### {title}\n")).ok_or(format!("no section {title}"))?;
        let end = [after.find("\n### "), after.find("\n## ")].into_iter().flatten().min();
        Ok(&after[..end.unwrap_or(after.len())])
    };
    write_file(at("model.npz"), tetrahedron())?;
    write_file(at("points.npz"), write_zip(&[array("points", "<f4", "False", "(1, 3)", &[0; 12])]))?;
    // A box whose top is twisted.
    let corners = "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 1 0\nv 1 2 0\nv 1 1 1\nv 0 2 1\n";
    let faces = "f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 6 7 3 2\nf 7 8 4 3\nf 8 5 1 4\n";
    write_file(at("box.obj"), format!("{corners}{faces}"))?;
    small_gltf::write(&folder, "body.gltf", &small_gltf::value())?;
    let gltf = at("body.gltf");
    let model = at("model.npz");
    // One that differs, so that differences are listed, too.
    std::fs::create_dir(at("bits")).map_err(text)?;
    let of_model = ["extract", &model, "--light", "dir:0,1,0", "--device"];
    rimline(of_model.iter().chain(&["cpu", "--out", &at("bits/same.npz")])).expect(0, &[])?;
    let other = ["gpu", "--method", "per-edge", "--out", &at("bits/other.npz")];
    rimline(of_model.iter().chain(&other)).expect(0, &[])?;
    let mut wrong = super::archive::read_zip(&read_file(at("bits/same.npz"))?)?;
    let facing = wrong.iter_mut().find(|entry| entry.name.starts_with("silhouette")).ok_or("no silhouette")?;
    *facing.bytes.last_mut().ok_or("no bits")? ^= 1;
    write_file(at("bits/wrong.npz"), write_zip(&wrong))?;

    let (light, out, png) = (["--light", "dir:0,1,0"], at("out.npz"), at("out.png"));
    let size = ["--size", "32x24"];
    let extract = ["extract", &model, light[0], light[1], "--out", &out];
    let query = ["query", &model, "--points", &at("points.npz"), light[0], light[1], "--out", &out];
    let shadow = ["shadow", &model, size[0], size[1], "--mask", &at("mask"), "--out", &png];
    let polygons = at("box.obj");
    let of_polygons = ["shadow", &polygons, "--polygons", size[0], size[1], "--out", &png];
    let drawing = ["lines", &model, "--hidden", "thin", "--out", "-"];
    let lines: [(&[&str], &[&str]); 20] = [
        (&drawing, &["--format", "json"]),
        (&extract, &["--device", "gpu"]),
        (&extract, &["--device", "gpu", "--method", "per-edge"]),
        (&extract, &["--device", "cpu"]),
        (&["extract", &polygons, "--polygons", light[0], light[1], "--out", &out], &["--device", "gpu"]),
        (&query, &["--device", "gpu"]),
        (&query, &["--device", "cpu"]),
        (&shadow, &["--area", "disc", "--samples", "2"]),
        (&shadow, &["--hide-covered"]),
        (&shadow, &["--method", "zp+paper"]),
        (&of_polygons, &["--light", "point:0.4,5,0.3"]),
        (&shadow, &["--from-depth", "64"]),
        (&shadow, &["--from-depth", "64", "--detector", "contours=0.001"]),
        (&["draw", &model, size[0], size[1], "--out", &png], &[]),
        (&["film", &model, size[0], size[1], "--frames", "1", "--out", &at("film")], &[]),
        (&["info", &model], &[]),
        (&["info", &gltf], &[]),
        (&["verify", &at("bits")], &["--device", "cpu"]),
        (&["verify", "--built-in"], &["--device", "cpu"]),
        (&["devices"], &[]),
    ];
    for (line, options) in lines {
        // A drawing is JSON itself.
        let option = if line[0] == "lines" { "--format json" } else { "--json" };
        let run = rimline(line.iter().chain(options).chain(if line[0] == "lines" { &[][..] } else { &["--json"] }));
        ensure!([0, 5].contains(&run.code), "{line:?}: {}", run.stderr);
        let json: Value = serde_json::from_str(&run.stdout).map_err(|error| format!("{line:?}: {error}"))?;
        let (mut found, mut stages) = (BTreeSet::new(), BTreeSet::new());
        keys(&json, &mut found, &mut stages);
        let least = if ["draw", "film"].contains(&line[0]) { 5 } else { 9 };
        ensure!(found.len() >= least, "{line:?} has only {found:?}");
        let help = rimline([line[0], "--help"]).stdout;
        let (_, listed) =
            help.rsplit_once(&format!("Keys of {option}: ")).ok_or(format!("{} lists no keys", line[0]))?;
        let listed: BTreeSet<&str> = listed.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
        let (described, times) = (section(&format!("`{} {option}`", line[0]))?, section("Times")?);
        for key in &found {
            ensure!(listed.contains(key.as_str()), "the help of {} lacks {key}", line[0]);
            let word = format!("`{key}`");
            let is_there = described.contains(&word) || key.ends_with("milliseconds") && times.contains(&word);
            ensure!(is_there, "docs/formats.md lacks {key} of {}", line[0]);
        }
        for stage in stages {
            ensure!(times.contains(&format!("`{stage}`")), "docs/formats.md lacks the stage {stage}");
        }
    }
    Ok(())
}
