//! The report's section on scenes of many casters.

use super::super::casters::field::{CasterMesh, LIGHTS};
use super::super::casters::results::{CastersResults, CastersRow, Change, OneMeshRow, PARTS, Part};
use super::super::measure::Summary;
use super::super::text::{figures, grouped, tick};
use crate::chart::{Axis, Chart, Curve, Plane, Point, Scale};
use crate::page::{Figure, Section, Table};

/// The plot's id.
pub(super) const RECORDING: &str = "casters_recording";

const CHANGES: [Change; 6] =
    [Change::Still, Change::OneInHundred, Change::All, Change::Light, Change::NewCaster, Change::Extractors];
/// Changes in the plot; more curves would overlap.
const SHOWN: [Change; 4] = [Change::Still, Change::OneInHundred, Change::All, Change::Extractors];

/// All that the rows are enough for; there is at least one.
pub(in super::super) fn casters(results: &CastersResults) -> Section {
    let size = results.size;
    let wrong: usize = results.rows.iter().map(CastersRow::wrong_lights).sum::<usize>()
        + results.one_mesh.iter().map(OneMeshRow::wrong_lights).sum::<usize>();
    let rows = results.rows_done();
    Section {
        title: "Scenes of many casters".to_owned(),
        lead: format!(
            "Boxes of 12 faces and figures of 4,000, rigid, in a cube; {LIGHTS} point lights above it, and a camera before \
             it that sees about half of it, {size} × {size} pixels. The number of silhouette edges of each light is \
             compared with that of the same faces merged into one mesh: of {} pairs of scene and light, {} differ.",
            grouped(rows * LIGHTS),
            grouped(wrong)
        ),
        figures: [recording(results), gpu(results), one_mesh(results)].into_iter().flatten().collect(),
    }
}

fn ms(summary: Option<&Summary>) -> String {
    summary.map_or_else(|| "–".to_owned(), |summary| format!("{} ms", figures(summary.median)))
}

/// CPU time and memory; the plot has the boxes, or the figures where there are no boxes.
fn recording(results: &CastersResults) -> Option<Figure> {
    let first = results.rows.first()?.mesh;
    let shown = if results.rows.iter().any(|row| row.mesh == CasterMesh::Cube) { CasterMesh::Cube } else { first };
    let mut table = Table { head: vec!["Casters".to_owned()], rows: Vec::new(), is_prose: false };
    table.head.extend(CHANGES.map(|change| change.name().to_owned()));
    let bytes = ["bytes a caster, scene", "on the device, scene", "on the device, an extractor a caster"];
    table.head.extend(bytes.map(str::to_owned));
    for row in &results.rows {
        let each = |bytes: Option<u64>| {
            bytes.map_or_else(|| "–".to_owned(), |bytes| grouped(row.per_caster(bytes).round() as usize))
        };
        let mut cells = vec![row.mesh.counted(row.casters)];
        cells.extend(CHANGES.map(|change| ms(row.recording(change).as_ref())));
        cells.extend([Some(row.scene_bytes), row.scene_device_bytes, row.extractors_device_bytes].map(each));
        table.rows.push(cells);
    }
    let mut curves = Vec::new();
    for change in SHOWN {
        let rows = results.rows.iter().filter(|row| row.mesh == shown);
        let points = rows.filter_map(|row| {
            let time = row.recording(change)?;
            Some(Point {
                x: row.casters as f64,
                y: time.median,
                spread: Some(time.quartiles),
                label: String::new(),
                tip: format!(
                    "{}, {}: {} ms ({} to {}, {} runs)",
                    row.mesh.counted(row.casters),
                    change.name(),
                    figures(time.median),
                    figures(time.quartiles.0),
                    figures(time.quartiles.1),
                    time.count
                ),
            })
        });
        let mut points: Vec<Point> = points.collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let Some(last) = points.last() else { continue };
        let remark = format!("{}: {} ms", shown.counted(last.x as usize), figures(last.y));
        curves.push(Curve { key: change.key(), points, remark });
    }
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let chart = Chart::Plane(Plane {
        x: Axis::over("casters", Scale::Log, tick, points().map(|point| point.x)),
        y: Axis::over("CPU milliseconds of recording a frame", Scale::Log, tick, points().map(|point| point.y)),
        curves,
        joined: true,
        mark: None,
        zero: None,
    });
    Some(Figure {
        id: RECORDING,
        title: format!("Recording a frame against the number of casters, {LIGHTS} lights, one view"),
        lead: "CPU time of moving what moves, of recording all stages and of finishing the command buffer, without its \
               submission. Medians; all methods of a scene ran in turn. Beside a scene the way before it: an extractor with \
               shadow volumes for each caster. Bytes of a scene are its buffers; those on the device also hold topology, \
               and are what the device allocated."
            .to_owned(),
        chart: Some(chart),
        table,
    })
}

/// GPU times against the merged mesh, as a table.
fn gpu(results: &CastersResults) -> Option<Figure> {
    let head = [
        "Casters",
        "extraction, scene",
        "merged",
        "ratio",
        "nothing moved, scene",
        "merged",
        "ratio",
        "all stages, scene",
        "merged",
        "ratio",
        "stencil passes, scene",
        "merged",
        "ratio",
        "whole frame, scene",
        "merged",
        "ratio",
    ];
    let mut table = Table { head: head.map(str::to_owned).into(), rows: Vec::new(), is_prose: false };
    for row in &results.rows {
        let compared = &row.compared;
        let ratio = |part| compared.ratio(part).map_or_else(|| "–".to_owned(), |ratio| format!("{:.2}", ratio.median));
        let both = |part| [ms(compared.scene(part).as_ref()), ms(compared.other(part).as_ref())];
        let mut cells = vec![row.mesh.counted(row.casters)];
        for part in PARTS {
            cells.extend(both(part));
            cells.push(ratio(part));
        }
        table.rows.push(cells);
    }
    (!table.rows.is_empty()).then(|| Figure {
        id: "casters_gpu",
        title: "GPU time of a scene against the same faces merged into one mesh".to_owned(),
        lead: "Ratios are the scene's time divided by the merged mesh's, medians of each round's ratio; smaller is better, \
               and below 1 the scene is the faster one. Scenes compute everything, except where nothing moved: there they keep \
               what the frame before computed. Stencil passes are those of all lights, over depths without any \
               surface. The whole frame is all stages and stencil passes; on software devices it is by the clock, from the \
               submission on. Stages are timed on a device of their own, on which nothing is drawn."
            .to_owned(),
        chart: None,
        table,
    })
}

/// A scene of one caster against an extractor, as a table.
fn one_mesh(results: &CastersResults) -> Option<Figure> {
    let head = ["Faces", "scene of one caster", "extractor", "ratio", "quartiles"];
    let mut table = Table { head: head.map(str::to_owned).into(), rows: Vec::new(), is_prose: false };
    for row in &results.one_mesh {
        let part = Part::Extraction;
        let Some(ratio) = row.compared.ratio(part) else { continue };
        table.rows.push(vec![
            grouped(row.faces),
            ms(row.compared.scene(part).as_ref()),
            ms(row.compared.other(part).as_ref()),
            format!("{:.2}", ratio.median),
            format!("{:.2} to {:.2}", ratio.quartiles.0, ratio.quartiles.1),
        ]);
    }
    (!table.rows.is_empty()).then(|| Figure {
        id: "casters_one_mesh",
        title: "Extraction of one mesh: a scene of one caster against an extractor".to_owned(),
        lead:
            "GPU time of extraction alone. A ratio is the scene's time divided by the extractor's; smaller is better."
                .to_owned(),
        chart: None,
        table,
    })
}
