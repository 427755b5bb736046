//! The report's section on scenes of many casters.

use super::{ms, over, ratio_cells};
use crate::casters::LIGHTS;
use crate::engine::Metric;
use crate::page::{Figure, Section as Part, Table};
use crate::row::{Entry, Row};
use crate::text::grouped;

/// All that the rows are enough for.
pub(super) fn section(rows: &[&Row], one_mesh: &[&Row]) -> Option<Part> {
    let all = || rows.iter().chain(one_mesh);
    let size = rows.first()?.number("size");
    let wrong: f64 = all().map(|row| row.number("wrong_lights")).sum();
    Some(Part {
        title: "Scenes of many casters".to_owned(),
        lead: format!(
            "Boxes of 12 faces and figures of 4,000, rigid, in a cube; {LIGHTS} point lights above it, and a camera before \
             it that sees about half of it, {size} × {size} pixels. The number of silhouette edges of each light is \
             compared with that of the same faces merged into one mesh: of {} pairs of scene and light, {} differ.",
            grouped(all().count() * LIGHTS),
            grouped(wrong as usize)
        ),
        figures: vec![recording(rows), memory(rows), gpu(rows), extractors(one_mesh)],
    })
}

/// The chart has the boxes, or the figures where there are no boxes.
fn recording(rows: &[&Row]) -> Figure {
    let is_box = rows.iter().any(|row| row.scene == "box");
    let shown: Vec<&Row> = rows.iter().filter(|row| !is_box || row.scene == "box").copied().collect();
    // More curves would overlap.
    let is_shown = |entry: &Entry| !["scene-light-moved", "scene-new-caster"].contains(&entry.variant.id.as_str());
    let metric = Metric::Time("recording");
    let (chart, _) = over(["casters", "CPU milliseconds of recording a frame"], "casters", &shown, metric, is_shown);
    let variants =
        || rows[0].entries.iter().filter(|entry| entry.summary(metric).is_some()).map(|entry| &entry.variant);
    let mut table = Table::new(["Casters"]);
    table.head.extend(variants().map(|variant| variant.name.clone()));
    for row in rows {
        let cells = variants().map(|variant| ms(row.summary(&variant.id, metric)));
        table.rows.push([row.title.clone()].into_iter().chain(cells).collect());
    }
    let title = format!("Recording a frame against the number of casters, {LIGHTS} lights, one view");
    let lead = "CPU time of moving what moves, of recording all stages and of finishing the command buffer, without its \
                submission. Medians; all methods of a scene ran in turn. Beside a scene of all casters stands \
                a scene for each caster.";
    Figure::new("casters_recording", title, lead, Some(chart), table)
}

fn memory(rows: &[&Row]) -> Figure {
    let bytes = ["scene_bytes", "scene_device_bytes", "extractors_device_bytes"];
    let head = ["Casters", "bytes a caster, scene", "on the device, scene", "on the device, a scene a caster"];
    let mut found = Table::new(head);
    for row in rows {
        let each = |name: &str| {
            let bytes = row.fact(name).and_then(serde_json::Value::as_f64);
            bytes.map_or_else(|| "–".to_owned(), |bytes| grouped((bytes / row.number("casters")).round() as usize))
        };
        found.rows.push([row.title.clone()].into_iter().chain(bytes.map(each)).collect());
    }
    let lead =
        "Bytes of a scene are its buffers; those on the device also hold topology, and are what the device allocated.";
    Figure::new("casters_memory", "Memory of a caster", lead, None, found)
}

/// GPU times against the merged mesh.
fn gpu(rows: &[&Row]) -> Figure {
    let parts = [
        ("extraction", "scene", "extraction"),
        ("extraction", "scene-still", "nothing moved"),
        ("stages", "scene", "all stages"),
        ("stencil", "scene", "stencil passes"),
        ("frame", "scene", "whole frame"),
    ];
    let mut found = Table::new(["Casters"]);
    found.head.extend(
        parts.iter().flat_map(|(.., name)| [format!("{name}, scene"), "merged".to_owned(), "ratio".to_owned()]),
    );
    for row in rows {
        let mut cells = vec![row.title.clone()];
        for (metric, of, _) in parts {
            let metric = Metric::Time(metric);
            cells.extend([of, "merged"].map(|id| ms(row.summary(id, metric))));
            cells.push(ratio_cells(row.ratio(metric, of, "merged"))[0].clone());
        }
        found.rows.push(cells);
    }
    let lead = "Ratios are the scene's time divided by the merged mesh's, medians of each round's ratio; smaller is better, \
                and below 1 the scene is the faster one. Scenes compute everything, except where nothing moved: there they keep \
                what the frame before computed. Stencil passes are those of all lights, over depths without any \
                surface. The whole frame is all stages and stencil passes; on software devices it is by the clock, from the \
                submission on. Stages are timed on a device of their own, on which nothing is drawn.";
    Figure::new("casters_gpu", "GPU time of a scene against the same faces merged into one mesh", lead, None, found)
}

/// A scene of one caster against an extractor.
fn extractors(rows: &[&Row]) -> Figure {
    let mut found = Table::new(["Faces", "scene of one caster", "extractor", "ratio", "quartiles"]);
    let metric = Metric::Time("extraction");
    for row in rows {
        let [scene, other] = ["scene", "extractor"].map(|id| ms(row.summary(id, metric)));
        let [ratio, quartiles] = ratio_cells(row.ratio(metric, "scene", "extractor"));
        found.rows.push(vec![row.title.clone(), scene, other, ratio, quartiles]);
    }
    let lead =
        "GPU time of extraction alone. A ratio is the scene's time divided by the extractor's; smaller is better.";
    Figure::new(
        "casters_one_mesh",
        "Extraction of one mesh: a scene of one caster against an extractor",
        lead,
        None,
        found,
    )
}
