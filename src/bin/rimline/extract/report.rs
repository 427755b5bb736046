//! The counts and times that `extract` prints.

use std::fmt::Write as _;
use std::path::Path;

use rimline::cpu::FacingCounts;
use rimline::layout::Masks;
use rimline::mesh::{EdgeCounts, EdgeKind};
use rimline::{Light, Mesh, Method};
use serde_json::json;

use super::Found;
use crate::times::Times;

/// What came out, in numbers.
pub(super) struct Report {
    vertices: usize,
    faces: usize,
    degenerate_faces: usize,
    counts: FacingCounts,
    edges: EdgeCounts,
    /// One a light.
    silhouette_edges: Vec<usize>,
    unclosed_vertices: Vec<usize>,
    method: Method,
    adapter: String,
    times: Times,
}

impl Report {
    pub(super) fn new(
        mesh: &Mesh,
        lights: &[Light],
        found: &Found<'_>,
        method: Method,
        adapter: String,
        times: Times,
    ) -> Self {
        let edges = mesh.edges().len();
        let mut sums = vec![0; mesh.vertex_count() as usize];
        let (silhouette_edges, unclosed_vertices) = (0..lights.len())
            .map(|light| {
                let plane = &found.masks[light / 32 * edges..][..edges];
                count_light(mesh, plane, light as u32 % 32, &mut sums)
            })
            .unzip();
        Self {
            vertices: found.positions.len(),
            faces: mesh.faces().len(),
            degenerate_faces: mesh.degenerate_faces(),
            counts: found.counts,
            edges: mesh.edges().counts(),
            silhouette_edges,
            unclosed_vertices,
            method,
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

    /// Keys are stable: they are only ever added to. Lists have an entry a light, in the order given.
    pub(super) fn json(&self) -> String {
        let EdgeCounts { consistent, inconsistent, boundary } = self.edges;
        let report = json!({
            "adapter": self.adapter,
            "method": self.method(),
            "vertices": self.vertices,
            "faces": self.faces,
            "degenerate_faces": self.degenerate_faces,
            "non_finite_faces": self.counts.non_finite_faces,
            "undecided_pairs": self.counts.undecided_pairs,
            "exact_zeros": self.counts.exact_zeros,
            "edges": { "consistent": consistent, "inconsistent": inconsistent, "boundary": boundary },
            "lights": self.silhouette_edges.len(),
            "silhouette_edges": self.silhouette_edges,
            "unclosed_vertices": self.unclosed_vertices,
            "milliseconds": self.times.json(),
        });
        format!("{report:#}\n")
    }

    pub(super) fn text(&self, out: &Path) -> String {
        let EdgeCounts { consistent, inconsistent, boundary } = self.edges;
        let mut text = String::new();
        let mut line = |name: &str, value: &str| {
            let _ = writeln!(text, "{name:<18} {value}");
        };
        line("adapter", &self.adapter);
        line("vertices", &self.vertices.to_string());
        line("faces", &self.faces.to_string());
        let FacingCounts { non_finite_faces, undecided_pairs, exact_zeros } = self.counts;
        if non_finite_faces > 0 {
            line("", &format!("{non_finite_faces} not finite: they face no light"));
        }
        if undecided_pairs > 0 {
            let decided = format!("{undecided_pairs} pairs of face and light, {exact_zeros} of them in one plane");
            line("decided exactly", &decided);
        }
        line("edge records", &format!("{consistent} consistent, {inconsistent} inconsistent, {boundary} boundary"));
        line("silhouette edges", &per_light(&self.silhouette_edges));
        line("unclosed vertices", &per_light(&self.unclosed_vertices));
        line("milliseconds", &self.times.text());
        line("written", &out.display().to_string());
        text
    }
}

/// A number a light; many lights are summed up.
fn per_light(counts: &[usize]) -> String {
    const SHOWN: usize = 8;
    let shown: Vec<String> = counts.iter().take(SHOWN).map(usize::to_string).collect();
    if counts.len() > SHOWN {
        let (all, lights) = (counts.iter().sum::<usize>(), counts.len());
        format!("{}, … ({all} for {lights} lights)", shown.join(", "))
    } else {
        shown.join(", ")
    }
}

/// A light's silhouette edges, and the vertices where outgoing less incoming multiplicities are not zero. `sums` has
/// a zero for each vertex, and has so again afterwards.
fn count_light(mesh: &Mesh, plane: &[Masks], bit: u32, sums: &mut [i32]) -> (usize, usize) {
    let mut silhouettes = 0;
    for (edge, masks) in mesh.edges().iter().zip(plane) {
        if masks.silhouette >> bit & 1 == 0 {
            continue;
        }
        silhouettes += 1;
        // Where it is a silhouette, both terms of the multiplicity have face 0's sign.
        let weight = if edge.kind == EdgeKind::Boundary { 1 } else { 2 };
        let multiplicity = if masks.winding >> bit & 1 == 1 { weight } else { -weight };
        let [a, b] = edge.vertices;
        sums[a as usize] += multiplicity;
        sums[b as usize] -= multiplicity;
    }
    let unclosed = sums.iter().filter(|sum| **sum != 0).count();
    sums.fill(0);
    (silhouettes, unclosed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rimline::cpu::{Threads, edges, facing};
    use rimline::method::Predicate;

    #[test]
    fn closed_loops_sum_to_zero_and_a_flipped_bit_does_not() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mesh = Mesh::from_faces(4, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).expect("it is a tetrahedron");
        let lights = [Light::point([3.0, 3.0, 3.0]), Light::directional([0.0, 0.0, -1.0])];
        let facing = facing(&positions, mesh.faces(), &lights, Predicate::Exact, Threads::ONE);
        let mut masks = edges(mesh.edges(), &facing, 4, 2, Threads::ONE);
        let mut sums = [0; 4];
        for (bit, silhouettes) in [(0, 3), (1, 3)] {
            assert_eq!(count_light(&mesh, &masks, bit, &mut sums), (silhouettes, 0));
        }
        masks[0].silhouette ^= 1;
        assert_eq!(count_light(&mesh, &masks, 0, &mut sums).1, 2);
        assert_eq!(count_light(&mesh, &masks, 1, &mut sums).1, 0);
    }

    #[test]
    fn an_open_mesh_closes_too() {
        let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mesh = Mesh::from_faces(3, vec![[0, 1, 2]]).expect("it is a triangle");
        let facing =
            facing(&positions, mesh.faces(), &[Light::directional([0.0, 0.0, 1.0])], Predicate::Exact, Threads::ONE);
        let masks = edges(mesh.edges(), &facing, 1, 1, Threads::ONE);
        assert_eq!(count_light(&mesh, &masks, 0, &mut [0; 3]), (3, 0));
    }
}
