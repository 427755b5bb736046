//! Report on a mesh, gathered once for text and JSON.

use rimline::mesh::{Edge, EdgeCounts, EdgeKind, MeshDiagnostics, WeldCounts};
use rimline::{Geometry, Influences, Mesh, MeshError, Origin};
use rimline_picture::Bounds;
use serde_json::{Value, json};

use super::seams::{Seams, t_junctions};
use crate::coordinates::point;

const LISTED_EDGES: usize = 4;

/// One mesh, or several together.
#[derive(Debug, Default)]
pub(super) struct MeshReport {
    pub(super) name: Option<String>,
    pub(super) vertices: WeldCounts,
    pub(super) faces: usize,
    pub(super) diagnostics: MeshDiagnostics,
    /// The ends of each of `diagnostics.listed_edges`.
    pub(super) listed_positions: Vec<[[f32; 3]; 2]>,
    pub(super) morph_targets: usize,
    /// The most joints that any vertex follows; 0 for a rigid mesh.
    pub(super) joints_per_vertex: usize,
    pub(super) bounds: Option<Bounds>,
    /// Origin that positions and bounds are relative to.
    pub(super) origin: Origin,
    /// Boundary edges that rounding may have left open. Only of meshes in their own space.
    pub(super) seams: Option<Seams>,
    pub(super) t_junctions: usize,
}

impl MeshReport {
    pub(super) fn of_geometry(geometry: &Geometry, vertices: WeldCounts, origin: Origin) -> Result<Self, MeshError> {
        if geometry.faces().is_empty() {
            // A mesh of lines or points alone; no instance shows it.
            let name = geometry.name().map(str::to_owned);
            return Ok(Self { name, vertices, ..Self::default() });
        }
        let mesh = geometry.mesh()?;
        Ok(Self {
            name: geometry.name().map(str::to_owned),
            vertices,
            morph_targets: geometry.morph_targets().len(),
            joints_per_vertex: geometry.influences().map_or(0, Influences::most_per_vertex),
            seams: Seams::of(geometry, &mesh),
            ..Self::of_mesh(&mesh, geometry.positions(), origin)
        })
    }

    /// `positions` has one for each of the mesh's vertices.
    pub(super) fn of_mesh(mesh: &Mesh, positions: &[[f32; 3]], origin: Origin) -> Self {
        let diagnostics = MeshDiagnostics::of_placed(mesh, positions, LISTED_EDGES);
        let ends = |edge: &Edge| edge.vertices.map(|v| positions[v as usize]);
        Self {
            vertices: mesh.weld_counts(),
            faces: mesh.face_count(),
            listed_positions: diagnostics.listed_edges.iter().map(ends).collect(),
            diagnostics,
            bounds: Bounds::of(positions),
            origin,
            t_junctions: t_junctions(mesh, positions),
            ..Self::default()
        }
    }

    /// Each mesh once, for any number of its instances; without bounds, since each lies in a space of its own.
    pub(super) fn total(meshes: &[Self]) -> Self {
        let mut total = Self::default();
        macro_rules! add {
            ($mesh:ident: $($($field:ident).+),+) => { $(total.$($field).+ += $mesh.$($field).+;)+ };
        }
        for mesh in meshes {
            add!(mesh: faces, morph_targets, t_junctions);
            add!(mesh: vertices.before, vertices.after, vertices.apart, vertices.collapsed, vertices.wide);
            add!(mesh: diagnostics.edges.consistent, diagnostics.edges.inconsistent, diagnostics.edges.boundary);
            add!(mesh: diagnostics.non_manifold_edges, diagnostics.components);
            add!(mesh: diagnostics.degenerate_faces, diagnostics.duplicate_faces, diagnostics.flipped_faces);
            total.joints_per_vertex = total.joints_per_vertex.max(mesh.joints_per_vertex);
            let inward = mesh.diagnostics.inward_components.unwrap_or(0);
            *total.diagnostics.inward_components.get_or_insert(0) += inward;
        }
        total
    }

    pub(super) fn why_open(&self) -> Option<String> {
        let EdgeCounts { inconsistent, boundary, .. } = self.diagnostics.edges;
        let reasons = [ONE_SIDED.of(boundary), TURNED.of(inconsistent)];
        let reasons: Vec<String> = reasons.into_iter().flatten().collect();
        (!reasons.is_empty()).then(|| reasons.join(", "))
    }

    /// Advice about the findings, beside the options that close seams.
    pub(super) fn advice(&self) -> Vec<String> {
        let MeshDiagnostics { edges, inward_components, duplicate_faces, .. } = &self.diagnostics;
        let findings = [
            (edges.inconsistent, TURNED),
            (inward_components.unwrap_or(0), INWARD),
            (*duplicate_faces, TWICE),
            (self.t_junctions, T_JUNCTION),
        ];
        let advice = |(count, finding): (usize, Finding)| Some(format!("{}: {}", finding.of(count)?, finding.advice));
        findings.into_iter().filter_map(advice).collect()
    }
}

/// A fault of edges, faces or parts, and its remedy.
pub(super) struct Finding {
    one: &'static str,
    many: &'static str,
    advice: &'static str,
}

const ONE_SIDED: Finding =
    Finding { one: "edge has a face on one side only", many: "edges have a face on one side only", advice: "" };
const TURNED: Finding = Finding {
    one: "edge joins faces that are turned against each other",
    many: "edges join faces that are turned against each other",
    advice: "make the winding consistent (Blender: Mesh, Normals, Recalculate Outside)",
};
pub(super) const INWARD: Finding = Finding {
    one: "closed part is wound inwards",
    many: "closed parts are wound inwards",
    advice: "flip the faces unless they are meant to be seen from inside (Blender: Mesh, Normals, Flip)",
};
const TWICE: Finding = Finding {
    one: "face is there twice",
    many: "faces are there twice",
    advice: "remove the copies (Blender: Mesh, Clean Up, Merge by Distance)",
};
const T_JUNCTION: Finding = Finding {
    one: "vertex lies on an edge that does not end there",
    many: "vertices lie on edges that do not end there",
    advice: "split these edges at the vertices, or light may leak through the seam",
};

impl Finding {
    /// So many of it, if there are any.
    pub(super) fn of(&self, count: usize) -> Option<String> {
        (count > 0).then(|| format!("{count} {}", if count == 1 { self.one } else { self.many }))
    }
}

pub(super) fn kind_name(kind: EdgeKind) -> &'static str {
    match kind {
        EdgeKind::Consistent => "consistent",
        EdgeKind::Inconsistent => "inconsistent",
        EdgeKind::Boundary => "boundary",
    }
}

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
        "advice": report.seams.as_ref().map(Seams::text).into_iter().chain(report.advice()).collect::<Vec<_>>(),
        "bounds": report.bounds.map(|bounds| json_bounds(bounds, report.origin)),
    })
}

fn json_bounds(Bounds { min, max }: Bounds, origin: Origin) -> Value {
    json!({ "min": point(min.into(), origin).json(), "max": point(max.into(), origin).json() })
}

#[cfg(test)]
mod tests {
    use rimline::GeometryOptions;

    use super::*;

    #[test]
    fn an_open_mesh_says_why() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let geometry = Geometry::new(positions, vec![[0, 1, 2], [0, 1, 3]], GeometryOptions::default())
            .expect("the indices are in range");
        let report = MeshReport::of_geometry(&geometry, WeldCounts::default(), Origin::ZERO).expect("it is a mesh");
        let why = report.why_open().expect("it is open");
        assert_eq!(why, "4 edges have a face on one side only, 1 edge joins faces that are turned against each other");
        assert_eq!(report.listed_positions.len(), LISTED_EDGES);
        let total = MeshReport::total(&[report]);
        assert_eq!((total.faces, total.diagnostics.edges.boundary), (2, 4));
    }
}
