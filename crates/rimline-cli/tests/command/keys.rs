//! The keys of each JSON output are those that the help and the documents list.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value;

use super::archive::{array, read_zip, write_zip};
use super::makers::tetrahedron;
use super::run::{folder, rimline};
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

/// Command lines, and the fewest keys that each has.
const LINES: [(&str, usize); 20] = [
    ("lines @model.npz --hidden thin --out - --format json", 9),
    ("extract @model.npz --light dir:0,1,0 --out @out.npz --device gpu", 9),
    ("extract @model.npz --light dir:0,1,0 --out @out.npz --device gpu --method per-edge", 9),
    ("extract @model.npz --light dir:0,1,0 --out @out.npz --device cpu", 9),
    ("extract @box.obj --polygons --light dir:0,1,0 --out @out.npz --device gpu", 9),
    ("query @model.npz --points @points.npz --light dir:0,1,0 --out @out.npz --device gpu", 9),
    ("query @model.npz --points @points.npz --light dir:0,1,0 --out @out.npz --device cpu", 9),
    ("shadow @model.npz --size 32x24 --mask @mask --out @out.png --area disc --samples 2", 9),
    ("shadow @model.npz --size 32x24 --mask @mask --out @out.png --hide-covered", 9),
    ("shadow @model.npz --size 32x24 --mask @mask --out @out.png --method zp+paper", 9),
    ("shadow @box.obj --polygons --size 32x24 --out @out.png --light point:0.4,5,0.3", 9),
    ("shadow @model.npz --size 32x24 --mask @mask --out @out.png --from-depth 64", 9),
    ("shadow @model.npz --size 32x24 --mask @mask --out @out.png --from-depth 64 --detector contours=0.001", 9),
    ("draw @model.npz --size 32x24 --out @out.png", 5),
    ("film @model.npz --size 32x24 --frames 1 --out @film", 5),
    ("info @model.npz", 9),
    ("info @body.gltf", 9),
    ("verify @bits --device cpu", 9),
    ("verify --built-in --device cpu", 9),
    ("devices", 9),
];

fn described() -> Outcome {
    let folder = folder();
    let document = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/formats.md"));
    let document = document.map_err(|error| error.to_string())?;
    let section = |title: &str| -> Result<&str, String> {
        let (_, after) = document.split_once(&format!("\n{title}\n")).ok_or(format!("no section {title}"))?;
        let end = [after.find("\n### "), after.find("\n## ")].into_iter().flatten().min();
        Ok(&after[..end.unwrap_or(after.len())])
    };
    folder.write("model.npz", tetrahedron())?;
    folder.write("points.npz", write_zip(&[array("points", "<f4", "False", "(1, 3)", &[0; 12])]))?;
    // A box whose top is twisted.
    let corners = "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 1 0\nv 1 2 0\nv 1 1 1\nv 0 2 1\n";
    let faces = "f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 6 7 3 2\nf 7 8 4 3\nf 8 5 1 4\n";
    folder.write("box.obj", format!("{corners}{faces}"))?;
    small_gltf::write(&folder, "body.gltf", &small_gltf::value())?;
    // Archives that are right, and one that differs, so that differences are listed, too.
    folder.inner("bits")?;
    for options in ["--device cpu --out @bits/same.npz", "--device gpu --method per-edge --out @bits/other.npz"] {
        folder.run(&format!("extract @model.npz --light dir:0,1,0 {options}")).expect(0, &[])?;
    }
    let mut wrong = read_zip(&folder.read("bits/same.npz")?)?;
    let facing = wrong.iter_mut().find(|entry| entry.name.starts_with("silhouette")).ok_or("no silhouette")?;
    *facing.bytes.last_mut().ok_or("no bits")? ^= 1;
    folder.write("bits/wrong.npz", write_zip(&wrong))?;
    for (line, least) in LINES {
        let command = line.split(' ').next().unwrap_or_default();
        // A drawing is JSON itself.
        let option = if command == "lines" { "--format json" } else { "--json" };
        let run = folder.run(&if command == "lines" { line.to_owned() } else { format!("{line} --json") });
        ensure!([0, 5].contains(&run.code), "{line}: {}", run.stderr);
        let json: Value = serde_json::from_str(&run.stdout).map_err(|error| format!("{line}: {error}"))?;
        let (mut found, mut stages) = (BTreeSet::new(), BTreeSet::new());
        keys(&json, &mut found, &mut stages);
        ensure!(found.len() >= least, "{line} has only {found:?}");
        let help = rimline([command, "--help"]).stdout;
        let (_, listed) = help.rsplit_once(&format!("Keys of {option}: ")).ok_or(format!("{command} lists no keys"))?;
        let listed: BTreeSet<&str> = listed.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
        let (described, times) = (section(&format!("### `{command} {option}`"))?, section("### Times")?);
        for key in &found {
            ensure!(listed.contains(key.as_str()), "the help of {command} lacks {key}");
            let word = format!("`{key}`");
            let is_there = described.contains(&word) || key.ends_with("milliseconds") && times.contains(&word);
            ensure!(is_there, "docs/formats.md lacks {key} of {command}");
        }
        let lost = stages.iter().find(|stage| !times.contains(&format!("`{stage}`")));
        ensure!(lost.is_none(), "docs/formats.md lacks the stage {lost:?}");
    }
    let jobs = folder.run("info @model.npz none --json").stdout;
    let of_jobs = section("## Many files in one run")?;
    for line in jobs.lines() {
        let line: Value = serde_json::from_str(line).map_err(|error| error.to_string())?;
        let line = if line["totals"].is_object() { &line["totals"] } else { &line };
        let lost = line.as_object().into_iter().flatten().find(|(key, _)| !of_jobs.contains(&format!("`{key}`")));
        ensure!(lost.is_none(), "docs/formats.md lacks {lost:?}");
    }
    ensure!(jobs.lines().count() == 3, "{jobs}");
    Ok(())
}
