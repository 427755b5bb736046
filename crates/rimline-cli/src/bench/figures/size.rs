//! Run time against the size of the mesh.

use super::super::method::{CPU_EXACT, CPU_FAST, GPU_EXACT, GPU_FAST, PER_EDGE};
use super::super::results::Results;
use super::super::text::{figures, grouped, tick, times};
use super::{light_counts, lights_text, ordinary, usual_lights};
use crate::chart::{Axis, Chart, Curve, Key, Plane, Point, Scale};
use crate::page::{Figure, Table};

/// The curves; more would lie on top of each other.
const SHOWN: [&str; 6] = [PER_EDGE, GPU_FAST, GPU_EXACT, "cpu-exact-one", CPU_FAST, CPU_EXACT];

/// A curve a method, with its slope; `None` where there is but one size.
pub(super) fn time_against_size(results: &Results) -> Option<Figure> {
    let lights = usual_lights(results);
    let rows = ordinary(results, lights);
    if rows.len() < 2 {
        return None;
    }
    let mut curves = Vec::new();
    let mut table = Table { head: vec!["Method".to_owned()], rows: Vec::new(), is_prose: false };
    table.head.extend(rows.iter().map(|row| format!("{} faces", grouped(row.subject.faces))));
    table.head.push("slope".to_owned());
    for contestant in results.contestants() {
        let of_rows = rows.iter().filter_map(|row| Some((row, row.entry(contestant.id)?.time()?)));
        let points: Vec<Point> = of_rows
            .map(|(row, time)| Point {
                x: row.subject.faces as f64,
                y: time.median,
                spread: Some(time.quartiles),
                label: String::new(),
                tip: format!(
                    "{}, {} faces: {} ms ({} to {}, {} runs)",
                    contestant.name,
                    grouped(row.subject.faces),
                    figures(time.median),
                    figures(time.quartiles.0),
                    figures(time.quartiles.1),
                    time.count
                ),
            })
            .collect();
        let slope = Plane::slope(&points).map_or_else(String::new, |slope| format!("{slope:.2}"));
        if points.len() == rows.len() {
            let mut cells = vec![contestant.name.to_owned()];
            cells.extend(points.iter().map(|point| format!("{} ms", figures(point.y))));
            cells.push(slope.clone());
            table.rows.push(cells);
        }
        if SHOWN.contains(&contestant.id) {
            curves.push(Curve { key: contestant.key(), points, remark: format!("slope {slope}") });
        }
    }
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let chart = Chart::Plane(Plane {
        x: Axis::over("faces of the mesh", Scale::Log, tick, points().map(|point| point.x)),
        y: Axis::over("milliseconds", Scale::Log, tick, points().map(|point| point.y)),
        curves,
        joined: true,
        mark: None,
        zero: None,
    });
    Some(Figure {
        id: "time_against_size",
        title: format!("Run time against size, closed meshes, {}", lights_text(lights)),
        lead: "Medians, with quartiles where they are wide enough to see. A slope of 1 is time in proportion to the \
               faces; below it, the fixed cost of small meshes shows."
            .to_owned(),
        chart: Some(chart),
        table,
    })
}

/// How many times faster than the 2003 method the exact one is, a curve a number of lights.
pub(super) fn speed_against_2003(results: &Results) -> Option<Figure> {
    let mut curves = Vec::new();
    let head = ["Lights, faces", "face masks, f32", "face masks, exact", "quartiles", "exact ÷ f32"];
    let head = head.map(str::to_owned).into();
    let mut table = Table { head, rows: Vec::new(), is_prose: false };
    for (index, lights) in light_counts(results).into_iter().enumerate() {
        let mut points = Vec::new();
        for row in ordinary(results, lights) {
            let (Some(exact), Some(fast)) = (row.ratio(PER_EDGE, GPU_EXACT), row.ratio(PER_EDGE, GPU_FAST)) else {
                continue;
            };
            let name = format!("{}, {} faces", lights_text(lights), grouped(row.subject.faces));
            let quartiles = format!("{} to {}", figures(exact.quartiles.0), figures(exact.quartiles.1));
            points.push(Point {
                x: row.subject.faces as f64,
                y: exact.median,
                spread: Some(exact.quartiles),
                label: String::new(),
                tip: format!("{name}: {} times as fast ({quartiles})", figures(exact.median)),
            });
            let cost =
                row.ratio(GPU_EXACT, GPU_FAST).map_or_else(|| "–".to_owned(), |cost| format!("{:.2}", cost.median));
            table.rows.push(vec![name, times_text(fast.median), times_text(exact.median), quartiles, cost]);
        }
        let key = Key { name: lights_text(lights), colour: [3, 4, 0, 5, 6][index % 5], shape: index, hollow: false };
        let remark = points.last().map_or_else(String::new, |last| times_text(last.y));
        curves.push(Curve { key, points, remark });
    }
    curves.retain(|curve| curve.points.len() > 1);
    if curves.is_empty() {
        return None;
    }
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let chart = Chart::Plane(Plane {
        x: Axis::over("faces of the mesh", Scale::Log, tick, points().map(|point| point.x)),
        y: Axis::over(
            "time of the 2003 method ÷ time of Rimline, exact",
            Scale::Linear,
            times,
            points().filter_map(|point| point.spread.map(|spread| spread.1)),
        )
        .including(1.0),
        curves,
        joined: true,
        mark: Some((1.0, "as fast as the 2003 method".to_owned())),
        zero: None,
    });
    Some(Figure {
        id: "speed_against_2003",
        title: "Exact face masks against the per-edge method of 2003, same GPU".to_owned(),
        lead:
            "Time of the 2003 method ÷ time of Rimline's, so larger is better: above the dashed line Rimline's exact \
               extraction is the faster one. Medians of each round's ratio. In the table's last column, what exactness \
               costs, smaller is better."
                .to_owned(),
        chart: Some(chart),
        table,
    })
}

fn times_text(ratio: f64) -> String {
    format!("{ratio:.2}×")
}
