//! The report's section on skipping: where a frame's work goes, with each choice of levels.

use std::collections::HashSet;

use super::Parts;
use crate::engine::Metric;
use crate::page::{Figure, Section as Part, Table};
use crate::row::{Entry, Row};
use crate::skipping::{COUNTERS, PARTS};
use crate::text::{grouped, or_dash, three_digits};

/// A colour of the chart: what is done in some stages, in the order of the frame.
const WORKS: [(&str, usize, &[&str]); 6] = [
    ("deforming", 0, &["deform"]),
    ("what is needed", 6, &["cull_lights", "chunks"]),
    ("facing", 3, &["facing", "exact_facing"]),
    ("edges", 1, &["edges", "arguments"]),
    ("choices", 5, &["receiver_depth", "receiver_pyramid", "relist", "bounds", "counting_methods"]),
    ("caps and sides", 4, &["caps", "list_sides", "shadow_arguments"]),
];

pub(super) fn section(rows: &[&Row]) -> Part {
    let size = rows[0].number("size");
    Part {
        title: "Where a frame's work goes, and what is skipped".to_owned(),
        lead: format!(
            "Each scene with all levels of skipping off, with all on, and with each level off while the others are on, \
             {size} × {size} pixels. All choices ran in turn, round by round. In the scene still nothing moves among \
             figures of 4,000 faces. In the city a sun lights buildings of 12 to 92 faces, and the eye is in a street. In the \
             crowd skinned figures walk, and each of the lamps reaches few of them; the eye is above them, and within. The \
             ground receives and does not cast. Depths are drawn in whole frames alone, so the times of stages are those of \
             frames that know no receivers."
        ),
        figures: vec![work(rows), frames(rows), stages(rows), counters(rows)],
    }
}

/// Each scene's bars against its bar with all levels off.
fn work(rows: &[&Row]) -> Figure {
    let keys = WORKS.map(|(name, colour, _)| (name, colour)).into_iter();
    let mut parts = Parts::new(keys.chain([("other stages", 7), ("stencil passes", 2)]), "Scene and levels");
    for row in rows {
        parts.heading(&row.title);
        let mut unit = None;
        for entry in &row.entries {
            let amounts = amounts(entry);
            // A hundredth of the time with all levels off.
            let unit = *unit.get_or_insert((amounts.iter().sum::<f64>() / 100.0).max(1e-9));
            parts.push([&row.title, &entry.variant.name], &amounts, unit);
        }
    }
    let (chart, table) = parts.finish("GPU time, percent of all levels off");
    let lead = "Medians of the compute stages and of the stencil passes. A scene's bar with all levels off is 100; the numbers \
                after bars are milliseconds. Stages are timed on a device of their own, on which nothing is drawn.";
    Figure::new("skipping_work", "Where a frame's work goes", lead, Some(chart), table)
}

/// Milliseconds of the work of each colour, of other stages, of the stencil passes.
fn amounts(entry: &Entry) -> Vec<f64> {
    let of = |stage: &'static str| entry.median(Metric::Stage(stage)).unwrap_or(0.0);
    let mut amounts: Vec<f64> = WORKS.iter().map(|(.., stages)| stages.iter().map(|stage| of(stage)).sum()).collect();
    let is_known = |stage: &&str| WORKS.iter().any(|(.., stages)| stages.contains(stage));
    amounts.push(entry.stages().filter(|stage| !is_known(stage)).map(of).sum());
    amounts.push(entry.median(Metric::Time("stencil")).unwrap_or(0.0));
    amounts
}

/// For each scene and choice of levels a row with these cells.
fn of_all(rows: &[&Row], head: Vec<String>, cells: impl Fn(&Row, &Entry) -> Vec<String>) -> Table {
    let mut table = Table::new(["Scene and levels".to_owned()].into_iter().chain(head));
    for row in rows {
        for entry in &row.entries {
            let first = format!("{}: {}", row.title, entry.variant.name);
            table.rows.push([first].into_iter().chain(cells(row, entry)).collect());
        }
    }
    table
}

/// A frame's parts, and how they compare with those with all levels on.
fn frames(rows: &[&Row]) -> Figure {
    let head = PARTS.iter().flat_map(|part| [format!("{part}, ms"), "÷ all on".to_owned()]);
    let head = head.chain(["parts ÷ frame".to_owned()]).collect();
    let found = of_all(rows, head, |row, entry| {
        let cells = PARTS.into_iter().flat_map(|part| {
            let ratio = row.ratio(Metric::Time(part), &entry.variant.id, "all-on").map(|ratio| ratio.median);
            // A part that did not run has a time of 0, which the table shows as a dash.
            let ms = entry.median(Metric::Time(part)).filter(|ms| *ms > 0.0);
            [or_dash(ms), or_dash(ratio)]
        });
        let of = |part| entry.median(Metric::Time(part)).unwrap_or(0.0);
        let together = (of("deform") + of("compute") + of("stencil")) / of("frame");
        cells.chain([or_dash(Some(together))]).collect()
    });
    let lead = "Medians, and medians of each round's time divided by that with all levels on: larger means that the levels \
                save more. The whole frame is by the clock, from the submission on: deforming, all compute stages, and the \
                stencil passes of all lights. Depths that volumes are tested against are drawn before and not timed. Recording \
                is CPU time. The last column is deforming, compute and stencil passes together divided by the whole frame: far \
                from 1, the machine was busy, and times are not to be trusted.";
    Figure::new("skipping_frames", "A frame's parts with each choice of levels", lead, None, found)
}

/// Each stage's median time.
fn stages(rows: &[&Row]) -> Figure {
    let mut names: Vec<&'static str> = rows.iter().flat_map(|row| &row.entries).flat_map(Entry::stages).collect();
    let mut known = HashSet::new();
    names.retain(|name| known.insert(*name));
    let head = names.iter().map(|name| format!("{name}, ms")).collect();
    let found =
        of_all(rows, head, |_, entry| names.iter().map(|name| or_dash(entry.median(Metric::Stage(name)))).collect());
    Figure::new("skipping_stages", "Stage by stage", "Medians of each stage's GPU time.", None, found)
}

/// Counters of the stages, and fragments.
fn counters(rows: &[&Row]) -> Figure {
    let mut head = vec!["volume fragments".to_owned(), "÷ all on".to_owned()];
    head.extend(COUNTERS.iter().map(|(name, _)| name.replace('-', " ")));
    let found = of_all(rows, head, |row, entry| {
        let fragments = entry.values(Metric::Count("fragments")).first();
        let ratio = row.ratio(Metric::Count("fragments"), &entry.variant.id, "all-on").map(|ratio| ratio.median);
        let mut cells = vec![
            fragments.map_or_else(|| "–".to_owned(), |fragments| grouped(*fragments as usize)),
            ratio.map_or_else(|| "–".to_owned(), three_digits),
        ];
        cells.extend(COUNTERS.iter().map(|(name, _)| grouped(entry.count(name) as usize)));
        cells
    });
    let lead = "Of the third frame. Volume fragments are pixels that the volumes' draws cover, of all lights, each time that \
                they cover one: the samples that pass against depths without any surface. Fragments that lie behind what is \
                visible count, since a device makes them before it tests them. There is a dash where the device's \
                queries do not count.";
    Figure::new("skipping_counters", "What is counted", lead, None, found)
}
