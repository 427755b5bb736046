//! The report's section on casters without a mesh.

use super::super::depth_maps::{DepthMapResults, DepthMapRow, Times};
use super::super::text::{figures, grouped, tick};
use crate::chart::{Axis, Chart, Curve, Key, Plane, Point, Scale};
use crate::page::{Figure, Section, Table};

/// The ids of the plots.
pub(super) const AGAINST_MESHES: &str = "depth_maps_against_meshes";
pub(super) const STENCIL_PASSES: &str = "depth_maps_stencil_passes";

/// Methods that have a curve, as the bench names them, and as plots do, with colour and shape.
const SHOWN: [(&str, &str, usize, usize); 4] = [
    ("volumes of the mesh", "volumes of the mesh", 4, 0),
    ("of the map, automatic", "volumes of the depth map", 0, 1),
    ("of the map, contours 0.005", "volumes over its contours", 1, 2),
    ("lookup", "lookup in the map", 2, 3),
];

pub(in super::super) fn depth_maps(results: &DepthMapResults) -> Section {
    let DepthMapResults { device, size, rows } = results;
    let (chart, table) = plot(rows, "milliseconds of a frame's shadows", |row| &row.frames);
    let frames = Figure {
        id: AGAINST_MESHES,
        title: "A frame's shadows against the faces of the caster".to_owned(),
        lead: "Medians, with quartiles where they are wide enough to see; all methods ran in turn. Of a mesh: extraction, \
               volumes and stencil. Of a map: drawing it, detection, volumes and stencil. Of a lookup: drawing the map, and \
               looking every pixel up. The eye's own depth is not counted."
            .to_owned(),
        chart: Some(chart),
        table,
    };
    let (chart, table) = plot(rows, "milliseconds of the stencil pass", |row| &row.stencil_passes);
    let passes = Figure {
        id: STENCIL_PASSES,
        title: "The stencil pass alone against the faces of the caster".to_owned(),
        lead: "The same frames' draws into the stencil, once more by themselves.".to_owned(),
        chart: Some(chart),
        table,
    };
    Section {
        title: "Depth maps against meshes".to_owned(),
        lead: format!(
            "A sphere over a ground, picture and map of {size} × {size}, by `cargo bench --bench depth_maps -- casters` on \
             {device}: \
             shadows by the volumes of the mesh, by volumes rebuilt from a depth map, and by a lookup in that map."
        ),
        figures: vec![frames, passes],
    }
}

/// Times against faces.
fn plot(rows: &[DepthMapRow], what: &str, times: fn(&DepthMapRow) -> &Times) -> (Chart, Table) {
    let mut table = Table { head: vec!["Faces".to_owned()], rows: Vec::new(), is_prose: false };
    let names = || rows.first().into_iter().flat_map(|row| times(row).names());
    table.head.extend(names().map(str::to_owned));
    for row in rows {
        let ms =
            |name| times(row).time(name).map_or_else(|| "–".to_owned(), |time| format!("{} ms", figures(time.median)));
        table.rows.push([grouped(row.faces as usize)].into_iter().chain(names().map(ms)).collect());
    }
    let mut curves = Vec::new();
    for (name, shown, colour, shape) in SHOWN {
        let point = |row: &DepthMapRow| {
            let time = times(row).time(name)?;
            let (low, high) = time.quartiles;
            Some(Point {
                x: row.faces as f64,
                y: time.median,
                spread: Some(time.quartiles),
                label: String::new(),
                tip: format!(
                    "{shown}, {} faces: {} ms ({} to {}, {} runs)",
                    grouped(row.faces as usize),
                    figures(time.median),
                    figures(low),
                    figures(high),
                    time.count
                ),
            })
        };
        let mut points: Vec<Point> = rows.iter().filter_map(point).collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let Some(last) = points.last() else { continue };
        let remark = format!("{} ms", figures(last.y));
        curves.push(Curve { key: Key { name: shown.to_owned(), colour, shape, hollow: false }, points, remark });
    }
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let chart = Chart::Plane(Plane {
        x: Axis::over("faces of the caster", Scale::Log, tick, points().map(|point| point.x)),
        y: Axis::over(what, Scale::Log, tick, points().map(|point| point.y)),
        curves,
        joined: true,
        mark: None,
        zero: None,
    });
    (chart, table)
}
