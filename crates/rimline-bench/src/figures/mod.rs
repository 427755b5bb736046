//! The builder of figures: each is made of rows by one of a few forms.

mod casters;
mod extraction;
mod shadows;
mod skipping;

use crate::chart::{Axis, Bar, Body, Chart, Point, Scale, Series};
use crate::engine::{Metric, Summary};
use crate::page::{Figure, Section as Part, Table};
use crate::row::{Entry, Mark, Row, Section, Variant};
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
        let of = |row: &&Row| row.summary(id, metric);
        table.rows.push([name.clone()].into_iter().chain(rows.iter().map(|row| ms(of(row)))).collect());
        if shown(entry) {
            let point = |row: &&Row| {
                let Summary { median, quartiles, .. } = of(row)?;
                Some(Point { x: row.number(fact), y: median, quartiles })
            };
            series.push(Series { name: name.clone(), mark: *mark, points: rows.iter().filter_map(point).collect() });
        }
    }
    (curves(title, of_time, Scale::Log, tick, series, None), table)
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
fn curves(
    title: &str,
    of_y: &str,
    scale: Scale,
    format: fn(f64) -> String,
    series: Vec<Series>,
    level: Option<f64>,
) -> Chart {
    let points = || series.iter().flat_map(|series| &series.points);
    let y =
        Axis::over(of_y, scale, format, points().flat_map(|point| [point.y, point.quartiles[0], point.quartiles[1]]));
    let y = level.into_iter().fold(y, Axis::including);
    let axis = Axis::over(title, Scale::Log, tick, points().map(|point| point.x));
    Chart { axis, series, body: Body::Plane { y, is_joined: true }, level }
}

/// Two variants of a row that are divided, with the name and the mark of the quotient.
struct Quotient {
    name: String,
    of: &'static str,
    to: &'static str,
    mark: Mark,
}

impl Quotient {
    fn new(name: &str, of: &'static str, to: &'static str, (colour, shape, hollow): (usize, usize, bool)) -> Self {
        Self { name: name.to_owned(), of, to, mark: Mark { colour, shape, hollow } }
    }
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
    let axis = Axis::over(title, Scale::Log, times, ends).including(0.9).including(2.0);
    let key = |quotient: &Quotient| Series { name: quotient.name.clone(), mark: quotient.mark, points: Vec::new() };
    let (series, body) = (quotients.iter().map(key).collect(), Body::Rows { rows: bars, is_stacked: false });
    (Chart { axis, series, body, level: Some(1.0) }, table)
}

fn heading(name: &str, values: usize) -> Bar {
    Bar { name: name.to_owned(), is_heading: true, values: vec![None; values], remark: String::new() }
}

/// Parts of wholes, a bar each: those of any size are keys.
struct Parts {
    keys: Vec<Series>,
    /// Their values are lengths of all keys; headings have none.
    bars: Vec<Bar>,
    table: Table,
}

impl Parts {
    /// Keys by their names and colours.
    fn new<'k>(keys: impl IntoIterator<Item = (&'k str, usize)>, first: &str) -> Self {
        let key = |(name, colour): (&str, _)| {
            let mark = Mark { colour, shape: 1, hollow: false };
            Series { name: name.to_owned(), mark, points: Vec::new() }
        };
        let keys: Vec<Series> = keys.into_iter().map(key).collect();
        let mut table = Table::new([first]);
        table.head.extend(keys.iter().map(|key| format!("{}, ms", key.name)));
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
        let values = amounts.iter().map(|ms| Some((ms / unit, [ms / unit; 2]))).collect();
        self.bars.push(Bar { name: name.to_owned(), is_heading: false, values, remark });
    }

    fn heading(&mut self, name: &str) {
        self.bars.push(heading(name, 0));
    }

    fn finish(mut self, title: &str) -> (Chart, Table) {
        let length = |value: &Option<(f64, [f64; 2])>| value.map_or(0.0, |(length, _)| length);
        let longest: Vec<f64> = self.bars.iter().map(|bar| bar.values.iter().map(length).sum()).collect();
        // A legend of what no bar has would be a riddle.
        let is_shown =
            |key: usize| self.bars.iter().any(|bar| bar.values.get(key).is_some_and(|one| length(one) > 0.0));
        let shown: Vec<bool> = (0..self.keys.len()).map(is_shown).collect();
        for bar in &mut self.bars {
            let mut shown = shown.iter();
            bar.values.retain(|_| shown.next() == Some(&true));
        }
        let mut shown = shown.iter();
        self.keys.retain(|_| shown.next() == Some(&true));
        let axis = Axis::over(title, Scale::Linear, tick, longest);
        let body = Body::Rows { rows: self.bars, is_stacked: true };
        (Chart { axis, series: self.keys, body, level: None }, self.table)
    }
}

/// A cloud of points, a series a variant: time across, errors up, zero at the foot.
fn cloud([across, up]: [&str; 2], series: Vec<Series>) -> Chart {
    let points = || series.iter().flat_map(|series| &series.points);
    let axis = Axis::over(across, Scale::Log, tick, points().map(|point| point.x));
    let y = Axis::over(up, Scale::Log, tick, points().map(|point| point.y)).with_zero();
    Chart { axis, series, body: Body::Plane { y, is_joined: false }, level: None }
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
