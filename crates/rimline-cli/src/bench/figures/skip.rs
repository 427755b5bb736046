//! The report's section on skipping: where a frame's work goes, with each choice of levels.

use super::super::skip::results::{COUNTERS, DEFORM, PARTS, SkipEntry, SkipPart, SkipResults, SkipRow, StageRun};
use super::super::text::{figures, grouped, tick};
use crate::chart::{Axis, Bars, BarsKind, Chart, Group, Key, Scale, Value};
use crate::page::{Figure, Section, Table};

/// The plot's id.
pub(super) const WORK: &str = "skipping_work";

/// A colour of the plot: what is done in some stages.
struct Work {
    name: &'static str,
    colour: usize,
    stages: &'static [&'static str],
}

/// In the order of the frame. Stages that none of these has are together in one more.
const WORKS: [Work; 6] = [
    Work { name: "deforming", colour: 0, stages: &[DEFORM] },
    Work { name: "what is needed", colour: 6, stages: &["reach", "chunks"] },
    Work { name: "facing", colour: 3, stages: &["facing", "exact_facing"] },
    Work { name: "edges", colour: 1, stages: &["edges", "arguments"] },
    Work { name: "choices", colour: 5, stages: &["receiver_depth", "receiver_pyramid", "relist", "bounds", "choose"] },
    Work { name: "caps and sides", colour: 4, stages: &["caps", "list_sides", "shadow_arguments"] },
];
const OTHER: Key = Key { name: String::new(), colour: 7, shape: 1, hollow: false };
const STENCIL_COLOUR: usize = 2;

/// All that the rows are enough for; there is at least one.
pub(in super::super) fn skipping(results: &SkipResults) -> Section {
    let size = results.size;
    Section {
        title: "Where a frame's work goes, and what is skipped".to_owned(),
        lead: format!(
            "Each scene with all levels of skipping off, with all on, and with each level off while the others are on, \
             {size} × {size} pixels. All choices ran in turn, round by round. In the scene still nothing moves among \
             figures of 4,000 faces. In the city a sun lights buildings of 12 to 92 faces, and the eye is in a street. In the \
             crowd skinned figures walk, and each of the lamps reaches few of them; the eye is above them, and within. The \
             ground receives and does not cast. Depths are \
             drawn in whole frames alone, so the times of stages are those of frames that know no receivers."
        ),
        figures: vec![work(results), frames(results), stages(results), counters(results)],
    }
}

/// Milliseconds of the work of each colour, then of the stencil passes.
fn amounts(entry: &SkipEntry) -> Vec<f64> {
    // One run, so that its parts are of one frame: that of median time.
    let mut runs: Vec<&StageRun> = entry.stages.iter().collect();
    runs.sort_by(|a, b| a.compute_ms().total_cmp(&b.compute_ms()));
    let run = runs.get(runs.len() / 2);
    let of = |stages: &[&str]| run.map_or(0.0, |run| stages.iter().map(|stage| run.of(stage)).sum());
    let mut amounts: Vec<f64> = WORKS.iter().map(|work| of(work.stages)).collect();
    let all: f64 = run.map_or(0.0, |run| run.stages.iter().map(|(_, ms)| ms).sum());
    let known: f64 = amounts.iter().sum();
    // A remainder as small as rounding errors counts as no time.
    amounts.push(if all - known > 1e-6 * all { all - known } else { 0.0 });
    amounts.push(entry.part(SkipPart::Stencil).map_or(0.0, |ms| ms.median));
    amounts
}

/// The plot: each scene's bars against its bar with all levels off.
fn work(results: &SkipResults) -> Figure {
    let key = |name: &str, colour| Key { name: name.to_owned(), colour, ..OTHER };
    let mut keys: Vec<Key> = WORKS.iter().map(|work| key(work.name, work.colour)).collect();
    keys.extend([key("other stages", OTHER.colour), key("stencil passes", STENCIL_COLOUR)]);
    let rows: Vec<(&SkipRow, Vec<Vec<f64>>)> =
        results.rows.iter().map(|row| (row, row.entries.iter().map(amounts).collect())).collect();
    // A legend of what no bar has would be a riddle.
    let is_shown: Vec<bool> = (0..keys.len())
        .map(|index| rows.iter().flat_map(|(_, bars)| bars).any(|amounts| amounts[index] > 0.0))
        .collect();
    let shown = |index: &usize| is_shown[*index];
    let mut table = Table { head: vec!["Scene and levels".to_owned()], rows: Vec::new(), is_prose: false };
    table.head.extend((0..keys.len()).filter(shown).map(|index| format!("{}, ms", keys[index].name)));
    table.head.push("together, ms".to_owned());
    let mut groups = Vec::new();
    let mut longest = vec![100.0];
    for (row, bars) in &rows {
        let whole: f64 = bars.first().map_or(0.0, |amounts| amounts.iter().sum());
        for (number, (entry, amounts)) in row.entries.iter().zip(bars).enumerate() {
            let sum: f64 = amounts.iter().sum();
            let percent = |ms: f64| if whole > 0.0 { 100.0 * ms / whole } else { 0.0 };
            let name = entry.variant.name();
            let values = (0..keys.len()).filter(shown).map(|index| {
                let ms = amounts[index];
                (ms > 0.0).then(|| Value {
                    length: percent(ms),
                    spread: None,
                    label: figures(ms),
                    tip: format!("{}, {name}, {}: {} ms", row.title(), keys[index].name, figures(ms)),
                })
            });
            groups.push(Group {
                values: values.collect(),
                remark: format!("{} ms", figures(sum)),
                heading: if number == 0 { row.title() } else { String::new() },
                name,
            });
            longest.push(percent(sum));
            let mut cells = vec![format!("{}: {}", row.title(), entry.variant.name())];
            cells.extend((0..keys.len()).filter(shown).map(|index| figures(amounts[index])));
            cells.push(figures(sum));
            table.rows.push(cells);
        }
    }
    let mut shown = is_shown.iter();
    keys.retain(|_| shown.next() == Some(&true));
    let title = "time of the GPU, percent of that with all levels off";
    Figure {
        id: WORK,
        title: "Where a frame's work goes".to_owned(),
        lead: "Times of the compute stages in their run of median time, and the median of the stencil passes. A scene's bar \
               with all levels off is 100. The numbers in and after bars are milliseconds. Stages are timed on a device \
               of their own, on which nothing is drawn."
            .to_owned(),
        chart: Some(Chart::Bars(Bars {
            kind: BarsKind::Stacked,
            axis: Axis::over(title, Scale::Linear, tick, longest),
            keys,
            groups,
            marks: Vec::new(),
        })),
        table,
    }
}

/// For each scene and choice of levels a row with these cells.
fn table(results: &SkipResults, head: Vec<String>, cells: impl Fn(&SkipRow, &SkipEntry) -> Vec<String>) -> Table {
    let rows = results.rows.iter().flat_map(|row| {
        let cells = &cells;
        row.entries.iter().map(move |entry| {
            let mut line = vec![format!("{}: {}", row.title(), entry.variant.name())];
            line.extend(cells(row, entry));
            line
        })
    });
    let rows = rows.collect();
    let head = ["Scene and levels".to_owned()].into_iter().chain(head).collect();
    Table { head, rows, is_prose: false }
}

fn or_dash(text: Option<String>) -> String {
    text.unwrap_or_else(|| "–".to_owned())
}

/// A frame's parts, and how they compare with those with all levels on.
fn frames(results: &SkipResults) -> Figure {
    let head = PARTS.iter().flat_map(|part| [format!("{}, ms", part.name()), "÷ all on".to_owned()]);
    let head = head.chain(["parts ÷ frame".to_owned()]);
    let table = table(results, head.collect(), |row, entry| {
        let together = or_dash(entry.parts_of_frame().map(|share| format!("{:.2}", share.median)));
        let cells = PARTS.into_iter().flat_map(|part| {
            let ratio = row.ratio(entry, part).map(|ratio| format!("{:.2}", ratio.median));
            // A part that did not run has a time of 0, which the table shows as a dash.
            let ms = entry.part(part).filter(|ms| ms.median > 0.0).map(|ms| figures(ms.median));
            [or_dash(ms), or_dash(ratio)]
        });
        cells.chain([together]).collect()
    });
    Figure {
        id: "skipping_frames",
        title: "A frame's parts with each choice of levels".to_owned(),
        lead: "Medians, and medians of each round's time divided by that with all levels on: larger means that the levels \
               save more. The whole frame is by the clock, from the submission on: deforming, all compute stages, and the \
               stencil passes of all lights. Depths that volumes are tested against are drawn before and not timed. Recording \
               is CPU time. The last column is deforming, compute and stencil passes together divided by the whole frame of the \
               same round: far from 1, the machine was busy, and times are not to be trusted."
            .to_owned(),
        chart: None,
        table,
    }
}

/// Each stage's median time.
fn stages(results: &SkipResults) -> Figure {
    let mut names = Vec::new();
    for name in results.rows.iter().flat_map(|row| &row.entries).flat_map(SkipEntry::stage_names) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let head = names.iter().map(|name| format!("{name}, ms")).collect();
    let table = table(results, head, |_, entry| {
        let has = entry.stage_names();
        let of = |name: &&'static str| has.contains(name).then(|| entry.stage(name)).flatten();
        names.iter().map(|name| or_dash(of(name).map(|ms| figures(ms.median)))).collect()
    });
    Figure {
        id: "skipping_stages",
        title: "Stage by stage".to_owned(),
        lead: "Medians of each stage's GPU time.".to_owned(),
        chart: None,
        table,
    }
}

/// Counters of the stages, and fragments.
fn counters(results: &SkipResults) -> Figure {
    let mut head = vec!["volume fragments".to_owned(), "÷ all on".to_owned()];
    head.extend(COUNTERS.iter().map(|counter| counter.name.to_owned()));
    let table = table(results, head, |row, entry| {
        let mut cells = vec![
            or_dash(entry.fragments.map(|fragments| grouped(fragments as usize))),
            or_dash(row.fragments_ratio(entry).map(|ratio| format!("{ratio:.2}"))),
        ];
        cells.extend(COUNTERS.iter().map(|counter| grouped((counter.of)(&entry.counted) as usize)));
        cells
    });
    Figure {
        id: "skipping_counters",
        title: "What is counted".to_owned(),
        lead: "Of the third frame. Volume fragments are pixels that the volumes' draws cover, of all lights, each time that \
               they cover one: the samples that pass against depths without any surface. Fragments that lie behind what is \
               visible count, since a device makes them before it tests them. There is a dash where the device's \
               queries do not count."
            .to_owned(),
        chart: None,
        table,
    }
}
