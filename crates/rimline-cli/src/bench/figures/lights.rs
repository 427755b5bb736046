//! Run time against the number of lights.

use super::super::results::{Entry, Results, Row};
use super::super::text::{figures, grouped, tick};
use super::{lights_text, ordinary};
use crate::chart::{Axis, Bars, BarsKind, Chart, Group, Scale, Value};
use crate::page::{Figure, Table};

/// The largest mesh with each number of lights, a bar a method; `None` where there is but one number.
pub(super) fn time_against_lights(results: &Results, all: &[usize]) -> Option<Figure> {
    let faces = all.iter().filter_map(|&lights| Some(ordinary(results, lights).pop()?.subject.faces)).max()?;
    let of = |&lights: &usize| ordinary(results, lights).into_iter().find(|row| row.subject.faces == faces);
    let rows: Vec<&Row> = all.iter().filter_map(of).collect();
    if rows.len() < 2 {
        return None;
    }
    let one_thread = |id: &str| id.starts_with("cpu") && id.ends_with("-one");
    let takes_all = |id: &str| rows.iter().all(|row| row.entry(id).is_some());
    let contestants = || results.contestants().filter(|contestant| takes_all(contestant.id));
    let shown: Vec<_> = contestants().filter(|contestant| !one_thread(contestant.id)).collect();
    let mut table = Table { head: vec!["Method".to_owned()], rows: Vec::new(), is_prose: false };
    table.head.extend(rows.iter().map(|row| lights_text(row.lights)));
    for contestant in contestants() {
        let times = rows.iter().map(|row| row.entry(contestant.id).and_then(Entry::time));
        let mut cells = vec![contestant.name.to_owned()];
        cells.extend(
            times.map(|time| time.map_or_else(|| "–".to_owned(), |time| format!("{} ms", figures(time.median)))),
        );
        table.rows.push(cells);
    }
    let groups = rows.iter().map(|row| {
        let values = shown.iter().map(|contestant| {
            let time = row.entry(contestant.id)?.time()?;
            let label = format!("{} ms", figures(time.median));
            let tip = format!("{}, {}: {label}", contestant.name, lights_text(row.lights));
            Some(Value { length: time.median, spread: Some(time.quartiles), label, tip })
        });
        let values = values.collect();
        Group { name: lights_text(row.lights), heading: String::new(), values, remark: String::new() }
    });
    let groups: Vec<Group> = groups.collect();
    let longest = groups.iter().flat_map(|group| group.values.iter().flatten()).map(|value| value.length);
    let chart = Chart::Bars(Bars {
        kind: BarsKind::Grouped,
        axis: Axis::over("milliseconds", Scale::Linear, tick, longest.collect::<Vec<_>>()),
        keys: shown.iter().map(|contestant| contestant.key()).collect(),
        groups,
        marks: Vec::new(),
    });
    Some(Figure {
        id: "time_against_lights",
        title: format!("Run time against lights, closed mesh of {} faces", grouped(faces)),
        lead: "A batch of 32 lights is decided and compared at once, so many lights cost less than each by itself."
            .to_owned(),
        chart: Some(chart),
        table,
    })
}
