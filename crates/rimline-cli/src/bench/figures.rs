//! The report's sections: which plots, of what. Here the one on extraction.

mod casters;
mod classes;
mod cost;
mod depth_maps;
mod error;
mod lights;
mod shadows;
mod size;
mod skip;
mod stages;

use super::bench_mesh::ORDINARY;
use super::method::{GPU_EXACT, PER_EDGE};
use super::results::{Results, Row};
use crate::page::Section;

pub(super) use casters::casters;
pub(super) use depth_maps::depth_maps;
pub(super) use shadows::shadows;
pub(super) use skip::skipping;

/// Every plot that a report may have.
pub(super) const PLOTS: [&str; 14] = [
    "time_against_error",
    "time_against_size",
    "speed_against_2003",
    "time_against_lights",
    "stages",
    "cost_of_exactness",
    "shadow_time_against_error",
    "shadow_stencil",
    "shadow_frame",
    "shadow_paths",
    casters::RECORDING,
    skip::WORK,
    depth_maps::AGAINST_MESHES,
    depth_maps::STENCIL_PASSES,
];

/// The number of lights that plots are about which show one: eight where they were measured.
fn usual_lights(results: &Results) -> usize {
    let has = |lights: usize| results.rows.iter().any(|row| row.lights == lights);
    if has(8) { 8 } else { results.rows.first().map_or(8, |row| row.lights) }
}

/// Rows of the smooth closed meshes, smaller ones first.
fn ordinary<'a>(results: &'a Results, lights: usize) -> Vec<&'a Row> {
    let mut rows: Vec<&'a Row> =
        results.rows.iter().filter(|row| row.lights == lights && row.subject.class == ORDINARY).collect();
    rows.sort_by_key(|row| row.subject.faces);
    rows
}

/// All numbers of lights, fewest first.
fn light_counts(results: &Results) -> Vec<usize> {
    let mut all: Vec<usize> = results.rows.iter().map(|row| row.lights).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// `8 lights`.
fn lights_text(lights: usize) -> String {
    if lights == 1 { "1 light".to_owned() } else { format!("{lights} lights") }
}

/// All plots that the rows are enough for.
pub(super) fn extraction(results: &Results) -> Section {
    let mut figures = vec![classes::classes(results), error::time_against_error(results), error::errors(results)];
    figures.extend(size::time_against_size(results));
    if results.rows.iter().any(|row| row.entry(PER_EDGE).is_some()) {
        figures.extend(size::speed_against_2003(results));
    }
    figures.extend(lights::time_against_lights(results, &light_counts(results)));
    figures.extend(stages::stages(results));
    figures.push(cost::cost_of_exactness(results));
    let gpu = results.rows.iter().any(|row| row.entry(GPU_EXACT).is_some());
    let lead = if gpu {
        "Times are of facing and silhouettes from new positions: on the GPU, to lists of silhouette edges in its memory; \
         on the CPU, to a mask an edge. All methods of a mesh ran in turn, round by round, and ratios are medians of \
         each round's ratio."
    } else {
        "Times are of facing and silhouettes from new positions, to a mask an edge. All methods of a mesh ran in turn, \
         round by round, and ratios are medians of each round's ratio."
    };
    Section { title: "Extraction".to_owned(), lead: lead.to_owned(), figures }
}
