//! The report's section on casters without a mesh.

use super::super::depth_maps::{DepthMapResults, DepthMapRow};
use super::super::text::{figures, grouped, tick};
use crate::chart::{Axis, Chart, Curve, Key, Plane, Point, Scale};
use crate::page::{Figure, Section, Table};

/// The plot's id.
pub(super) const AGAINST_MESHES: &str = "depth_maps_against_meshes";

/// Methods that have a curve, as the bench names them, with colour and shape.
const SHOWN: [(&str, usize, usize); 4] = [
    ("volumes of the mesh", 4, 0),
    ("of the map, automatic", 0, 1),
    ("of the map, contours 0.005", 1, 2),
    ("lookup", 2, 3),
];

pub(in super::super) fn depth_maps(results: &DepthMapResults) -> Section {
    let DepthMapResults { device, size, .. } = results;
    Section {
        title: "Depth maps against meshes".to_owned(),
        lead: format!(
            "A sphere over a ground, picture and map of {size} × {size}, by `cargo bench --bench depth_maps -- casters` on \
             {device}: \
             shadows by the volumes of the mesh, by volumes rebuilt from a depth map, and by a lookup in that map."
        ),
        figures: vec![against_meshes(results)],
    }
}

fn ms(row: &DepthMapRow, name: &str) -> String {
    row.time(name).map_or_else(|| "–".to_owned(), |time| format!("{} ms", figures(time.median)))
}

fn against_meshes(results: &DepthMapResults) -> Figure {
    let mut table = Table { head: vec!["Faces".to_owned()], rows: Vec::new(), is_prose: false };
    let names = || results.rows.first().into_iter().flat_map(|row| row.methods.iter().map(|(name, _)| name.as_str()));
    table.head.extend(names().map(str::to_owned));
    for row in &results.rows {
        let faces = grouped(row.faces as usize);
        table.rows.push([faces].into_iter().chain(names().map(|name| ms(row, name))).collect());
    }
    let mut curves = Vec::new();
    for (name, colour, shape) in SHOWN {
        let point = |row: &DepthMapRow| {
            let time = row.time(name)?;
            Some(Point {
                x: row.faces as f64,
                y: time.median,
                spread: Some(time.quartiles),
                label: String::new(),
                tip: format!(
                    "{}, {} faces: {} ms ({} to {}, {} runs)",
                    name,
                    grouped(row.faces as usize),
                    figures(time.median),
                    figures(time.quartiles.0),
                    figures(time.quartiles.1),
                    time.count
                ),
            })
        };
        let mut points: Vec<Point> = results.rows.iter().filter_map(point).collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let Some(last) = points.last() else { continue };
        let remark = format!("{} ms", figures(last.y));
        let name = match name {
            "of the map, automatic" => "volumes of the depth map",
            "of the map, contours 0.005" => "volumes over its contours",
            "lookup" => "lookup in the map",
            name => name,
        };
        curves.push(Curve { key: Key { name: name.to_owned(), colour, shape, hollow: false }, points, remark });
    }
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let chart = Chart::Plane(Plane {
        x: Axis::over("faces of the caster", Scale::Log, tick, points().map(|point| point.x)),
        y: Axis::over("milliseconds of a frame's shadows", Scale::Log, tick, points().map(|point| point.y)),
        curves,
        joined: true,
        mark: None,
        zero: None,
    });
    Figure {
        id: AGAINST_MESHES,
        title: "A frame's shadows against the faces of the caster".to_owned(),
        lead: "Medians, with quartiles where they are wide enough to see; all methods ran in turn. Of a mesh: extraction, \
               volumes and stencil. Of a map: drawing it, detection, volumes and stencil. Of a lookup: drawing the map, and \
               looking every pixel up. The eye's own depth is not counted."
            .to_owned(),
        chart: Some(chart),
        table,
    }
}
