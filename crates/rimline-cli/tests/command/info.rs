//! Reports of `info` on the model files, compared with counts made by another program.

use std::path::Path;

use libtest_mimic::Trial;
use serde_json::{Value, json};

use super::run::{on_asset, rimline};
use super::{Outcome, ensure};

/// File, faces, vertices before and after welding by position, boundary edges, edges with more than two faces.
const COUNTS: &[(&str, [u64; 5])] = &[
    ("AnimatedMorphCube.glb", [12, 24, 8, 0, 0]),
    ("Box.glb", [12, 24, 8, 0, 0]),
    ("CesiumMan.glb", [4672, 3273, 2338, 0, 0]),
    ("Fox.glb", [576, 1728, 290, 0, 0]),
    ("SheenCloth.glb", [115_200, 58_081, 58_081, 960, 0]),
    ("moebius.glb", [448, 280, 280, 112, 0]),
    ("scallop.glb", [120_000, 60_002, 60_002, 0, 0]),
    ("spot.glb", [5856, 3225, 2930, 0, 0]),
];

pub(crate) fn trials() -> Vec<Trial> {
    let counts = COUNTS.iter().map(|&(file, _)| on_asset("info::counts", file, counts));
    let others = [
        on_asset("info::animations_skins", "Fox.glb", fox),
        on_asset("info::why_open", "moebius.glb", why_open),
        on_asset("info::skipped", "22_vertex_color.glb", skipped),
        on_asset("info::text", "AntiqueCamera.glb", text),
    ];
    counts.chain(others).collect()
}

fn info(file: &Path, options: &[&str]) -> Result<Value, String> {
    let mut line = vec!["info".as_ref(), file.as_os_str(), "--json".as_ref()];
    line.extend(options.iter().map(AsRef::<std::ffi::OsStr>::as_ref));
    rimline(line).json()
}

fn counts(file: &Path) -> Outcome {
    let expected = COUNTS.iter().find(|(name, _)| file.ends_with(name)).ok_or("no counts")?.1;
    let total = &info(file, &["--weld", "position"])?["total"];
    let found = json!([
        total["faces"],
        total["vertices"]["before"],
        total["vertices"]["after"],
        total["edges"]["boundary"],
        total["non_manifold_edges"],
    ]);
    ensure!(found == json!(expected), "{found} instead of {expected:?}");
    let is_closed = expected[3] == 0;
    ensure!(total["closed"] == is_closed && total["why_open"].is_null() == is_closed, "{total}");
    Ok(())
}

fn fox(file: &Path) -> Outcome {
    let info = info(file, &[])?;
    let names: Vec<&Value> = info["animations"].as_array().ok_or("no animations")?.iter().map(|a| &a["name"]).collect();
    ensure!(names == ["Survey", "Walk", "Run"], "{names:?}");
    ensure!(info["skins"][0]["joints"] == 24, "{}", info["skins"]);
    ensure!(info["placed"]["bounds"]["min"].as_array().is_some_and(|min| min.len() == 3), "{info}");
    Ok(())
}

fn why_open(file: &Path) -> Outcome {
    let info = info(file, &[])?;
    let mesh = &info["meshes"][0];
    ensure!(mesh["edges"]["inconsistent"] == 4, "{mesh}");
    let offending = mesh["offending_edges"].as_array().ok_or("none listed")?;
    ensure!(!offending.is_empty(), "none listed");
    for edge in offending {
        ensure!(edge["positions"][1].as_array().is_some_and(|p| p.len() == 3), "{edge}");
    }
    Ok(())
}

fn skipped(file: &Path) -> Outcome {
    let skipped = &info(file, &[])?["skipped_primitives"];
    ensure!(*skipped == json!({ "points": 4, "lines": 3, "without_position": 0 }), "{skipped}");
    Ok(())
}

fn text(file: &Path) -> Outcome {
    let run = rimline(["info".as_ref(), file.as_os_str()]);
    run.expect(0, &[])?;
    for part in ["welded from", "closed        no: ", "inconsistent edge 161-162", "all instances"] {
        ensure!(run.stdout.contains(part), "the text lacks `{part}`: {}", run.stdout);
    }
    Ok(())
}
