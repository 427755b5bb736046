//! The counts and times that `extract` prints.

use std::fmt::Write as _;
use std::path::Path;

use rimline::mesh::EdgeCounts;
use rimline::reference::Method;
use rimline::reference::cpu::FacingStatistics;
use rimline::{Light, Mesh, Origin, Predicate};
use rimline_bench::error_metrics::light_counts;
use serde_json::json;

use super::Found;
use crate::coordinates::{add_origin, origin_text};
use crate::shown::Line;
use crate::times::Times;

pub(super) struct Report {
    vertices: usize,
    faces: usize,
    /// The number of twisted polygons for each light, if the mesh has polygons.
    polygons: Option<Vec<usize>>,
    degenerate_faces: usize,
    statistics: FacingStatistics,
    edges: EdgeCounts,
    /// One a light.
    silhouette_edges: Vec<usize>,
    unclosed_vertices: Vec<usize>,
    method: Method,
    predicate: Predicate,
    origin: Origin,
    adapter: String,
    times: Times,
}

impl Report {
    pub(super) fn new(
        mesh: &Mesh,
        lights: &[Light],
        found: &Found<'_>,
        (method, predicate): (Method, Predicate),
        origin: Origin,
        adapter: String,
        times: Times,
    ) -> Self {
        let counts = light_counts(mesh, &found.masks, &found.twisted, lights.len()).into_iter();
        let (silhouette_edges, unclosed_vertices) =
            counts.map(|light| (light.silhouette_edges, light.unclosed_vertices)).unzip();
        Self {
            vertices: found.positions.len(),
            faces: mesh.face_count(),
            polygons: mesh.polygons().map(|_| twisted(mesh, &found.twisted, lights.len())),
            degenerate_faces: mesh.degenerate_faces(),
            statistics: found.statistics,
            edges: mesh.edges().counts(),
            silhouette_edges,
            unclosed_vertices,
            method,
            predicate,
            origin,
            adapter,
            times,
        }
    }

    fn method(&self) -> &'static str {
        match self.method {
            Method::FaceMask => "face-mask",
            Method::PerEdge => "per-edge",
        }
    }

    fn predicate(&self) -> &'static str {
        match self.predicate {
            Predicate::Exact => "exact",
            Predicate::Fast => "fast",
            Predicate::Plane => "plane",
            _ => "other",
        }
    }

    /// Keys are stable: they are only ever added to. Lists have an entry a light, in the order given.
    pub(super) fn json(&self) -> String {
        let EdgeCounts { consistent, inconsistent, boundary } = self.edges;
        let [set_up, work] = self.times.set_up_and_work();
        let mut report = json!({
            "adapter": self.adapter,
            "method": self.method(),
            "predicate": self.predicate(),
            "vertices": self.vertices,
            "faces": self.faces,
            "degenerate_faces": self.degenerate_faces,
            "non_finite_faces": self.statistics.non_finite_faces,
            "undecided_pairs": self.statistics.undecided_pairs,
            "exact_zeros": self.statistics.exact_zeros,
            "edges": { "consistent": consistent, "inconsistent": inconsistent, "boundary": boundary },
            "lights": self.silhouette_edges.len(),
            "silhouette_edges": self.silhouette_edges,
            "unclosed_vertices": self.unclosed_vertices,
            "twisted_polygons": self.polygons,
            "milliseconds": self.times.json(),
            "set_up_milliseconds": set_up,
            "work_milliseconds": work,
        });
        add_origin(&mut report, self.origin);
        format!("{report:#}\n")
    }

    pub(super) fn text(&self, out: &Path) -> String {
        let EdgeCounts { consistent, inconsistent, boundary } = self.edges;
        let mut text = String::new();
        let mut line = |name: &str, value: &str| {
            let _ = writeln!(text, "{name:<18} {value}");
        };
        line("device", &self.adapter);
        line("vertices", &self.vertices.to_string());
        line("faces", &self.faces.to_string());
        if let Some(origin) = origin_text(self.origin) {
            line("origin", &origin);
        }
        let FacingStatistics { non_finite_faces, undecided_pairs, exact_zeros } = self.statistics;
        if non_finite_faces > 0 {
            line("", &format!("{non_finite_faces} with a position that is not finite: they face no light"));
        }
        if undecided_pairs > 0 {
            let decided = format!("{undecided_pairs} pairs of face and light, {exact_zeros} of them in one plane");
            line("decided exactly", &decided);
        }
        if let Some(twisted) = &self.polygons {
            line("twisted polygons", &per_light(twisted));
        }
        line("edge records", &format!("{consistent} consistent, {inconsistent} inconsistent, {boundary} boundary"));
        line("silhouette edges", &per_light(&self.silhouette_edges));
        line("unclosed vertices", &per_light(&self.unclosed_vertices));
        line("milliseconds", &self.times.sums());
        line("by stage", &self.times.text());
        let _ = writeln!(text, "wrote {}", Line(out.display()));
        text
    }
}

fn twisted(mesh: &Mesh, masks: &[u32], lights: usize) -> Vec<usize> {
    let plane = |light: usize| masks.iter().skip(light / 32 * mesh.face_count()).take(mesh.face_count());
    (0..lights).map(|light| plane(light).filter(|&&mask| mask >> (light % 32) & 1 != 0).count()).collect()
}

/// A number a light; many lights are summed up.
pub(crate) fn per_light(counts: &[usize]) -> String {
    const SHOWN: usize = 8;
    let shown: Vec<String> = counts.iter().take(SHOWN).map(usize::to_string).collect();
    if counts.len() > SHOWN {
        let (all, lights) = (counts.iter().sum::<usize>(), counts.len());
        format!("{}, … ({all} for {lights} lights)", shown.join(", "))
    } else {
        shown.join(", ")
    }
}
