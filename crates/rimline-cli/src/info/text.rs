//! The report for people.

use std::fmt::{Display, Write as _};

use rimline::Origin;
use rimline::mesh::EdgeCounts;
use rimline_picture::Bounds;

use super::report::{MeshReport, kind_name};
use crate::coordinates;

pub(super) struct Text(String);

impl Text {
    pub(super) fn titled(title: &impl Display) -> Self {
        Self(format!("{title}\n"))
    }

    pub(super) fn line(&mut self, name: &str, value: impl Display) {
        let _ = writeln!(self.0, "  {name:<13} {value}");
    }

    /// A line below the one before.
    pub(super) fn more(&mut self, value: impl Display) {
        self.line("", value);
    }

    pub(super) fn heading(&mut self, title: impl Display) {
        let _ = writeln!(self.0, "\n{title}");
    }

    pub(super) fn finish(self) -> String {
        self.0
    }

    pub(super) fn mesh(&mut self, report: &MeshReport) {
        let at = |position| point(position, report.origin);
        let weld = report.vertices;
        let mut vertices = format!("{}", weld.after);
        if weld.before != weld.after {
            let _ = write!(vertices, ", welded from {}", weld.before);
        }
        if weld.apart > 0 {
            let _ = write!(vertices, ", {} kept apart by their skin or morph data", weld.apart);
        }
        self.line("vertices", vertices);
        let diagnostics = &report.diagnostics;
        let (duplicate, flipped) = (diagnostics.duplicate_faces, diagnostics.flipped_faces);
        let copies = match flipped {
            0 => "duplicate".to_owned(),
            _ => format!("duplicate ({flipped} flipped, so that both sides are fronts)"),
        };
        self.line(
            "faces",
            counted(
                report.faces,
                &[
                    (diagnostics.degenerate_faces, "degenerate"),
                    (report.vertices.collapsed, "of them collapsed by welding"),
                    (duplicate, &copies),
                ],
            ),
        );
        let EdgeCounts { consistent, inconsistent, boundary } = diagnostics.edges;
        let mut edges = counted(
            consistent + inconsistent + boundary,
            &[(consistent, "consistent"), (inconsistent, "inconsistent"), (boundary, "boundary")],
        );
        if diagnostics.non_manifold_edges > 0 {
            let _ = write!(edges, "; more than two faces at {} of them", diagnostics.non_manifold_edges);
        }
        self.line("edge records", edges);
        self.line("parts", diagnostics.components);
        match report.why_open() {
            None if report.faces == 0 => self.line("closed", "nothing to close: no faces"),
            None if report.faces == diagnostics.degenerate_faces => {
                self.line("closed", "nothing to close: no face has an area");
            }
            None => self.line("closed", "yes"),
            Some(why) => self.line("closed", format!("no: {why}")),
        }
        match diagnostics.inward_components {
            None | Some(0) => {}
            Some(1) => self.more("1 closed part is wound inwards: its faces are clockwise from outside"),
            Some(parts) => {
                self.more(format!("{parts} closed parts are wound inwards: their faces are clockwise from outside"));
            }
        }
        if let Some(seams) = &report.seams {
            self.more(seams.text());
        }
        if report.t_junctions > 0 {
            self.more(format!("{} T-junctions: vertices on boundary edges that end elsewhere", report.t_junctions));
        }
        for (edge, [a, b]) in diagnostics.listed_edges.iter().zip(&report.listed_positions) {
            let [va, vb] = edge.vertices;
            let kind = kind_name(edge.kind);
            self.more(format!("  {kind} edge {va}-{vb}, {} to {}", at(*a), at(*b)));
        }
        let listed = diagnostics.listed_edges.len();
        let all = inconsistent + boundary;
        if listed > 0 && all > listed {
            self.more(format!("  and {} more", all - listed));
        }
        for (index, advice) in report.advice().into_iter().enumerate() {
            self.line(if index == 0 { "to do" } else { "" }, advice);
        }
        if report.joints_per_vertex > 0 {
            self.line("skinned", format!("up to {} joints a vertex", report.joints_per_vertex));
        }
        if report.morph_targets > 0 {
            self.line("morph targets", report.morph_targets);
        }
        if let Some(Bounds { min, max }) = report.bounds {
            self.line("bounds", format!("{} to {}", at(min.into()), at(max.into())));
        }
    }
}

/// `12: 10 of this, 2 of that`, what is zero left out.
fn counted(all: usize, parts: &[(usize, &str)]) -> String {
    let parts: Vec<String> =
        parts.iter().filter(|(count, _)| *count > 0).map(|(count, name)| format!("{count} {name}")).collect();
    if parts.is_empty() { all.to_string() } else { format!("{all}: {}", parts.join(", ")) }
}

/// A point in the file's coordinates.
pub(super) fn point(point: [f32; 3], origin: Origin) -> String {
    format!("({})", coordinates::point(point, origin).to_string().replace(',', ", "))
}
