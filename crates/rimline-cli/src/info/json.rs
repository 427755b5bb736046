//! The report for programs. Keys are stable: they are only ever added to.

use crate::render::bounds::Bounds;
use rimline::Origin;
use rimline::mesh::{EdgeCounts, WeldCounts};
use serde_json::{Value, json};

use super::report::{MeshReport, kind_name};
use super::seams::Seams;
use crate::coordinates::point;

pub(super) fn mesh(report: &MeshReport) -> Value {
    let WeldCounts { before, after, apart, collapsed, .. } = report.vertices;
    let diagnostics = &report.diagnostics;
    let EdgeCounts { consistent, inconsistent, boundary } = diagnostics.edges;
    let listed: Vec<Value> = diagnostics
        .listed_edges
        .iter()
        .zip(&report.listed_positions)
        .map(|(edge, ends)| {
            let ends = ends.map(|end| point(end, report.origin).json());
            json!({ "kind": kind_name(edge.kind), "vertices": edge.vertices, "positions": ends })
        })
        .collect();
    json!({
        "name": report.name,
        "vertices": { "before": before, "after": after, "apart": apart },
        "faces": report.faces,
        "degenerate_faces": diagnostics.degenerate_faces,
        "collapsed_faces": collapsed,
        "duplicate_faces": diagnostics.duplicate_faces,
        "flipped_faces": diagnostics.flipped_faces,
        "edges": { "consistent": consistent, "inconsistent": inconsistent, "boundary": boundary },
        "non_manifold_edges": diagnostics.non_manifold_edges,
        "components": diagnostics.components,
        "inward_components": diagnostics.inward_components.unwrap_or(0),
        "closed": diagnostics.is_closed(),
        "why_open": report.why_open(),
        "offending_edges": listed,
        "near_boundary": report.seams.as_ref().map(Seams::json),
        "t_junctions": report.t_junctions,
        "joints_per_vertex": report.joints_per_vertex,
        "morph_targets": report.morph_targets,
        "bounds": report.bounds.map(|bounds| json_bounds(&bounds, report.origin)),
    })
}

fn json_bounds(Bounds { min, max }: &Bounds, origin: Origin) -> Value {
    json!({ "min": point(*min, origin).json(), "max": point(*max, origin).json() })
}
