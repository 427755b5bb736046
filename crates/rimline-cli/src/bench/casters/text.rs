//! Rows for the terminal.

use std::fmt::Write as _;

use super::super::measure::Summary;
use super::super::text::{figures, grouped};
use super::field::LIGHTS;
use super::results::{CastersRow, OneMeshRow, PARTS, Part};

fn range(summary: &Summary) -> String {
    format!("{:>9}  {:>9} … {:<9}", figures(summary.median), figures(summary.quartiles.0), figures(summary.quartiles.1))
}

pub(super) fn row(row: &CastersRow) -> String {
    let mut text =
        format!("scene of {}, {} faces each, {LIGHTS} lights\n", row.mesh.counted(row.casters), grouped(row.faces));
    let _ = writeln!(text, "  {:<36} {:>9}  {:^21} {:>4}", "recording a frame", "CPU ms", "quartiles", "runs");
    for (change, ms) in &row.recording {
        if let Some(ms) = Summary::of(ms.iter().copied()) {
            let _ = writeln!(text, "  {:<36} {} {:>4}", change.name(), range(&ms), ms.count);
        }
    }
    let _ = writeln!(text, "  {:<36} {:>9} {:>9} {:>7}", "running a frame", "GPU ms", "merged", "ratio");
    for part in PARTS {
        let (Some(scene), Some(merged), Some(ratio)) =
            (row.compared.scene(part), row.compared.other(part), row.compared.ratio(part))
        else {
            continue;
        };
        let [scene, merged] = [scene, merged].map(|ms| figures(ms.median));
        let _ = writeln!(text, "  {:<36} {scene:>9} {merged:>9} {:>7.2}", part.name(), ratio.median);
    }
    let each = |bytes: u64| grouped(row.per_caster(bytes).round() as usize);
    let _ = write!(text, "  bytes a caster: {} in the scene's buffers", each(row.scene_bytes));
    if let Some(bytes) = row.scene_device_bytes {
        let _ = write!(text, ", {} on the device", each(bytes));
    }
    if let Some(bytes) = row.extractors_device_bytes {
        let _ = write!(text, ", {} with an extractor a caster", each(bytes));
    }
    let edges: u64 = row.edges[0].iter().sum();
    let _ = writeln!(
        text,
        "\n  silhouette edges: {}, lights that differ from the merged mesh: {}",
        grouped(edges as usize),
        row.wrong_lights()
    );
    text
}

pub(super) fn one_mesh_row(row: &OneMeshRow) -> String {
    let [scene, extractor] = [row.compared.scene(Part::Extraction), row.compared.other(Part::Extraction)]
        .map(|time| time.map_or_else(String::new, |time| figures(time.median)));
    let ratio = row.compared.ratio(Part::Extraction).map_or(f64::NAN, |ratio| ratio.median);
    format!(
        "scene of one mesh of {} faces, {LIGHTS} lights: extraction takes {scene} ms, by an extractor {extractor} ms, ratio \
         {ratio:.2}; lights that differ: {}\n",
        grouped(row.faces),
        row.wrong_lights()
    )
}
