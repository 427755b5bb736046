//! Reports of `info` on model files, compared with counts made by another program.

use std::path::Path;

use libtest_mimic::Trial;
use rimline_models::catalogue::GOOD;
use rimline_testkit::assets;
use rimline_testkit::harness::{on_files, on_made};
use serde_json::json;

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
    // An edge with more than two faces has several records here.
    let manifold = GOOD.iter().filter(|good| good.counts[4] == 0);
    let mut trials = on_made("info::counts::", manifold.map(|good| good.name), |file| {
        let good = GOOD.iter().find(|good| file.ends_with(good.name)).ok_or("no row")?;
        let [faces, before, after, boundary, non_manifold, ..] = good.counts.map(|count| count as u64);
        counts(file, [faces, before, after, boundary, non_manifold])
    });
    let names: Vec<_> = COUNTS.iter().map(|row| row.0).collect();
    trials.extend(on_files("info::counts::", assets(), &names, |file| {
        counts(file, COUNTS.iter().find(|row| file.ends_with(row.0)).ok_or("no row")?.1)
    }));
    trials
}

fn counts(file: &Path, expected: [u64; 5]) -> Outcome {
    let words = ["--json", "--weld", "position"].map(AsRef::as_ref);
    let total = &rimline(["info".as_ref(), file.as_os_str()].into_iter().chain(words)).json()?["total"];
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
