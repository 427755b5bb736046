//! Cost of exactness.

use super::super::bench_mesh::ORDINARY;
use super::super::measure::Summary;
use super::super::method::{CPU_EXACT, CPU_FAST, GPU_EXACT, GPU_FAST};
use super::super::results::{Results, Row};
use super::super::text::{figures, grouped, times};
use super::{lights_text, usual_lights};
use crate::chart::{Axis, Bars, BarsKind, Chart, Group, Key, Scale, Value};
use crate::page::{Figure, Table};

/// Exact ÷ fast for every mesh and scene.
pub(super) fn cost_of_exactness(results: &Results) -> Figure {
    let lights = usual_lights(results);
    let rows: Vec<&Row> = results.rows.iter().filter(|row| row.lights == lights).collect();
    let head = ["Mesh or scene", "GPU", "quartiles", "CPU, all threads", "quartiles", "pairs settled in integers"];
    let mut table = Table { head: head.map(str::to_owned).into(), rows: Vec::new(), is_prose: false };
    let (mut groups, mut all, mut class) = (Vec::new(), Vec::new(), "");
    for row in rows {
        let gpu = row.ratio(GPU_EXACT, GPU_FAST);
        let cpu = row.ratio(CPU_EXACT, CPU_FAST);
        all.extend([&gpu, &cpu].into_iter().flatten().flat_map(|ratio| [ratio.quartiles.0, ratio.quartiles.1]));
        let name = if row.subject.class == ORDINARY {
            format!("{} faces", grouped(row.subject.faces))
        } else {
            row.subject.name.clone()
        };
        let share = share_of_undecided(row);
        let value = |device: &str, ratio: Option<Summary>| {
            ratio.map(|ratio| Value {
                length: ratio.median,
                spread: Some(ratio.quartiles),
                label: String::new(),
                tip: format!(
                    "{name}, {device}: {} times the f32 time ({} to {}), {share} of the pairs settled in integers",
                    figures(ratio.median),
                    figures(ratio.quartiles.0),
                    figures(ratio.quartiles.1)
                ),
            })
        };
        let cells = |ratio: Option<Summary>| match ratio {
            None => ["–".to_owned(), "–".to_owned()],
            Some(Summary { median, quartiles, .. }) => {
                [format!("{median:.2}"), format!("{:.2} to {:.2}", quartiles.0, quartiles.1)]
            }
        };
        table.rows.push([vec![name.clone()], cells(gpu).into(), cells(cpu).into(), vec![share.clone()]].concat());
        let heading = if row.subject.class == class { String::new() } else { heading(row.subject.class) };
        class = row.subject.class;
        groups.push(Group { values: vec![value("GPU", gpu), value("CPU", cpu)], name, heading, remark: String::new() });
    }
    let key = |name: &str, colour, shape, hollow| Key { name: name.to_owned(), colour, shape, hollow };
    let chart = Chart::Bars(Bars {
        kind: BarsKind::Dots,
        axis: Axis::over("time of the exact method ÷ time of plain f32", Scale::Log, times, all)
            .including(0.8)
            .including(2.0),
        keys: vec![key("GPU", 4, 0, false), key("CPU, all threads", 5, 3, true)],
        groups,
        marks: vec![(1.0, "free".to_owned())],
    });
    Figure {
        id: "cost_of_exactness",
        title: format!("What exactness costs, {}", lights_text(lights)),
        lead: "Time of exact face masks ÷ time of the same in plain f32, in the same run; on the dashed line it costs \
               nothing. Scenes that cost most have lights in the planes of many of their faces, so that integers must \
               settle them."
            .to_owned(),
        chart: Some(chart),
        table,
    }
}

fn heading(class: &str) -> String {
    if class == ORDINARY { "closed meshes".to_owned() } else { class.to_owned() }
}

/// Pairs of face and light that went to integers.
fn share_of_undecided(row: &Row) -> String {
    let entry = row.entry(GPU_EXACT).or_else(|| row.entry(CPU_EXACT));
    let pairs = (row.subject.faces * row.lights) as f64;
    entry.map_or_else(String::new, |entry| match f64::from(entry.undecided_pairs) / pairs * 100.0 {
        0.0 => "0".to_owned(),
        share if share < 0.01 => "under 0.01 %".to_owned(),
        share => format!("{} %", figures(share)),
    })
}
