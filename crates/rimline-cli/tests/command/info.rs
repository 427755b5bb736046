//! Reports of `info` on the model files, compared with counts made by another program.

use std::path::Path;

use libtest_mimic::Trial;
use rimline_models::catalogue::GOOD;
use rimline_testkit::assets;
use rimline_testkit::harness::{on_both, on_files, on_made};
use serde_json::{Value, json};

use super::run::rimline;
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
    let mut trials = vec![
        on_both("info::animations_skins", ["skinned_without_indices.glb", "Fox.glb"], fox),
        on_both("info::why_open", ["one_sided.glb", "moebius.glb"], why_open),
        on_both("info::skipped", ["colours_and_modes.glb", "22_vertex_color.glb"], skipped),
        on_both("info::text", ["sheets.glb", "AntiqueCamera.glb"], text),
    ];
    // An edge with more than two faces has several records here.
    let manifold = GOOD.iter().filter(|good| good.counts[4] == 0);
    trials.extend(on_made("info::counts::", manifold.map(|good| good.name), |file| {
        let good = GOOD.iter().find(|good| file.ends_with(good.name)).ok_or("no row")?;
        let [faces, before, after, boundary, non_manifold, ..] = good.counts.map(|count| count as u64);
        counts(file, [faces, before, after, boundary, non_manifold])
    }));
    let names: Vec<_> = COUNTS.iter().map(|row| row.0).collect();
    trials.extend(on_files("info::counts::", assets(), &names, |file| {
        counts(file, COUNTS.iter().find(|row| file.ends_with(row.0)).ok_or("no row")?.1)
    }));
    trials
}

fn info(file: &Path, options: &[&str]) -> Result<Value, String> {
    let mut line = vec!["info".as_ref(), file.as_os_str(), "--json".as_ref()];
    line.extend(options.iter().map(AsRef::<std::ffi::OsStr>::as_ref));
    rimline(line).json()
}

fn counts(file: &Path, expected: [u64; 5]) -> Outcome {
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
    let joints = if file.ends_with("Fox.glb") { 24 } else { 5 };
    ensure!(info["skins"][0]["joints"] == joints, "{}", info["skins"]);
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
    let edge = if file.ends_with("sheets.glb") { "inconsistent edge 2-0" } else { "inconsistent edge 161-162" };
    for part in ["welded from", "closed        no: ", edge, "all instances"] {
        ensure!(run.stdout.contains(part), "the text lacks `{part}`: {}", run.stdout);
    }
    Ok(())
}
