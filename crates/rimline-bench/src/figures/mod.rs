//! The builder of figures: each is made of rows by one of a few forms.

mod casters;
mod extraction;
mod shadows;
mod skipping;

use crate::chart::{Axis, Bar, Chart, Point, Scale, Series};
use crate::engine::{Metric, Summary};
use crate::page::{Figure, Section as Part, Table};
use crate::row::{Entry, Mark, Row, Section};
use crate::text::{grouped, or_dash, three_digits, tick, times};

pub(crate) use extraction::usual_lights;

/// Every chart that a report may have.
pub const CHARTS: [&str; 13] = [
    "time_against_error",
    "time_against_size",
    "speed_against_2003",
    "time_against_lights",
    "stages",
    "cost_of_exactness",
    "shadow_time_against_error",
    "shadow_stencil",
    "shadow_frame",
    "casters_recording",
    "skipping_work",
    "depth_maps_against_meshes",
    "depth_maps_stencil_passes",
];

/// The sections of a report that the rows are enough for.
pub(crate) fn sections(rows: &[Row]) -> Vec<Part> {
    let of = |section: Section| rows.iter().filter(|row| row.section == section).collect::<Vec<_>>();
    let some = |rows: Vec<&Row>, make: fn(&[&Row]) -> Part| (!rows.is_empty()).then(|| make(&rows));
    let casters = casters::section(&of(Section::Casters), &of(Section::OneMesh));
    let all = [
        some(of(Section::Extraction), extraction::section),
        some(of(Section::Shadows), shadows::section),
        casters,
        some(of(Section::Skipping), skipping::section),
        some(of(Section::DepthMaps), depth_maps),
    ];
    all.into_iter().flatten().collect()
}

/// `8 ms`.
fn ms(summary: Option<Summary>) -> String {
    summary.map_or_else(|| "–".to_owned(), |summary| format!("{} ms", three_digits(summary.median)))
}

/// A ratio as two cells: median, quartiles.
fn ratio_cells(ratio: Option<Summary>) -> [String; 2] {
    match ratio {
        None => ["–".to_owned(), "–".to_owned()],
        Some(Summary { median, quartiles: [low, high], .. }) => {
            [format!("{median:.2}"), format!("{low:.2} to {high:.2}")]
        }
    }
}

/// A figure that is a table alone.
fn table(id: &'static str, title: &str, lead: &str, table: Table) -> Figure {
    Figure { id, title: title.to_owned(), lead: lead.to_owned(), chart: None, table }
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
    let mut series: Vec<Series> = Vec::new();
    let mut known: Vec<&str> = Vec::new();
    for entry in rows.iter().flat_map(|row| &row.entries) {
        let (id, name) = (entry.variant.id.as_str(), &entry.variant.name);
        if known.contains(&id) || entry.summary(metric).is_none() {
            continue;
        }
        known.push(id);
        let of = |row: &&Row| row.entry(id).and_then(|entry| entry.summary(metric));
        table.rows.push([name.clone()].into_iter().chain(rows.iter().map(|row| ms(of(row)))).collect());
        if shown(entry) {
            let point = |row: &&Row| {
                let Summary { median, quartiles, .. } = of(row)?;
                Some(Point { x: row.number(fact), y: median, quartiles })
            };
            let points = rows.iter().filter_map(point).collect();
            series.push(Series { name: name.clone(), mark: entry.variant.mark, points });
        }
    }
    (curves(title, of_time, Scale::Log, tick, series, None), table)
}

/// Curves over a logarithmic axis.
fn curves(
    title: &str,
    of_y: &str,
    scale: Scale,
    format: fn(f64) -> String,
    series: Vec<Series>,
    level: Option<f64>,
) -> Chart {
    let points = || series.iter().flat_map(|series| &series.points);
    let ends = points().flat_map(|point| [point.y, point.quartiles[0], point.quartiles[1]]);
    let y = Axis::over(of_y, scale, format, ends.collect::<Vec<_>>());
    let y = level.map_or(y.clone(), |level| y.including(level));
    let x = Axis::over(title, Scale::Log, tick, points().map(|point| point.x).collect::<Vec<_>>());
    Chart::Plane { x, y, series, joined: true, level }
}

/// Two variants of a row that are divided, with the name and the mark of the quotient.
struct Quotient {
    name: String,
    of: &'static str,
    to: &'static str,
    mark: Mark,
}

/// Ratios of a time, a line a row: dots, and cells of a table. Rows of a group lie below its heading.
fn ratios(title: &str, rows: &[&Row], metric: Metric, quotients: &[Quotient]) -> (Chart, Table) {
    let mut table = Table::new(["Group, scene"]);
    table.head.extend(quotients.iter().flat_map(|quotient| [quotient.name.clone(), "quartiles".to_owned()]));
    let (mut bars, mut group) = (Vec::new(), "");
    let mut medians: Vec<Vec<f64>> = vec![Vec::new(); quotients.len()];
    for row in rows {
        if row.group != group {
            group = &row.group;
            bars.push(heading(group, quotients.len()));
        }
        let found: Vec<_> = quotients.iter().map(|quotient| row.ratio(metric, quotient.of, quotient.to)).collect();
        let mut cells = vec![format!("{group}: {}", row.title)];
        cells.extend(found.iter().flat_map(|ratio| ratio_cells(*ratio)));
        table.rows.push(cells);
        for (medians, ratio) in medians.iter_mut().zip(&found) {
            medians.extend(ratio.map(|ratio| ratio.median));
        }
        let values = found.iter().map(|ratio| ratio.map(|ratio| (ratio.median, ratio.quartiles))).collect();
        bars.push(Bar { name: row.title.clone(), is_heading: false, values, remark: String::new() });
    }
    let mean = |medians: &Vec<f64>| Some(medians.iter().sum::<f64>() / medians.len() as f64).filter(|m| m.is_finite());
    let means: Vec<Option<f64>> = medians.iter().map(mean).collect();
    let mut cells = vec!["mean".to_owned()];
    cells.extend(means.iter().zip(&medians).flat_map(|(mean, all)| {
        let range = Summary::of(all.iter().copied()).map_or([f64::NAN; 2], |summary| summary.range);
        [or_dash(*mean), format!("{:.2} to {:.2}", range[0], range[1])]
    }));
    table.rows.push(cells);
    let values = means.into_iter().map(|mean| mean.map(|mean| (mean, [mean; 2]))).collect();
    bars.push(heading("all", quotients.len()));
    bars.push(Bar { name: "mean".to_owned(), is_heading: false, values, remark: String::new() });
    let ends = bars
        .iter()
        .flat_map(|bar| bar.values.iter().flatten())
        .flat_map(|(median, [low, high])| [*median, *low, *high]);
    let axis = Axis::over(title, Scale::Log, times, ends.collect::<Vec<_>>()).including(0.9).including(2.0);
    let keys = quotients.iter().map(|quotient| (quotient.name.clone(), quotient.mark)).collect();
    (Chart::Rows { axis, keys, rows: bars, stacked: false, level: Some(1.0) }, table)
}

fn heading(name: &str, values: usize) -> Bar {
    Bar { name: name.to_owned(), is_heading: true, values: vec![None; values], remark: String::new() }
}

/// Parts of wholes, a bar each: those of any size are keys.
struct Parts {
    keys: Vec<(String, Mark)>,
    /// Bars, with how long each part is, and headings, which have none.
    bars: Vec<(Bar, Vec<f64>)>,
    table: Table,
}

impl Parts {
    fn new(keys: Vec<(String, Mark)>, first: &str) -> Self {
        let mut table = Table::new([first]);
        table.head.extend(keys.iter().map(|(name, _)| format!("{name}, ms")));
        table.head.push("together, ms".to_owned());
        Self { keys, bars: Vec::new(), table }
    }

    /// A bar of `amounts` milliseconds, drawn in units of `unit`.
    fn push(&mut self, [group, name]: [&str; 2], amounts: &[f64], unit: f64) {
        let sum: f64 = amounts.iter().sum();
        let mut cells = vec![if group.is_empty() { name.to_owned() } else { format!("{group}: {name}") }];
        cells.extend(amounts.iter().chain([&sum]).map(|ms| three_digits(*ms)));
        self.table.rows.push(cells);
        let remark = format!("{} ms", three_digits(sum));
        let bar = Bar { name: name.to_owned(), is_heading: false, values: Vec::new(), remark };
        self.bars.push((bar, amounts.iter().map(|ms| ms / unit).collect()));
    }

    fn heading(&mut self, name: &str) {
        self.bars.push((heading(name, 0), Vec::new()));
    }

    fn finish(self, title: &str) -> (Chart, Table) {
        // A legend of what no bar has would be a riddle.
        let has =
            |key: usize| self.bars.iter().any(|(_, amounts)| amounts.get(key).is_some_and(|amount| *amount > 0.0));
        let shown: Vec<usize> = (0..self.keys.len()).filter(|key| has(*key)).collect();
        let longest: Vec<f64> = self.bars.iter().map(|(_, amounts)| amounts.iter().sum()).collect();
        let bars = self.bars.iter().map(|(bar, amounts)| {
            let value = |key: &usize| amounts.get(*key).map(|length| (*length, [*length; 2]));
            Bar { values: shown.iter().map(value).collect(), ..bar.clone() }
        });
        let rows = bars.collect();
        let keys = shown.iter().map(|key| self.keys[*key].clone()).collect();
        let axis = Axis::over(title, Scale::Linear, tick, longest);
        (Chart::Rows { axis, keys, rows, stacked: true, level: None }, self.table)
    }
}

/// A cloud of points, a series a variant: time across, errors up, zero at the foot.
fn cloud([across, up]: [&str; 2], series: Vec<Series>) -> Chart {
    let points = || series.iter().flat_map(|series| &series.points);
    let x = Axis::over(across, Scale::Log, tick, points().map(|point| point.x).collect::<Vec<_>>());
    let y = Axis::over(up, Scale::Log, tick, points().map(|point| point.y).collect::<Vec<_>>()).with_zero();
    Chart::Plane { x, y, series, joined: false, level: None }
}

/// Casters without a mesh.
fn depth_maps(rows: &[&Row]) -> Part {
    let figure = |id, title: &str, lead: &str, of_time, metric| {
        let is_shown = |entry: &Entry| !entry.variant.name.contains("not counted");
        let (chart, table) = over(["faces of the caster", of_time], "faces", rows, metric, is_shown);
        Figure { id, title: title.to_owned(), lead: lead.to_owned(), chart: Some(chart), table }
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
                "Medians and quartiles; all methods ran in turn. Of a mesh: extraction, volumes and stencil. Of a map: drawing \
                 it, detection, volumes and stencil. Of a lookup: drawing the map, and looking every pixel up. The eye's own \
                 depth is not counted.",
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
