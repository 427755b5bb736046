//! The report's section on shadows.

use super::super::measure::Summary;
use super::super::shadows::method::{AUTO, METHODS, ShadowMethod, Z_FAIL, Z_PASS};
use super::super::shadows::results::{Part, ShadowEntry, ShadowResults, ShadowRow};
use super::super::shadows::scene::{PATHS, Path};
use super::super::text::{figures, grouped, tick, times};
use crate::chart::{
    Axis, Bars, BarsKind, Chart, Curve, Group, Panel, PanelRow, Panels, Plane, Point, Scale, Value, ZeroBand,
};
use crate::page::{Figure, Section, Table};

/// All plots of shadows; there is at least one row.
pub(in super::super) fn shadows(results: &ShadowResults) -> Section {
    let size = results.size;
    Section {
        title: "Shadow volumes".to_owned(),
        lead: format!(
            "One caster in the middle of a closed room, one point light, {size} × {size} pixels, paths of {} cameras, \
             after Hornus and others, ZP+: correct z-pass stencil shadows (2005). The stencil pass counts volumes; the whole \
             frame also extracts silhouettes, chooses, and draws depth and light. All methods of a path ran in turn, round \
             by round. {}",
            results.frames,
            verdict(results)
        ),
        figures: vec![
            time_against_error(results),
            costs(results, Part::Stencil),
            costs(results, Part::Frame),
            along_paths(results),
        ],
    }
}

/// Cost of `auto`, in a sentence.
fn verdict(results: &ShadowResults) -> String {
    let mean = |part, to| results.mean_ratio(part, AUTO, to).map_or(f64::NAN, |(mean, _)| mean);
    format!(
        "On average over models and paths, auto took {:.2} times the z-pass and {:.2} times the z-fail time in the \
         stencil pass, {:.2} and {:.2} times in the whole frame.",
        mean(Part::Stencil, Z_PASS),
        mean(Part::Stencil, Z_FAIL),
        mean(Part::Frame, Z_PASS),
        mean(Part::Frame, Z_FAIL)
    )
}

fn rows_of(results: &ShadowResults, path: Path) -> impl Iterator<Item = &ShadowRow> {
    results.rows.iter().filter(move |row| row.path == path)
}

/// `twisted torus, 12,000 faces`.
fn model(row: &ShadowRow) -> String {
    format!("{}, {} faces", row.model, grouped(row.faces))
}

/// One point a method and path.
fn time_against_error(results: &ShadowResults) -> Figure {
    let head = ["Method, path", "stencil ms a frame", "wrong pixels a frame", "wrong pixels", "frames looked at"];
    let mut table = Table { head: head.map(str::to_owned).into(), rows: Vec::new(), is_prose: false };
    let (mut curves, mut x, mut y) = (Vec::new(), Vec::new(), Vec::new());
    for method in &METHODS {
        let mut points = Vec::new();
        for path in PATHS {
            let entries: Vec<&ShadowEntry> = rows_of(results, path).filter_map(|row| row.entry(method.id)).collect();
            let Some(ms) = mean(entries.iter().filter_map(|entry| entry.mean(Part::Stencil)).map(|ms| ms.median))
            else {
                continue;
            };
            let all = || entries.iter().flat_map(|entry| &entry.wrong_pixels);
            let (wrong, frames): (usize, usize) = (all().map(|wrong| wrong.pixels).sum(), all().count());
            let share = wrong as f64 / frames.max(1) as f64;
            x.push(ms);
            y.push(share);
            let name = format!("{}: {}", method.name, path.name());
            table.rows.push(vec![name.clone(), figures(ms), figures(share), grouped(wrong), grouped(frames)]);
            points.push(Point {
                x: ms,
                y: share,
                spread: None,
                label: if share > 0.0 && method.id == Z_PASS { path.name().to_owned() } else { String::new() },
                tip: format!("{name}: {} ms, {} wrong pixels a frame", figures(ms), figures(share)),
            });
        }
        curves.push(Curve { key: method.key(), points, remark: String::new() });
    }
    let chart = Chart::Plane(Plane {
        x: Axis::over("stencil pass: milliseconds a frame (further left is faster)", Scale::Log, tick, x),
        y: Axis::over("wrong pixels a frame", Scale::Log, tick, y),
        curves,
        joined: false,
        mark: None,
        zero: Some(ZeroBand { title: "none wrong".to_owned() }),
    });
    Figure {
        id: "shadow_time_against_error",
        title: "Shadows: run time against error".to_owned(),
        lead: format!(
            "One mark for each method and path, over all models. Wrong is a pixel that is lit or shadowed otherwise than \
             by rays in double precision, more than a pixel from the shadow's edge; of {} pixels. Where the camera stands \
             in the shadow z-pass is wrong nearly everywhere. The one pixel in a few frames that is wrong by every method \
             alike has an edge within the rasteriser's grid of its centre \
             (docs/numerics/rasterisers.md of the repository, Hairlines).",
            grouped((results.size * results.size) as usize)
        ),
        chart: Some(chart),
        table,
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

/// The methods that are held against z-pass.
fn compared() -> impl Iterator<Item = &'static ShadowMethod> {
    METHODS.iter().filter(|method| method.id != Z_PASS)
}

/// Time ÷ time of z-pass, a line a model and path.
fn costs(results: &ShadowResults, part: Part) -> Figure {
    let (id, title, what) = match part {
        Part::Stencil => ("shadow_stencil", "Cost of counting: the stencil pass against z-pass", "stencil pass"),
        Part::Frame => ("shadow_frame", "Cost of counting: the whole frame against z-pass", "whole frame"),
    };
    let mut head = vec!["Model, path".to_owned(), "z-pass, ms a frame".to_owned()];
    head.extend(compared().flat_map(|method| [format!("{} ÷ z-pass", method.name), "quartiles".to_owned()]));
    let mut table = Table { head, rows: Vec::new(), is_prose: false };
    let (mut groups, mut all, mut last) = (Vec::new(), Vec::new(), "");
    for row in &results.rows {
        let mut values = Vec::new();
        let ms = row.entry(Z_PASS).and_then(|entry| entry.mean(part)).map_or(f64::NAN, |ms| ms.median);
        let mut cells = vec![format!("{}: {}", row.model, row.path.name()), figures(ms)];
        for method in compared() {
            let ratio = row.ratio(part, method.id, Z_PASS);
            all.extend(ratio.map(|ratio| ratio.median));
            cells.extend(match ratio {
                None => ["–".to_owned(), "–".to_owned()],
                Some(Summary { median, quartiles, .. }) => {
                    [format!("{median:.2}"), format!("{:.2} to {:.2}", quartiles.0, quartiles.1)]
                }
            });
            values.push(ratio.map(|ratio| Value {
                length: ratio.median,
                spread: Some(ratio.quartiles),
                label: String::new(),
                tip: format!("{}, {}: {} times z-pass", model(row), method.name, figures(ratio.median)),
            }));
        }
        table.rows.push(cells);
        let heading = if row.model == last { String::new() } else { model(row) };
        last = row.model;
        groups.push(Group { name: row.path.name().to_owned(), heading, values, remark: String::new() });
    }
    let means: Vec<_> = compared().map(|method| (method, results.mean_ratio(part, method.id, Z_PASS))).collect();
    let mean_value = |(method, mean): &(&ShadowMethod, Option<(f64, [f64; 2])>)| {
        mean.map(|(length, _)| Value {
            length,
            spread: None,
            label: String::new(),
            tip: format!("all, {}: {} times z-pass", method.name, figures(length)),
        })
    };
    groups.push(Group {
        name: "mean".to_owned(),
        heading: "all models".to_owned(),
        values: means.iter().map(mean_value).collect(),
        remark: String::new(),
    });
    let mut cells = vec!["all: mean".to_owned(), String::new()];
    cells.extend(means.iter().flat_map(|(_, mean)| match mean {
        None => ["–".to_owned(), String::new()],
        Some((mean, [low, high])) => [format!("{mean:.2}"), format!("{low:.2} to {high:.2}")],
    }));
    table.rows.push(cells);
    let chart = Chart::Bars(Bars {
        kind: BarsKind::Dots,
        axis: Axis::over(format!("time of the {what} ÷ time with z-pass"), Scale::Log, times, all)
            .including(0.9)
            .including(2.0),
        keys: compared().map(ShadowMethod::key).collect(),
        groups,
        marks: vec![(1.0, "z-pass".to_owned())],
    });
    Figure {
        id,
        title: title.to_owned(),
        lead: format!(
            "Time of the {what} over the path ÷ the same with z-pass, in the same run; on the dashed line it costs what \
             z-pass costs, which is wrong where the camera stands in a shadow. The last line is the mean of those above."
        ),
        chart: Some(chart),
        table,
    }
}

/// Small plots frame by frame, as the paper's figure 9.
fn along_paths(results: &ShadowResults) -> Figure {
    let mut rows: Vec<PanelRow> = Vec::new();
    let mut head = vec!["Model, path, method".to_owned()];
    head.extend((0..results.frames).map(|frame| (frame + 1).to_string()));
    let mut table = Table { head, rows: Vec::new(), is_prose: false };
    let mut all = Vec::new();
    for row in &results.rows {
        let mut panel = Panel::default();
        for method in compared() {
            let ratios = row.ratios_of_frames(Part::Stencil, method.id, Z_PASS);
            all.extend(&ratios);
            let mut cells = vec![format!("{}, {}, {}", row.model, row.path.name(), method.name)];
            cells.extend(ratios.iter().map(|ratio| format!("{ratio:.2}")));
            table.rows.push(cells);
            panel.curves.push((1..).zip(ratios).map(|(frame, ratio)| [f64::from(frame), ratio]).collect());
        }
        if row.path == PATHS[0] {
            rows.push(PanelRow { name: model(row), panels: Vec::new() });
        }
        if let Some(last) = rows.last_mut() {
            last.panels.push(panel);
        }
    }
    let frames = (1..=results.frames).map(|frame| frame as f64);
    let chart = Chart::Panels(Panels {
        x: Axis::over("frame of the path", Scale::Linear, tick, frames),
        y: Axis::over("time ÷ time of z-pass", Scale::Log, times, all).including(0.9).including(2.0),
        keys: compared().map(ShadowMethod::key).collect(),
        columns: PATHS.map(|path| path.name().to_owned()).into(),
        rows,
        mark: Some(1.0),
    });
    Figure {
        id: "shadow_paths",
        title: "Along the paths: the stencil pass against z-pass, frame by frame".to_owned(),
        lead: "A row a model, a column a path; medians of each round's ratio. On the dashed line a method costs what \
               z-pass costs."
            .to_owned(),
        chart: Some(chart),
        table,
    }
}
