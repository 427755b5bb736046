//! The report for programs. Keys are stable: they are only ever added to.

use rimline::mesh::{Bounds, EdgeCounts, WeldCounts};
use serde_json::{Value, json};

use super::report::{MeshReport, kind_name};

pub(super) fn mesh(report: &MeshReport) -> Value {
    let WeldCounts { before, after, apart } = report.vertices;
    let diagnostics = &report.diagnostics;
    let EdgeCounts { consistent, inconsistent, boundary } = diagnostics.edges;
    let listed: Vec<Value> = diagnostics
        .listed_edges
        .iter()
        .zip(&report.listed_positions)
        .map(|(edge, ends)| json!({ "kind": kind_name(edge.kind), "vertices": edge.vertices, "positions": ends }))
        .collect();
    json!({
        "name": report.name,
        "vertices": { "before": before, "after": after, "apart": apart },
        "faces": report.faces,
        "degenerate_faces": diagnostics.degenerate_faces,
        "duplicate_faces": diagnostics.duplicate_faces,
        "flipped_faces": diagnostics.flipped_faces,
        "edges": { "consistent": consistent, "inconsistent": inconsistent, "boundary": boundary },
        "non_manifold_edges": diagnostics.non_manifold_edges,
        "components": diagnostics.components,
        "closed": diagnostics.is_closed(),
        "why_open": report.why_open(),
        "offending_edges": listed,
        "joints_per_vertex": report.joints_per_vertex,
        "morph_targets": report.morph_targets,
        "bounds": report.bounds.map(bounds),
    })
}

fn bounds(Bounds { min, max }: Bounds) -> Value {
    json!({ "min": min, "max": max })
}
