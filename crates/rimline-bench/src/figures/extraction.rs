//! The report's section on extraction.

use std::collections::BTreeSet;

use super::{Parts, Quotient, cloud, curves, ms, over, ratio_cells, ratios, variants};
use crate::chart::{Point, Scale, Series};
use crate::engine::{Metric, Summary};
use crate::extraction::method::{CPU_EXACT, CPU_FAST, GPU_EXACT, GPU_FAST, PER_EDGE};
use crate::extraction::subject::{OF_USER, ORDINARY};
use crate::page::{Figure, Section as Part, Table};
use crate::row::{Entry, Mark, Row};
use crate::text::{grouped, lights_text, three_digits, times};

pub(super) const TIME: Metric = Metric::Time("time");

/// Each class in the order of the scenes, with what makes it hard.
const CLASSES: [(&str, &str); 12] = [
    (OF_USER, "Your own model."),
    (ORDINARY, "Smooth closed meshes (tori), lights all around. Nothing is hard here."),
    (
        "translation",
        "A body far from the origin; the number is how far. Neighbouring floats lie far apart there, so products of \
         coordinates are rounded coarsely.",
    ),
    ("scale", "A very small or very large body; the number is its size. Products underflow or overflow in f32."),
    (
        "subnormal",
        "A body, or only its thickness, so small that its coordinates are subnormal floats, which have few bits and \
         which GPUs may take as zero.",
    ),
    ("slivers", "Long thin triangles; the number is the longest edge divided by the height above it."),
    (
        "plate",
        "Flat plates with lights in the plane of their faces: a third of the lights, or all. Only exact arithmetic \
         says on which side such a light is.",
    ),
    ("lights", "Lights in hard places: inside the body, on a vertex, on an edge, on a face, in the plane of a face."),
    (
        "afar",
        "A sphere far from its lights, which are near the origin; the number is the distance. Its coordinates have few \
         bits left for its own shape.",
    ),
    ("bent", "A limb that is bent until it folds into itself; the number is the angle in degrees."),
    (
        "noise",
        "A plate with lights in its plane, whose vertices are moved off it at random; the number is by how much. Every \
         face is nearly edge on, each otherwise.",
    ),
    (
        "topology",
        "Meshes that a modelling program should not have let through: faces without area, boxes that touch, a Möbius \
         strip, three faces on an edge.",
    ),
];

pub(super) fn section(rows: &[&Row]) -> Part {
    let lights = usual_lights(rows);
    let usual: Vec<&Row> = rows.iter().filter(|row| row.lights() == lights).copied().collect();
    let mut figures = vec![classes(rows), time_against_error(&usual, lights), errors(rows)];
    figures.extend(time_against_size(&ordinary(&usual), lights));
    figures.extend(speed_against_2003(rows));
    figures.extend(time_against_lights(rows));
    figures.extend(stages(&usual, lights));
    figures.push(cost_of_exactness(&usual, lights));
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

/// Rows of smooth closed meshes, smaller ones first.
fn ordinary<'a>(rows: &[&'a Row]) -> Vec<&'a Row> {
    let mut rows: Vec<&Row> = rows.iter().filter(|row| row.group == ORDINARY).copied().collect();
    rows.sort_by_key(|row| row.faces());
    rows
}

/// The methods whose bits may differ: one thread finds the same again, and the plain loop what its CPU reference does.
fn is_distinct(entry: &Entry) -> bool {
    !entry.variant.id.ends_with("-one") && entry.variant.id != "cpu-plain-all"
}

fn classes(rows: &[&Row]) -> Figure {
    let mut found = Table { is_prose: true, ..Table::new(["Class", "What makes it hard", "Scenes measured"]) };
    for (class, what) in CLASSES {
        let mut names: Vec<String> = Vec::new();
        for row in rows.iter().filter(|row| row.group == class) {
            let name = if class == ORDINARY { format!("{} faces", grouped(row.faces())) } else { row.title.clone() };
            if !names.contains(&name) {
                names.push(name);
            }
        }
        if !names.is_empty() {
            found.rows.push(vec![class.to_owned(), what.to_owned(), names.join("; ")]);
        }
    }
    let lead = "Charts and tables name scenes by these classes. Numbers in a scene's name say how hard it is.";
    Figure::new("classes", "Classes of scenes", lead, None, found)
}

/// One point a method and class of scenes.
fn time_against_error(rows: &[&Row], lights: usize) -> Figure {
    let mut found = Table::new([
        "Method, scenes",
        "ns a face and light",
        "wrong in a million",
        "wrong silhouette bits",
        "open vertices",
    ]);
    let mut series = Vec::new();
    for Entry { variant, .. } in variants(rows, is_distinct) {
        let mut points = Vec::new();
        for (class, _) in CLASSES {
            let of_class = rows.iter().filter(|row| row.group == class);
            let (mut logs, mut count, [mut wrong, mut bits, mut open]) = (0.0, 0, [0.0; 3]);
            for (row, entry) in of_class.filter_map(|row| Some((row, row.entry(&variant.id)?))) {
                let ms = entry.median(TIME).unwrap_or(f64::NAN);
                logs += (ms * 1e6 / (row.faces() * row.lights()) as f64).ln();
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
            found.rows.push(vec![name, three_digits(ns), three_digits(in_a_million), wrong, open]);
        }
        series.push(Series { name: variant.name.clone(), mark: variant.mark, points });
    }
    let axes = ["nanoseconds a face and light (left is faster)", "wrong silhouette bits in a million"];
    let title = format!("Run time against error, {}", lights_text(lights));
    let lead = "One mark for each method and class of scenes. The higher, the more silhouette bits are wrong; at the foot, none \
                is. Colours are arithmetics; filled marks are the GPU's, hollow ones the CPU's.";
    Figure::new("time_against_error", title, lead, Some(cloud(axes, series)), found)
}

/// Every scene's errors, the methods beside each other.
fn errors(rows: &[&Row]) -> Figure {
    let mut methods = variants(rows, is_distinct);
    // A table too wide for the page shows its first columns.
    methods.sort_by_key(|entry| ![GPU_EXACT, CPU_EXACT].contains(&entry.variant.id.as_str()));
    let mut found = Table::new(["Scene, lights"]);
    found.head.extend(methods.iter().map(|entry| entry.variant.name.replace(", all threads", "")));
    let mut add = |name: String, rows: &[&Row]| {
        let cell = |method: &&Entry| {
            let entries: Vec<&Entry> = rows.iter().filter_map(|row| row.entry(&method.variant.id)).collect();
            let sums = ["wrong_facing_bits", "wrong_silhouette_bits", "unclosed_vertices"]
                .map(|name| entries.iter().map(|entry| entry.count(name)).sum::<f64>() as usize);
            match sums {
                _ if entries.is_empty() => "–".to_owned(),
                [0, 0, 0] => "0".to_owned(),
                sums => sums.map(grouped).join(" / "),
            }
        };
        found.rows.push([name].into_iter().chain(methods.iter().map(cell)).collect());
    };
    let (ordinary, scenes): (Vec<&Row>, Vec<&Row>) = rows.iter().partition(|row| row.group == ORDINARY);
    if !ordinary.is_empty() {
        add("closed meshes, all lights".to_owned(), &ordinary);
    }
    for row in scenes {
        add(format!("{}, {}", row.title, lights_text(row.lights())), &[row]);
    }
    let lead = "Wrong facing bits / wrong silhouette bits / open vertices; one 0 where there is none of them.";
    Figure::new("errors", "Errors by scene", lead, None, found)
}

/// The curves; more would lie on top of each other.
const SHOWN: [&str; 6] = [PER_EDGE, GPU_FAST, GPU_EXACT, "cpu-exact-one", CPU_FAST, CPU_EXACT];

/// `None` where there is but one size.
fn time_against_size(rows: &[&Row], lights: usize) -> Option<Figure> {
    let is_shown = |entry: &Entry| SHOWN.contains(&entry.variant.id.as_str());
    let (chart, mut table) = over(["faces of the mesh", "milliseconds"], "faces", rows, TIME, is_shown);
    table.head.push("slope".to_owned());
    for (entry, cells) in variants(rows, |_| true).into_iter().zip(&mut table.rows) {
        let point = |row: &&Row| Some([row.number("faces").ln(), row.summary(&entry.variant.id, TIME)?.median.ln()]);
        let slope = slope(&rows.iter().filter_map(point).collect::<Vec<_>>());
        cells.push(slope.map_or_else(String::new, |slope| format!("{slope:.2}")));
    }
    let title = format!("Run time against size, closed meshes, {}", lights_text(lights));
    let lead = "Medians and quartiles. In the table, a slope of 1 is time in proportion to the faces; below it, the fixed cost of \
                small meshes shows.";
    (rows.len() > 1).then(|| Figure::new("time_against_size", title, lead, Some(chart), table))
}

/// The slope of the line through some points, by least squares.
fn slope(points: &[[f64; 2]]) -> Option<f64> {
    let mean = |axis: usize| points.iter().map(|p| p[axis]).sum::<f64>() / points.len() as f64;
    let [x, y] = [mean(0), mean(1)];
    let above: f64 = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    let below: f64 = points.iter().map(|p| (p[0] - x) * (p[0] - x)).sum();
    (below > 0.0).then(|| above / below)
}

/// How many times faster than the 2003 method the exact one is, a curve a number of lights.
fn speed_against_2003(rows: &[&Row]) -> Option<Figure> {
    let lights: BTreeSet<usize> = rows.iter().map(|row| row.lights()).collect();
    let mut series = Vec::new();
    let mut table = Table::new(["Lights, faces", "face masks, f32", "face masks, exact", "quartiles", "exact ÷ f32"]);
    for (index, lights) in lights.into_iter().enumerate() {
        let mut points = Vec::new();
        for row in ordinary(rows).into_iter().filter(|row| row.lights() == lights) {
            let [exact, fast] = [GPU_EXACT, GPU_FAST].map(|id| row.ratio(TIME, PER_EDGE, id));
            let (Some(exact), Some(fast)) = (exact, fast) else { continue };
            let Summary { median, quartiles, .. } = exact;
            points.push(Point { x: row.number("faces"), y: median, quartiles });
            let name = format!("{}, {} faces", lights_text(lights), grouped(row.faces()));
            let cost = ratio_cells(row.ratio(TIME, GPU_EXACT, GPU_FAST))[0].clone();
            let [exact, quartiles] = ratio_cells(Some(exact));
            table.rows.push(vec![name, format!("{:.2}×", fast.median), format!("{exact}×"), quartiles, cost]);
        }
        let mark = Mark { colour: [3, 4, 0, 5, 6][index % 5], shape: index, hollow: false };
        series.push(Series { name: lights_text(lights), mark, points });
    }
    series.retain(|series| series.points.len() > 1);
    let of_y = "time of the 2003 method ÷ time of Rimline, exact";
    let lead = "Time of the 2003 method ÷ time of Rimline's, so larger is better: above the dashed line Rimline's exact \
                extraction is the faster one. Medians of each round's ratio. In the table's last column, what exactness \
                costs, smaller is better.";
    (!series.is_empty()).then(|| {
        let chart = curves("faces of the mesh", of_y, Scale::Linear, times, series, Some(1.0));
        let title = "Exact face masks against the per-edge method of 2003, same GPU";
        Figure::new("speed_against_2003", title, lead, Some(chart), table)
    })
}

/// The largest mesh with each number of lights; `None` where there is but one number.
fn time_against_lights(rows: &[&Row]) -> Option<Figure> {
    let all = ordinary(rows);
    let faces = all.last()?.faces();
    let rows: Vec<&Row> = all.into_iter().filter(|row| row.faces() == faces).collect();
    let is_shown = |entry: &Entry| !entry.variant.id.ends_with("-one") && !entry.variant.id.contains("plain-all");
    let (chart, table) = over(["lights", "milliseconds"], "lights", &rows, TIME, is_shown);
    let title = format!("Run time against lights, closed mesh of {} faces", grouped(faces));
    let lead = "A batch of 32 lights is decided and compared at once, so many lights cost less than each by itself.";
    (rows.len() > 1).then(|| Figure::new("time_against_lights", title, lead, Some(chart), table))
}

/// Stages in the order of the data flow, with colours.
const STAGES: [(&str, usize); 6] =
    [("per_edge", 0), ("facing", 3), ("exact_facing", 4), ("edges", 1), ("compact", 5), ("arguments", 7)];

/// The largest mesh's time, stage by stage; `None` where no stage was timed.
fn stages(rows: &[&Row], lights: usize) -> Option<Figure> {
    let row = ordinary(rows).pop().or_else(|| rows.last().copied())?;
    let mut parts = Parts::new(STAGES.into_iter().chain([("between stages", 6)]), "Method");
    for entry in row.entries.iter().filter(|entry| entry.stages().next().is_some()) {
        let mut amounts: Vec<f64> =
            STAGES.iter().map(|(name, _)| entry.median(Metric::Stage(name)).unwrap_or(0.0)).collect();
        let rest = entry.median(TIME).unwrap_or(0.0) - amounts.iter().sum::<f64>();
        amounts.push(rest.max(0.0));
        parts.push(["", &entry.variant.name], &amounts, 1.0);
    }
    let (chart, table) = parts.finish("milliseconds");
    let title = format!("Where the time goes: {} faces, {}", grouped(row.faces()), lights_text(lights));
    let lead =
        "Medians of each method's stages. The exact stage settles what the filter in the facing stage left open.";
    (!table.rows.is_empty()).then(|| Figure::new("stages", title, lead, Some(chart), table))
}

/// Exact ÷ fast for every mesh and scene.
fn cost_of_exactness(rows: &[&Row], lights: usize) -> Figure {
    let quotients = [
        Quotient::new("GPU", GPU_EXACT, GPU_FAST, (4, 0, false)),
        Quotient::new("CPU, all threads", CPU_EXACT, CPU_FAST, (5, 3, true)),
    ];
    let (chart, mut table) = ratios("time of the exact method ÷ time of plain f32", rows, TIME, &quotients);
    table.head.extend(["time, GPU", "pairs settled in integers"].map(str::to_owned));
    for (row, cells) in rows.iter().zip(&mut table.rows) {
        cells.extend([ms(row.summary(GPU_EXACT, TIME)), share_of_undecided(row)]);
    }
    let title = format!("What exactness costs, {}", lights_text(lights));
    let lead = "Time of exact face masks ÷ time of the same in plain f32, in the same run; on the dashed line it costs \
                nothing. Scenes that cost most have lights in the planes of many of their faces, so that integers must \
                settle them.";
    Figure::new("cost_of_exactness", title, lead, Some(chart), table)
}

/// Pairs of face and light that went to integers.
fn share_of_undecided(row: &Row) -> String {
    let entry = row.entry(GPU_EXACT).or_else(|| row.entry(CPU_EXACT));
    let pairs = (row.faces() * row.lights()) as f64;
    entry.map_or_else(String::new, |entry| match entry.count("undecided_pairs") / pairs * 100.0 {
        0.0 => "0".to_owned(),
        share if share < 0.01 => "under 0.01 %".to_owned(),
        share => format!("{} %", three_digits(share)),
    })
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

    #[test]
    fn a_power_has_its_slope() {
        let points: Vec<[f64; 2]> = [1.0, 10.0, 300.0].map(|x: f64| [x.ln(), (7.0 * x.powf(0.8)).ln()]).into();
        let found = slope(&points).expect("it has three points");
        assert!((found - 0.8).abs() < 1e-9, "{found}");
        assert_eq!(slope(&points[..1]), None);
    }
}
