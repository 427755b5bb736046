//! The summary of a run: one line for each question that a person has.

use crate::engine::Metric;
use crate::extraction::{CPU_EXACT, CPU_FAST, GPU_EXACT, GPU_FAST, OF_USER, ORDINARY, PER_EDGE};
use crate::figures::{mean_ratio, usual_lights};
use crate::row::{Row, Section};
use crate::shadows::Z_PASS;
use crate::text::{grouped, lights_text, three_digits};

const TIME: Metric = Metric::Time("time");
const FRAME: Metric = Metric::Time("frame");

pub(crate) fn summary(rows: &[Row]) -> String {
    let of = |section: Section| rows.iter().filter(|row| row.section == section).collect::<Vec<_>>();
    let mut lines = Vec::new();
    let extraction = of(Section::Extraction);
    for (group, what) in [(OF_USER, "your model"), (ORDINARY, "a torus")] {
        let rows: Vec<&Row> = extraction.iter().filter(|row| row.group == group).copied().collect();
        lines.extend(speed(&rows, what));
        lines.extend(exactness(&rows, what));
    }
    let scenes: Vec<&Row> =
        extraction.iter().filter(|row| ![OF_USER, ORDINARY].contains(&row.group.as_str())).copied().collect();
    lines.extend(hard_scenes(&scenes));
    lines.extend(errors(&extraction));
    lines.extend(shadows(&of(Section::Shadows)));
    lines.extend(casters(&of(Section::Casters)));
    lines.extend(of(Section::Skipping).into_iter().map(skipping));
    lines.extend(of(Section::DepthMaps).last().map(|row| depth_maps(row)));
    let width = lines.iter().map(|(question, _)| question.chars().count()).max().unwrap_or(0);
    let line = |(question, answer): (String, String)| {
        let pad = width - question.chars().count();
        format!("{question}{:pad$}  {answer}\n", "")
    };
    lines.into_iter().map(line).collect()
}

type Line = (String, String);

fn joined(answers: impl IntoIterator<Item = Option<String>>) -> String {
    answers.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

fn ratio(row: &Row, metric: Metric, id: &str, to: &str) -> Option<String> {
    Some(times(row.ratio(metric, id, to)?.median))
}

fn times(ratio: f64) -> String {
    if ratio < 10.0 { format!("{ratio:.2}×") } else { format!("{}×", three_digits(ratio)) }
}

/// The largest mesh's rows, one a number of lights.
fn largest<'a>(rows: &[&'a Row]) -> Vec<&'a Row> {
    let faces = rows.iter().map(|row| row.faces()).max();
    rows.iter().filter(|row| Some(row.faces()) == faces).copied().collect()
}

/// How much faster than the method of 2003?
fn speed(rows: &[&Row], what: &str) -> Option<Line> {
    let rows = largest(rows);
    let answer =
        |row: &&Row| Some(format!("{} at {}", ratio(row, TIME, PER_EDGE, GPU_EXACT)?, lights_text(row.lights())));
    let answers = joined(rows.iter().map(answer));
    let faces = grouped(rows.first()?.faces());
    let question = format!("Against the method of 2003, {what} of {faces} faces: speed");
    (!answers.is_empty()).then_some((question, answers))
}

/// The price of exactness.
fn exactness(rows: &[&Row], what: &str) -> Option<Line> {
    let lights = usual_lights(rows);
    let row = largest(rows).into_iter().find(|row| row.lights() == lights)?;
    let pairs = [("GPU", GPU_EXACT, GPU_FAST), ("CPU", CPU_EXACT, CPU_FAST)];
    let answers =
        pairs.map(|(device, exact, fast)| Some(format!("{} on the {device}", ratio(row, TIME, exact, fast)?)));
    Some((format!("Price of exactness against f32, {what}, {}: time", lights_text(lights)), joined(answers)))
}

/// The same of scenes that are hard on floating-point arithmetic.
fn hard_scenes(rows: &[&Row]) -> Option<Line> {
    let lights = usual_lights(rows);
    let costs = rows.iter().filter(|row| row.lights() == lights).filter_map(|row| {
        let gpu = row.ratio(TIME, GPU_EXACT, GPU_FAST).or_else(|| row.ratio(TIME, CPU_EXACT, CPU_FAST));
        Some((gpu?.median, &row.title))
    });
    let mut costs: Vec<_> = costs.collect();
    costs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (middle, (worst, name)) = (costs.get(costs.len() / 2)?.0, costs.last()?);
    let question = format!("Price of exactness, {} scenes hard on floats: time", costs.len());
    Some((question, format!("{} in the middle, up to {} ({name})", times(middle), times(*worst))))
}

/// How many bits are wrong of the meshes that the GPU took, or of all if it took none?
fn errors(rows: &[&Row]) -> Option<Line> {
    let on_gpu: Vec<&Row> = rows.iter().copied().filter(|row| row.entry(GPU_EXACT).is_some()).collect();
    let rows: &[&Row] = if on_gpu.is_empty() { rows } else { &on_gpu };
    let bits: f64 = rows.iter().map(|row| row.number("silhouette_bits")).sum();
    let wrong = |id: &str| {
        let entries: Vec<_> = rows.iter().filter_map(|row| row.entry(id)).collect();
        let sum = entries.iter().map(|entry| entry.count("wrong_silhouette_bits")).sum::<f64>();
        (!entries.is_empty()).then(|| grouped(sum as usize))
    };
    // The CPU's bits where the GPU did not run.
    let methods = [("2003", PER_EDGE, PER_EDGE), ("f32", GPU_FAST, CPU_FAST), ("exact", GPU_EXACT, CPU_EXACT)];
    let answers = methods.map(|(name, gpu, cpu)| Some(format!("{} by {name}", wrong(gpu).or_else(|| wrong(cpu))?)));
    (bits > 0.0).then(|| (format!("Wrong silhouette bits, of {}", grouped(bits as usize)), joined(answers)))
}

/// The price of right shadows.
fn shadows(rows: &[&Row]) -> Vec<Line> {
    let mean = |metric, id| mean_ratio(rows, metric, id, Z_PASS).map_or(f64::NAN, |(mean, _)| mean);
    if rows.is_empty() {
        return Vec::new();
    }
    let methods = [("auto", "auto"), ("z-fail", "z-fail"), ("zp+paper", "ZP+ of 2005")];
    let costs = |metric: Metric| methods.map(|(id, name)| format!("{name} {}", times(mean(metric, id)))).join(", ");
    let wrong = |id: &str| {
        let entries = rows.iter().filter_map(|row| row.entry(id));
        let (sum, frames) = entries.fold((0.0, 0), |(sum, frames), entry| {
            (sum + entry.count("wrong_pixels"), frames + entry.values(Metric::Count("wrong_pixels")).len())
        });
        three_digits(sum / frames.max(1) as f64)
    };
    let wrong =
        [("z-pass", Z_PASS), ("auto", "auto"), ("z-fail", "z-fail")].map(|(name, id)| format!("{name} {}", wrong(id)));
    vec![
        ("Shadows against z-pass, stencil pass: time".to_owned(), costs(Metric::Time("stencil"))),
        ("Shadows against z-pass, whole frame: time".to_owned(), costs(FRAME)),
        ("Shadows, wrong pixels a frame".to_owned(), wrong.join(", ")),
    ]
}

/// How many casters fit a frame?
fn casters(rows: &[&Row]) -> Vec<Line> {
    let recording = Metric::Time("recording");
    let mut lines = Vec::new();
    for scene in ["box", "figure"] {
        let of = rows.iter().filter(|row| row.scene == scene);
        let Some(row) = of.max_by(|a, b| a.number("casters").total_cmp(&b.number("casters"))) else { continue };
        let title = &row.title;
        let ms = |id: &str| Some(three_digits(row.summary(id, recording)?.median));
        let answers =
            [("nothing moved", "scene-still"), ("all moved", "scene-all-moved"), ("a scene a caster", "extractors")]
                .map(|(name, id)| Some(format!("{} ms {name}", ms(id)?)));
        lines.push((format!("Recording a frame of {title}: CPU time"), joined(answers)));
        let answers = [("extraction", Metric::Time("extraction")), ("frame", FRAME)]
            .map(|(name, metric)| Some(format!("{name} {}", ratio(row, metric, "scene", "merged")?)));
        lines.push((format!("Scene of {title} against one merged mesh: GPU time"), joined(answers)));
    }
    lines
}

/// The savings by skipping.
fn skipping(row: &Row) -> Line {
    let answers = [("stages", Metric::Time("compute")), ("frame", FRAME)]
        .map(|(name, metric)| Some(format!("{name} {}", ratio(row, metric, "all-off", "all-on")?)));
    (format!("Without skipping, {}: time", row.title), joined(answers))
}

fn depth_maps(row: &Row) -> Line {
    let counted = row.entries.iter().filter(|entry| !entry.variant.name.contains("not counted"));
    let answers =
        counted.map(|entry| Some(format!("{} ms {}", three_digits(entry.median(FRAME)?), entry.variant.name)));
    (format!("Shadows of a sphere of {}", row.title), joined(answers))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::row::{Entry, Variant};

    fn entry(id: &str, ms: f64) -> Entry {
        let entry = Entry::new(Variant::new(id, id, 0, 0), &[]);
        entry.with(TIME, [ms; 3]).with_count("wrong_silhouette_bits", ms as usize)
    }

    fn row(faces: usize, entries: Vec<Entry>) -> Row {
        Row {
            section: Section::Extraction,
            scene: "torus".to_owned(),
            title: "torus".to_owned(),
            group: ORDINARY.to_owned(),
            facts: vec![("faces", json!(faces)), ("lights", json!(8)), ("silhouette_bits", json!(12 * faces))],
            entries,
        }
    }

    #[test]
    fn speed_is_larger_where_the_method_is_faster_and_exactness_costs_what_f32_spares() {
        let text = summary(&[row(4, vec![entry(PER_EDGE, 6.0), entry(GPU_FAST, 2.0), entry(GPU_EXACT, 3.0)])]);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].contains(": speed ") && lines[0].ends_with(" 2.00× at 8 lights"), "{text}");
        assert!(lines[1].ends_with("1.50× on the GPU"), "{text}");
        assert!(lines[2].ends_with("6 by 2003, 2 by f32, 3 by exact"), "{text}");
    }

    #[test]
    fn a_hard_scene_counts_once() {
        let hard = |lights: usize, ms: f64| Row {
            group: "plate".to_owned(),
            facts: vec![("faces", json!(4)), ("lights", json!(lights))],
            ..row(4, vec![entry(GPU_FAST, 2.0), entry(GPU_EXACT, ms)])
        };
        let text = summary(&[hard(1, 9.0), hard(8, 3.0), hard(32, 9.0)]);
        assert!(text.contains("exactness, 1 scenes") && text.contains("1.50× in the middle, up to 1.50×"), "{text}");
    }

    #[test]
    fn wrong_bits_are_all_of_the_same_meshes() {
        let [on_gpu, on_cpu] = [(4, [PER_EDGE, GPU_EXACT, CPU_FAST]), (1000, [CPU_FAST, CPU_EXACT, CPU_EXACT])]
            .map(|(faces, ids)| row(faces, ids.map(|id| entry(id, 7.0)).into()));
        let last = |rows: &[Row]| summary(rows).lines().last().map(str::to_owned).unwrap_or_default();
        let text = last(&[on_gpu, on_cpu.clone()]);
        assert!(text.contains(", of 48 ") && text.ends_with(" 7 by 2003, 7 by f32, 7 by exact"), "{text}");
        let text = last(&[on_cpu]);
        assert!(text.contains(", of 12,000 ") && text.ends_with(" 7 by f32, 7 by exact"), "{text}");
    }
}
