//! Where the time goes.

use super::super::results::{Results, Row};
use super::super::text::{figures, grouped, tick};
use super::{lights_text, ordinary, usual_lights};
use crate::chart::{Axis, Bars, BarsKind, Chart, Group, Key, Scale, Value};
use crate::page::{Figure, Table};

/// Colour and shape of a stage's part; the rest is what lies between stages.
fn key(stage: &str) -> Key {
    let colour = match stage {
        "facing" => 3,
        "exact_facing" => 4,
        "per_edge" => 0,
        "edges" => 1,
        "arguments" => 7,
        _ => 6,
    };
    Key { name: stage.to_owned(), colour, shape: 1, hollow: false }
}

const BETWEEN: &str = "between stages";

/// The largest mesh's time, stage by stage; `None` where no stage was timed.
pub(super) fn stages(results: &Results) -> Option<Figure> {
    let lights = usual_lights(results);
    let row = ordinary(results, lights).pop().or_else(|| results.rows.last())?;
    let parts: Vec<(&'static str, Vec<(&'static str, f64)>)> = row
        .entries
        .iter()
        .filter_map(|entry| {
            let mut stages = entry.stages();
            let rest = entry.median_run()?.time_ms() - stages.iter().map(|stage| stage.1).sum::<f64>();
            stages.push((BETWEEN, rest.max(0.0)));
            (stages.len() > 1).then_some((entry.contestant.name, stages))
        })
        .collect();
    let mut names: Vec<&'static str> = Vec::new();
    for (name, _) in parts.iter().flat_map(|(_, stages)| stages) {
        if !names.contains(name) && *name != BETWEEN {
            names.push(name);
        }
    }
    if names.is_empty() {
        return None;
    }
    // In the order of the data flow, whichever method came first.
    let flow = ["per_edge", "facing", "exact_facing", "edges", "compact", "arguments"];
    names.sort_by_key(|name| flow.iter().position(|stage| stage == name));
    names.push(BETWEEN);
    Some(figure(row, lights, &names, &parts))
}

fn figure(
    row: &Row,
    lights: usize,
    names: &[&'static str],
    parts: &[(&'static str, Vec<(&'static str, f64)>)],
) -> Figure {
    let sum = |stages: &[(&str, f64)]| stages.iter().map(|stage| stage.1).sum::<f64>();
    let longest = parts.iter().map(|(_, stages)| sum(stages));
    let mut table = Table { head: vec!["Method".to_owned()], rows: Vec::new(), is_prose: false };
    table.head.extend(names.iter().map(|name| format!("{name}, ms")));
    table.head.push("all, ms".to_owned());
    let groups = parts.iter().map(|(method, stages)| {
        let of = |name: &str| stages.iter().find(|stage| stage.0 == name).map(|stage| stage.1);
        let values = names.iter().map(|name| {
            let value = of(name)?;
            let (label, tip) = (figures(value), format!("{method}, {name}: {} ms", figures(value)));
            Some(Value { length: value, spread: None, label, tip })
        });
        let values: Vec<_> = values.collect();
        let mut cells = vec![(*method).to_owned()];
        cells.extend(names.iter().map(|name| of(name).map_or_else(|| "–".to_owned(), figures)));
        cells.push(figures(sum(stages)));
        table.rows.push(cells);
        Group {
            name: (*method).to_owned(),
            heading: String::new(),
            values,
            remark: format!("{} ms", figures(sum(stages))),
        }
    });
    let groups: Vec<_> = groups.collect();
    let chart = Chart::Bars(Bars {
        kind: BarsKind::Stacked,
        axis: Axis::over("milliseconds", Scale::Linear, tick, longest),
        keys: names.iter().map(|name| key(name)).collect(),
        groups,
        marks: Vec::new(),
    });
    Figure {
        id: "stages",
        title: format!("Where the time goes: {} faces, {}", grouped(row.subject.faces), lights_text(lights)),
        lead: "Each method's time, stage by stage, in its run of median time. The exact \
               stage settles what the filter in the facing stage left open."
            .to_owned(),
        chart: Some(chart),
        table,
    }
}
