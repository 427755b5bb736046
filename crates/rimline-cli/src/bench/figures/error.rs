//! Run time against error.

use rimline_bench::error_metrics::Score;

use super::super::bench_mesh::ORDINARY;
use super::super::method::{CPU_EXACT, Contestant, GPU_EXACT};
use super::super::results::{Entry, Results, Row};
use super::super::text::{figures, grouped, tick};
use super::{lights_text, usual_lights};
use crate::chart::{Axis, Chart, Curve, Plane, Point, Scale, ZeroBand};
use crate::page::{Figure, Table};

/// A method on all scenes of a class.
struct Spot {
    class: &'static str,
    /// Nanoseconds a face and light, the geometric mean over scenes.
    time_ns: f64,
    /// Wrong bits in a million silhouette bits.
    wrong: f64,
    wrong_bits: usize,
    open: usize,
}

/// Classes in the order of the rows.
fn classes(rows: &[&Row]) -> Vec<&'static str> {
    let mut classes = Vec::new();
    for row in rows {
        if !classes.contains(&row.subject.class) {
            classes.push(row.subject.class);
        }
    }
    classes
}

fn spot(rows: &[&Row], class: &'static str, contestant: &Contestant) -> Option<Spot> {
    let of_class = rows.iter().filter(|row| row.subject.class == class);
    let entries: Vec<(&Row, &Entry)> = of_class.filter_map(|row| Some((*row, row.entry(contestant.id)?))).collect();
    let (mut logs, mut wrong_bits, mut bits, mut open) = (0.0, 0, 0, 0);
    for (row, entry) in &entries {
        logs += (entry.time()?.median * 1e6 / (row.subject.faces * row.lights) as f64).ln();
        wrong_bits += entry.score.wrong_silhouette_bits;
        bits += entry.score.silhouette_bits;
        open += entry.score.unclosed_vertices;
    }
    (!entries.is_empty()).then(|| Spot {
        class,
        time_ns: (logs / entries.len() as f64).exp(),
        wrong: wrong_bits as f64 / bits.max(1) as f64 * 1e6,
        wrong_bits,
        open,
    })
}

/// The methods whose bits may differ: one thread finds the same again, and the plain loop what its twin does.
fn distinct(results: &Results) -> Vec<&'static Contestant> {
    let is_repeated = |contestant: &&Contestant| contestant.id.ends_with("-one") || contestant.id == "cpu-plain-all";
    results.contestants().filter(|contestant| !is_repeated(contestant)).collect()
}

/// One point a method and class of scenes.
pub(super) fn time_against_error(results: &Results) -> Figure {
    let lights = usual_lights(results);
    let rows: Vec<&Row> = results.rows.iter().filter(|row| row.lights == lights).collect();
    let classes = classes(&rows);
    let spots: Vec<(&Contestant, Vec<Spot>)> = distinct(results)
        .into_iter()
        .map(|contestant| (contestant, classes.iter().filter_map(|class| spot(&rows, class, contestant)).collect()))
        .collect();
    let curves = spots.iter().map(|(contestant, spots)| {
        let points = spots.iter().map(|spot| Point {
            x: spot.time_ns,
            y: spot.wrong,
            spread: None,
            label: spot.class.to_owned(),
            tip: format!(
                "{}, {}: {} ns a face and light, {} wrong silhouette bits, {} open vertices",
                contestant.name,
                spot.class,
                figures(spot.time_ns),
                grouped(spot.wrong_bits),
                grouped(spot.open)
            ),
        });
        Curve { key: contestant.key(), points: points.collect(), remark: String::new() }
    });
    let all = || spots.iter().flat_map(|(_, spots)| spots);
    let chart = Chart::Plane(Plane {
        x: Axis::over(
            "run time: nanoseconds a face and light (further left is faster)",
            Scale::Log,
            tick,
            all().map(|spot| spot.time_ns),
        ),
        y: Axis::over("wrong silhouette bits in a million", Scale::Log, tick, all().map(|spot| spot.wrong)),
        curves: curves.collect(),
        joined: false,
        mark: None,
        zero: Some(ZeroBand { title: "none wrong".to_owned() }),
    });
    let mut table = Table { head: vec!["Method, scenes".to_owned()], rows: Vec::new(), is_prose: false };
    table.head.extend(
        ["ns a face and light", "wrong in a million", "wrong silhouette bits", "open vertices"].map(str::to_owned),
    );
    for (contestant, spots) in &spots {
        for spot in spots {
            table.rows.push(vec![
                format!("{}: {}", contestant.name, spot.class),
                figures(spot.time_ns),
                figures(spot.wrong),
                grouped(spot.wrong_bits),
                grouped(spot.open),
            ]);
        }
    }
    Figure {
        id: "time_against_error",
        title: format!("Run time against error, {}", lights_text(lights)),
        lead: "One mark for each method and class of scenes. Above, the higher the more silhouette bits are wrong; in the \
               band below, none is. Grey lines join the methods on the same scenes. Colours are arithmetics; filled marks \
               are the GPU's, hollow ones the CPU's."
            .to_owned(),
        chart: Some(chart),
        table,
    }
}

/// Every scene's errors, the methods beside each other.
pub(super) fn errors(results: &Results) -> Figure {
    let mut contestants = distinct(results);
    // A table too wide for the page shows its first columns.
    contestants.sort_by_key(|contestant| ![GPU_EXACT, CPU_EXACT].contains(&contestant.id));
    let (ordinary, scenes): (Vec<&Row>, Vec<&Row>) = results.rows.iter().partition(|row| row.subject.class == ORDINARY);
    // Said once where it is the same for all: the table is wide enough.
    let lights =
        scenes.first().filter(|first| scenes.iter().all(|row| row.lights == first.lights)).map(|row| row.lights);
    let mut head = vec![lights.map_or_else(|| "Scene, lights".to_owned(), |_| "Scene".to_owned())];
    head.extend(contestants.iter().map(|contestant| contestant.name.replace(", all threads", "")));
    let mut rows = Vec::new();
    if !ordinary.is_empty() {
        rows.push(error_cells("closed meshes, all lights".to_owned(), &ordinary, &contestants));
    }
    for row in scenes {
        let name = match lights {
            Some(_) => row.subject.name.clone(),
            None => format!("{}, {}", row.subject.name, lights_text(row.lights)),
        };
        rows.push(error_cells(name, &[row], &contestants));
    }
    Figure {
        id: "errors",
        title: lights
            .map_or_else(|| "Errors by scene".to_owned(), |lights| format!("Errors by scene, {}", lights_text(lights))),
        lead: "Wrong facing bits / wrong silhouette bits / open vertices; one 0 where there is none of them."
            .to_owned(),
        chart: None,
        table: Table { head, rows, is_prose: false },
    }
}

/// The errors of each method, summed over rows.
fn error_cells(name: String, rows: &[&Row], contestants: &[&Contestant]) -> Vec<String> {
    let cell = |contestant: &&Contestant| {
        let scores: Vec<Score> = rows.iter().filter_map(|row| Some(row.entry(contestant.id)?.score)).collect();
        let sum = |of: fn(&Score) -> usize| scores.iter().map(of).sum::<usize>();
        let sums = [
            sum(|score| score.wrong_facing_bits),
            sum(|score| score.wrong_silhouette_bits),
            sum(|score| score.unclosed_vertices),
        ];
        match sums {
            _ if scores.is_empty() => "–".to_owned(),
            [0, 0, 0] => "0".to_owned(),
            sums => sums.map(grouped).join(" / "),
        }
    };
    std::iter::once(name).chain(contestants.iter().map(cell)).collect()
}
