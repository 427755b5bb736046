//! The report's sections: charts, and a table of all that was measured.

use std::collections::BTreeSet;

use crate::chart::{Axis, Bar, Body, Chart, Point, Scale, Series};
use crate::engine::{Metric, Summary};
use crate::extraction::{GPU_EXACT, GPU_FAST, OF_USER, ORDINARY, PER_EDGE};
use crate::page::{Figure, Section as Part, Table};
use crate::row::{Entry, Mark, Row, Section, Variant};
use crate::shadows::Z_PASS;
use crate::text::{grouped, lights_text, or_dash, three_digits, tick, times};

pub const CHARTS: [&str; 7] = [
    "time_against_error",
    "speed_against_2003",
    "shadow_stencil",
    "casters_recording",
    "skipping_work",
    "depth_maps_against_meshes",
    "depth_maps_stencil_passes",
];

/// The sections of a report that the rows are enough for.
pub(crate) fn sections(rows: &[Row]) -> Vec<Part> {
    type Maker = (&'static [Section], fn(&[&Row]) -> Part);
    let makers: [Maker; 5] = [
        (&[Section::Extraction], extraction),
        (&[Section::Shadows], shadows),
        (&[Section::Casters, Section::OneMesh], casters),
        (&[Section::Skipping], skipping),
        (&[Section::DepthMaps], depth_maps),
    ];
    let of = |sections: &[Section]| rows.iter().filter(|row| sections.contains(&row.section)).collect::<Vec<_>>();
    let parts = makers.into_iter().map(|(sections, make)| (of(sections), make)).filter(|(rows, _)| !rows.is_empty());
    parts.map(|(rows, make)| make(&rows)).collect()
}

/// A line a scene and variant, a column a metric, and for times the ratios to the variants that others are compared with.
fn measured(id: &'static str, rows: &[&Row]) -> Figure {
    let mut columns: Vec<(Metric, Option<&str>)> = Vec::new();
    for row in rows {
        for (metric, _) in row.entries.iter().flat_map(|entry| &entry.metrics) {
            let to = match metric {
                // Extraction has its time twice.
                Metric::Time("wall" | "gpu") => continue,
                Metric::Time(_) => row.section.compared_to(),
                _ => &[],
            };
            for column in [None].into_iter().chain(to.iter().copied().map(Some)).map(|to| (*metric, to)) {
                if !columns.contains(&column) {
                    columns.push(column);
                }
            }
        }
    }
    let mut table = Table::new(["Scene: method"]);
    table.head.extend(columns.iter().map(|column| match column {
        (_, Some(to)) => format!("÷ {to}"),
        (Metric::Time(name) | Metric::Stage(name), None) => format!("{}, ms", name.replace('_', " ")),
        (Metric::Count(name), None) => name.replace(['-', '_'], " "),
    }));
    for row in rows {
        let scene = if row.section == Section::Shadows { row.group.clone() } else { lights_text(row.lights()) };
        for entry in &row.entries {
            let cell = |(metric, to): &(Metric, Option<&str>)| match (metric, to, entry.values(*metric)) {
                (_, Some(to), _) => or_dash(row.ratio(*metric, &entry.variant.id, to).map(|ratio| ratio.median)),
                (Metric::Count(_), None, [one]) => grouped(*one as usize),
                (_, None, values) => {
                    let mean = values.iter().sum::<f64>() / values.len() as f64;
                    or_dash(if let Metric::Count(_) = metric { Some(mean) } else { entry.median(*metric) })
                }
            };
            let first = format!("{}, {scene}: {}", row.title, entry.variant.name);
            table.rows.push([first].into_iter().chain(columns.iter().map(cell)).collect());
        }
    }
    let lead = "Medians, and medians of each round's ratio: time ÷ time of the method after the sign, smaller is better. \
                Counts of frames are their mean. A dash: not measured, or the device cannot tell.";
    Figure::new(id, "All that was measured", lead, None, table)
}

/// A time against a fact of the rows: a curve a variant that has it, and a row of the table.
fn over(
    [title, of_time]: [&str; 2],
    fact: &str,
    rows: &[&Row],
    metric: Metric,
    shown: impl Fn(&Entry) -> bool,
) -> (Chart, Table) {
    let mut rows = rows.to_vec();
    rows.sort_by(|a, b| a.number(fact).total_cmp(&b.number(fact)));
    let mut table = Table::new(["Method"]);
    table.head.extend(rows.iter().map(|row| format!("{} {fact}", grouped(row.number(fact) as usize))));
    let mut series = Vec::new();
    for entry in variants(&rows, |entry| entry.summary(metric).is_some()) {
        let Variant { id, name, mark } = &entry.variant;
        let ms = |row: &&Row| {
            row.summary(id, metric).map_or_else(|| "–".to_owned(), |of| format!("{} ms", three_digits(of.median)))
        };
        table.rows.push([name.clone()].into_iter().chain(rows.iter().map(ms)).collect());
        if shown(entry) {
            let point = |row: &&Row| {
                let Summary { median, quartiles, .. } = row.summary(id, metric)?;
                Some(Point { x: row.number(fact), y: median, quartiles })
            };
            series.push(Series { name: name.clone(), mark: *mark, points: rows.iter().filter_map(point).collect() });
        }
    }
    (plane([title, of_time], series, Scale::Log, tick, None), table)
}

/// The variants of all rows that are chosen, each once.
fn variants<'a>(rows: &[&'a Row], chosen: impl Fn(&Entry) -> bool) -> Vec<&'a Entry> {
    let mut all: Vec<&Entry> = Vec::new();
    for entry in rows.iter().flat_map(|row| &row.entries).filter(|entry| chosen(entry)) {
        if !all.iter().any(|known| known.variant.id == entry.variant.id) {
            all.push(entry);
        }
    }
    all
}

/// Curves over a logarithmic axis.
fn plane(
    [across, up]: [&str; 2],
    series: Vec<Series>,
    scale: Scale,
    format: fn(f64) -> String,
    level: Option<f64>,
) -> Chart {
    let points = || series.iter().flat_map(|series| &series.points);
    let ends = points().flat_map(|point| [point.y, point.quartiles[0], point.quartiles[1]]).chain(level);
    let y = Axis::over(up, scale, format, ends);
    let axis = Axis::over(across, Scale::Log, tick, points().map(|point| point.x));
    Chart { axis, series, body: Body::Plane { y, is_joined: true }, level }
}

/// Each class in the order of the scenes, with what makes it hard.
const CLASSES: [(&str, &str); 12] = [
    (OF_USER, "Your own model."),
    (ORDINARY, "Smooth closed meshes (tori), lights all around. Nothing is hard here."),
    (
        "translation",
        "A body far from the origin; the number is how far. Products of coordinates are rounded coarsely there.",
    ),
    ("scale", "A very small or very large body; the number is its size. Products underflow or overflow in f32."),
    (
        "subnormal",
        "A body, or only its thickness, of subnormal floats, which have few bits and which GPUs may take as zero.",
    ),
    ("slivers", "Long thin triangles; the number is the longest edge divided by the height above it."),
    ("plate", "Flat plates with lights in the plane of their faces: a third of the lights, or all."),
    ("lights", "Lights at hard points: inside the body, on a vertex, on an edge, on a face, in the plane of a face."),
    ("afar", "A sphere far from its lights, which are near the origin; the number is the distance."),
    ("bent", "A limb that is bent until it folds into itself; the number is the angle in degrees."),
    (
        "noise",
        "A plate with lights in its plane, whose vertices are moved off it at random; the number is by how much.",
    ),
    ("topology", "Faces without area, boxes that touch, a Möbius strip, three faces on an edge."),
];

fn extraction(rows: &[&Row]) -> Part {
    let lights = usual_lights(rows);
    let usual: Vec<&Row> = rows.iter().filter(|row| row.lights() == lights).copied().collect();
    let mut figures = vec![classes(rows), time_against_error(&usual, lights)];
    figures.extend(speed_against_2003(rows));
    figures.push(measured("extraction", rows));
    Part {
        title: "Extraction".to_owned(),
        lead: "Times are of facing and silhouettes from new positions: on the GPU to lists of silhouette edges in its memory, \
               on the CPU to a mask an edge. All methods of a mesh ran in turn, round by round, and ratios are medians of each \
               round's ratio."
            .to_owned(),
        figures,
    }
}

/// The number of lights that charts are about which show one: eight where they were measured.
pub(crate) fn usual_lights(rows: &[&Row]) -> usize {
    let has_eight = rows.iter().any(|row| row.lights() == 8);
    if has_eight { 8 } else { rows.first().map_or(8, |row| row.lights()) }
}

fn classes(rows: &[&Row]) -> Figure {
    let mut table = Table { is_prose: true, ..Table::new(["Class", "What makes it hard", "Scenes measured"]) };
    for (class, what) in CLASSES {
        let mut names: Vec<&str> = Vec::new();
        for row in rows.iter().filter(|row| row.group == class) {
            if !names.contains(&&*row.title) {
                names.push(&row.title);
            }
        }
        if !names.is_empty() {
            table.rows.push(vec![class.to_owned(), what.to_owned(), names.join("; ")]);
        }
    }
    let lead = "Charts and tables name scenes by these classes. Numbers in a scene's name say how hard it is.";
    Figure::new("classes", "Classes of scenes", lead, None, table)
}

/// One point a method and class of scenes.
fn time_against_error(rows: &[&Row], lights: usize) -> Figure {
    let head =
        ["Method, scenes", "ns a face and light", "wrong in a million", "wrong silhouette bits", "open vertices"];
    let mut table = Table::new(head);
    let mut series = Vec::new();
    // One thread finds the same again, and the plain loop finds what its CPU reference does.
    let is_distinct = |entry: &Entry| !entry.variant.id.ends_with("-one") && entry.variant.id != "cpu-plain-all";
    for Entry { variant, .. } in variants(rows, is_distinct) {
        let mut points = Vec::new();
        for (class, _) in CLASSES {
            let of_class = rows.iter().filter(|row| row.group == class);
            let (mut logs, mut count, [mut wrong, mut bits, mut open]) = (0.0, 0, [0.0; 3]);
            for (row, entry) in of_class.filter_map(|row| Some((row, row.entry(&variant.id)?))) {
                logs += (entry.ms("time") * 1e6 / (row.faces() * row.lights()) as f64).ln();
                wrong += entry.count("wrong_silhouette_bits");
                open += entry.count("unclosed_vertices");
                bits += row.number("silhouette_bits");
                count += 1;
            }
            if count == 0 {
                continue;
            }
            // The geometric mean over scenes.
            let (ns, in_a_million) = ((logs / f64::from(count)).exp(), wrong / bits.max(1.0) * 1e6);
            points.push(Point { x: ns, y: in_a_million, quartiles: [in_a_million; 2] });
            let [wrong, open] = [wrong, open].map(|count| grouped(count as usize));
            let name = format!("{}: {class}", variant.name);
            table.rows.push(vec![name, three_digits(ns), three_digits(in_a_million), wrong, open]);
        }
        series.push(Series { name: variant.name.clone(), mark: variant.mark, points });
    }
    let axes = ["nanoseconds a face and light (left is faster)", "wrong silhouette bits in a million"];
    let mut chart = plane(axes, series, Scale::Log, tick, None);
    if let Body::Plane { is_joined, .. } = &mut chart.body {
        *is_joined = false;
    }
    let title = format!("Run time against error, {}", lights_text(lights));
    let lead = "One mark for each method and class of scenes. The higher, the more silhouette bits are wrong; at the foot, none \
                is. Filled marks are the GPU's, hollow ones the CPU's. Face masks and the CPU have one colour for an arithmetic.";
    Figure::new("time_against_error", title, lead, Some(chart), table)
}

/// How many times faster than the 2003 method the exact one is, a curve a number of lights.
fn speed_against_2003(rows: &[&Row]) -> Option<Figure> {
    let time = Metric::Time("time");
    let lights: BTreeSet<usize> = rows.iter().map(|row| row.lights()).collect();
    let mut series = Vec::new();
    let mut table = Table::new(["Lights, faces", "face masks, f32", "face masks, exact", "quartiles", "exact ÷ f32"]);
    for (index, lights) in lights.into_iter().enumerate() {
        let mut points = Vec::new();
        for row in rows.iter().filter(|row| row.group == ORDINARY && row.lights() == lights) {
            let ratio = |of, to| row.ratio(time, of, to);
            let Some(Summary { median, quartiles, .. }) = ratio(PER_EDGE, GPU_EXACT) else { continue };
            points.push(Point { x: row.number("faces"), y: median, quartiles });
            let [low, high] = quartiles;
            let [fast, cost] =
                [ratio(PER_EDGE, GPU_FAST), ratio(GPU_EXACT, GPU_FAST)].map(|ratio| or_dash(ratio.map(|of| of.median)));
            let name = format!("{}, {} faces", lights_text(lights), grouped(row.faces()));
            table.rows.push(vec![name, fast, three_digits(median), format!("{low:.2} to {high:.2}"), cost]);
        }
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let mark = Mark { colour: [3, 4, 0, 5, 6][index % 5], shape: index, hollow: false };
        series.push(Series { name: lights_text(lights), mark, points });
    }
    series.retain(|series| series.points.len() > 1);
    let axes = ["faces of the mesh", "time of the 2003 method ÷ time of Rimline, exact"];
    let lead = "Time of the 2003 method ÷ time of Rimline's, so larger is better: above the dashed line Rimline's exact \
                extraction is the faster one. Medians of each round's ratio. In the table's last column, what exactness \
                costs, smaller is better.";
    (!series.is_empty()).then(|| {
        let chart = plane(axes, series, Scale::Linear, times, Some(1.0));
        let title = "Exact face masks against the per-edge method of 2003, same GPU";
        Figure::new("speed_against_2003", title, lead, Some(chart), table)
    })
}

fn shadows(rows: &[&Row]) -> Part {
    let [size, frames] = ["size", "frames"].map(|fact| rows[0].number(fact));
    Part {
        title: "Shadow volumes".to_owned(),
        lead: format!(
            "One caster in the middle of a closed room, one point light, {size} × {size} pixels, paths of {frames} cameras, \
             after Hornus and others, ZP+: correct z-pass stencil shadows (2005). The stencil pass counts volumes; the whole \
             frame also extracts silhouettes, chooses, and draws depth and light. All methods of a path ran in turn, round \
             by round. Wrong, in about four frames of a path, is a pixel that is lit or shadowed otherwise than by rays in \
             double precision, more than a pixel from the shadow's edge. Where the camera stands in the shadow z-pass is \
             wrong nearly everywhere. The one pixel in a few frames that is wrong by every method has an edge within the \
             rasteriser's grid of its centre (docs/numerics/rasterisers.md, Hairlines)."
        ),
        figures: vec![stencil_passes(rows), measured("shadows", rows)],
    }
}

/// The mean over rows of the medians of a ratio, and their range. `None` if no row has it.
pub(crate) fn mean_ratio(rows: &[&Row], metric: Metric, id: &str, to: &str) -> Option<(f64, [f64; 2])> {
    let medians: Vec<f64> = rows.iter().filter_map(|row| Some(row.ratio(metric, id, to)?.median)).collect();
    let range = Summary::of(medians.iter().copied())?.range;
    Some((medians.iter().sum::<f64>() / medians.len() as f64, range))
}

/// Time ÷ time of z-pass, a line of dots a model and path, and their means.
fn stencil_passes(rows: &[&Row]) -> Figure {
    let methods: Vec<&Variant> =
        rows[0].entries.iter().map(|entry| &entry.variant).filter(|variant| variant.id != Z_PASS).collect();
    let mut table = Table::new(["Model, path"]);
    table.head.extend(methods.iter().map(|method| method.name.clone()));
    let (mut bars, mut group) = (Vec::new(), "");
    let time = Metric::Time("stencil");
    let heading = |name: &str| Bar { name: name.to_owned(), ..Bar::default() };
    for row in rows {
        if row.group != group {
            group = &row.group;
            bars.push(heading(group));
        }
        let found: Vec<_> = methods.iter().map(|of| row.ratio(time, &of.id, Z_PASS)).collect();
        let cells = found.iter().map(|ratio| or_dash(ratio.map(|ratio| ratio.median)));
        table.rows.push([format!("{group}: {}", row.title)].into_iter().chain(cells).collect());
        let values = found.iter().map(|ratio| ratio.map(|ratio| (ratio.median, ratio.quartiles))).collect();
        bars.push(Bar { name: row.title.clone(), values, ..Bar::default() });
    }
    let means: Vec<_> = methods.iter().map(|of| mean_ratio(rows, time, &of.id, Z_PASS)).collect();
    let cells = means.iter().map(|mean| match mean {
        Some((mean, [low, high])) => format!("{} ({low:.2} to {high:.2})", three_digits(*mean)),
        None => or_dash(None),
    });
    table.rows.push(["mean".to_owned()].into_iter().chain(cells).collect());
    let values = means.iter().map(|mean| mean.map(|(mean, _)| (mean, [mean; 2]))).collect();
    bars.extend([heading("all"), Bar { name: "mean".to_owned(), values, ..Bar::default() }]);
    let ends = bars.iter().flat_map(|bar| bar.values.iter().flatten());
    let ends = ends.flat_map(|(median, [low, high])| [*median, *low, *high]).chain([0.9, 2.0]);
    let axis = Axis::over("time of the stencil pass ÷ time with z-pass", Scale::Log, times, ends);
    let key = |of: &&Variant| Series { name: of.name.clone(), mark: of.mark, points: Vec::new() };
    let (series, body) = (methods.iter().map(key).collect(), Body::Rows { rows: bars, is_stacked: false });
    let lead = "Time of the stencil pass over the path ÷ the same with z-pass, in the same run; on the dashed line it costs what \
                z-pass costs, which is wrong where the camera stands in a shadow. The last line is the mean of those above.";
    let chart = Chart { axis, series, body, level: Some(1.0) };
    Figure::new("shadow_stencil", "Cost of counting: the stencil pass against z-pass", lead, Some(chart), table)
}

fn casters(rows: &[&Row]) -> Part {
    let (size, lights) = (rows[0].number("size"), rows[0].lights());
    let wrong: f64 = rows.iter().map(|row| row.number("wrong_lights")).sum();
    // The chart has the boxes, or the figures where there are no boxes. More curves would overlap.
    let is_box = rows.iter().any(|row| row.scene == "box");
    let scene = if is_box { "box" } else { "figure" };
    let shown: Vec<&Row> = rows.iter().filter(|row| row.scene == scene).copied().collect();
    let is_shown = |entry: &Entry| !["scene-light-moved", "scene-new-caster"].contains(&&*entry.variant.id);
    let axes = ["casters", "CPU milliseconds of recording a frame"];
    let (chart, table) = over(axes, "casters", &shown, Metric::Time("recording"), is_shown);
    let lead = "CPU time of moving what moves, of recording all stages and of finishing the command buffer, without its \
                submission. Medians; all methods of a scene ran in turn. Beside a scene of all casters stands \
                a scene for each caster.";
    let title = format!("Recording a frame against the number of casters, {lights} lights, one view");
    Part {
        title: "Scenes of many casters".to_owned(),
        lead: format!(
            "Boxes of 12 faces and figures of 4,000, rigid, in a cube; {lights} point lights above it, and a camera before \
             it that sees about half of it, {size} × {size} pixels. The number of silhouette edges of each light is \
             compared with that of the same faces merged into one mesh: of {} pairs of scene and light, {} differ. A scene of \
             one mesh is compared with an extractor that finds the same, without the clusters that scenes have of large \
             meshes. Stages are timed on a device of their own, on which nothing is drawn; \
             stencil passes are those of all lights, over depths without any surface; the frame is all of them, on software \
             devices by the clock. Bytes are of buffers; those of the device are all that it allocated.",
            grouped(rows.len() * lights),
            grouped(wrong as usize)
        ),
        figures: vec![Figure::new("casters_recording", title, lead, Some(chart), table), measured("casters", rows)],
    }
}

/// A colour of the chart: what is done in some stages, in the order of the frame.
const WORKS: [(&str, usize, &[&str]); 8] = [
    ("deforming", 0, &["deform"]),
    ("what is needed", 6, &["needs", "cull_lights", "clusters", "chunks"]),
    ("facing", 3, &["facing", "exact_facing"]),
    ("edges", 1, &["edges", "arguments"]),
    ("choices", 5, &["receiver_depth", "receiver_pyramid", "relist", "bounds", "counting_methods"]),
    ("caps and sides", 4, &["caps", "list_sides", "shadow_arguments"]),
    ("other stages", 7, &[]),
    ("stencil passes", 2, &[]),
];

fn skipping(rows: &[&Row]) -> Part {
    let size = rows[0].number("size");
    Part {
        title: "Where a frame's work goes, and what is skipped".to_owned(),
        lead: format!(
            "Each scene with all levels of skipping off, with all on, and with each level off while the others are on, \
             {size} × {size} pixels. All choices ran in turn, round by round. In the scene still nothing moves among \
             figures of 4,000 faces. In the city a sun lights buildings of 12 to 92 faces, and the eye is in a street. In the \
             crowd skinned figures walk, and each of the lamps reaches few of them; the eye is above them, and within. The \
             ground receives and does not cast. Depths are drawn in whole frames alone, so the times of stages are those of \
             frames that know no receivers. The whole frame is by the clock, from the submission on: deforming, all compute \
             stages, and the stencil passes of all lights; where it takes much longer than these, the machine was busy. \
             Recording is CPU time. Counters are of the third frame; fragments are the pixels that volumes cover, each time."
        ),
        figures: vec![work(rows), measured("skipping", rows)],
    }
}

/// Each scene's bars against its bar with all levels off.
fn work(rows: &[&Row]) -> Figure {
    let mut table = Table::new(["Scene and levels"]);
    table.head.extend(WORKS.iter().map(|(name, ..)| format!("{name}, ms")));
    table.head.push("together, ms".to_owned());
    let (mut bars, mut longest) = (Vec::new(), Vec::new());
    for row in rows {
        bars.push(Bar { name: row.title.clone(), ..Bar::default() });
        let mut unit = None;
        for entry in &row.entries {
            let amounts = amounts(entry);
            let sum: f64 = amounts.iter().sum();
            // A hundredth of the time with all levels off.
            let unit = *unit.get_or_insert((sum / 100.0).max(1e-9));
            longest.push(sum / unit);
            let name = &entry.variant.name;
            let cells = amounts.iter().chain([&sum]).map(|ms| three_digits(*ms));
            table.rows.push([format!("{}: {name}", row.title)].into_iter().chain(cells).collect());
            let values = amounts.iter().map(|ms| Some((ms / unit, [ms / unit; 2]))).collect();
            bars.push(Bar { name: name.clone(), values, remark: format!("{} ms", three_digits(sum)) });
        }
    }
    // A legend of what no bar has would be a riddle.
    let length = |bar: &Bar, key: usize| bar.values.get(key).copied().flatten().map_or(0.0, |(length, _)| length);
    let shown: Vec<usize> = (0..WORKS.len()).filter(|&key| bars.iter().any(|bar| length(bar, key) > 0.0)).collect();
    for bar in bars.iter_mut().filter(|bar| !bar.values.is_empty()) {
        bar.values = shown.iter().map(|&key| bar.values[key]).collect();
    }
    let key = |&key: &usize| {
        let (name, colour, _) = WORKS[key];
        let mark = Mark { colour, shape: 1, hollow: false };
        Series { name: name.to_owned(), mark, points: Vec::new() }
    };
    let axis = Axis::over("GPU time, percent of all levels off", Scale::Linear, tick, longest);
    let (series, body) = (shown.iter().map(key).collect(), Body::Rows { rows: bars, is_stacked: true });
    let lead = "Medians of the compute stages and of the stencil passes. A scene's bar with all levels off is 100; the numbers \
                after bars are milliseconds. Stages are timed on a device of their own, on which nothing is drawn.";
    let chart = Chart { axis, series, body, level: None };
    Figure::new("skipping_work", "Where a frame's work goes", lead, Some(chart), table)
}

/// Milliseconds of the work of each colour.
fn amounts(entry: &Entry) -> Vec<f64> {
    let mut amounts = vec![0.0; WORKS.len()];
    for (metric, _) in &entry.metrics {
        let Metric::Stage(stage) = metric else { continue };
        let work = WORKS.iter().position(|(.., stages)| stages.contains(stage)).unwrap_or(WORKS.len() - 2);
        amounts[work] += entry.median(*metric).unwrap_or(0.0);
    }
    amounts[WORKS.len() - 1] = entry.median(Metric::Time("stencil")).unwrap_or(0.0);
    amounts
}

/// Casters without a mesh.
fn depth_maps(rows: &[&Row]) -> Part {
    let figure = |id, title, lead, of_time, metric| {
        let is_shown = |entry: &Entry| !entry.variant.name.contains("not counted");
        let (chart, table) = over(["faces of the caster", of_time], "faces", rows, metric, is_shown);
        Figure::new(id, title, lead, Some(chart), table)
    };
    let (size, device) = (rows[0].number("size"), &rows[0].group);
    Part {
        title: "Depth maps against meshes".to_owned(),
        lead: format!(
            "A sphere over a ground, picture and map of {size} × {size}, by `cargo bench --bench depth_maps -- casters` on \
             {device}: shadows by the volumes of the mesh, by volumes rebuilt from a depth map, and by a lookup in that map."
        ),
        figures: vec![
            figure(
                "depth_maps_against_meshes",
                "A frame's shadows against the faces of the caster",
                "Medians and quartiles; all methods ran in turn. Of a mesh: extraction, volumes, stencil and darkening. Of a \
                 map: drawing it, detection, volumes, stencil and darkening. Of a lookup: drawing the map, and looking every \
                 pixel up. The eye's own depth is not counted.",
                "milliseconds of a frame's shadows",
                crate::depth_maps::FRAME,
            ),
            figure(
                "depth_maps_stencil_passes",
                "The stencil pass alone against the faces of the caster",
                "The same frames' draws into the stencil, once more by themselves.",
                "milliseconds of the stencil pass",
                crate::depth_maps::STENCIL,
            ),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_class_is_explained_in_the_order_of_the_scenes() {
        let mut there = vec![OF_USER, ORDINARY];
        there.extend(crate::stress::scenes(1).map(|scene| scene.class));
        there.dedup();
        assert_eq!(CLASSES.map(|(class, _)| class).as_slice(), there);
    }

    /// A stage that has another name than here would be among the others.
    #[test]
    fn works_are_of_stages_and_extraction_is_among_them() {
        for name in WORKS.iter().flat_map(|(.., stages)| stages.iter()) {
            assert!(rimline::internals::stages::STAGES.iter().any(|stage| stage.name == *name), "{name}");
        }
        for name in crate::casters::EXTRACTION {
            assert!(WORKS.iter().any(|(.., stages)| stages.contains(&name)), "{name}");
        }
    }
}
