//! Diagnostics of a mesh: whether it is closed and, if it is not, where it is open.

use super::faces::Mesh;
use super::topology::{Edge, EdgeCounts, EdgeKind, is_degenerate};

/// Result of [`MeshDiagnostics::of`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshDiagnostics {
    /// The number of parts that share no vertex with each other. Degenerate faces do not count.
    pub components: usize,
    /// The number of edge records of each kind.
    pub edges: EdgeCounts,
    /// The number of undirected edges where more than two faces meet. Each has several records.
    pub non_manifold_edges: usize,
    /// The number of faces that name a vertex twice. They keep their place in the list, face no light and have no edge
    /// records.
    pub degenerate_faces: usize,
    /// The number of faces with the same three vertices as an earlier face, in any order. Degenerate faces do not
    /// count.
    pub duplicate_faces: usize,
    /// The number of flipped copies, which are among [`Self::duplicate_faces`]: for each three vertices, the faces of the
    /// direction that has fewer. Both sides of such a face are seen, and drawing them at one depth takes care.
    pub flipped_faces: usize,
    /// The first records that are not of kind [`EdgeKind::Consistent`]. They are the reason why the mesh is not closed.
    pub listed_edges: Vec<Edge>,
}

impl MeshDiagnostics {
    /// Examines a mesh. `edge_limit` is the largest number of edges in [`Self::listed_edges`]. It takes about as long as
    /// sorting the faces.
    pub fn of(mesh: &Mesh, edge_limit: usize) -> Self {
        let is_listed = |edge: &Edge| edge.kind != EdgeKind::Consistent;
        let (duplicate_faces, flipped_faces) = copies(mesh.faces());
        Self {
            components: components(mesh.vertex_count() as usize, mesh.faces()),
            edges: mesh.edges().counts(),
            non_manifold_edges: non_manifold_edges(mesh.edges().vertices()),
            degenerate_faces: mesh.degenerate_faces(),
            duplicate_faces,
            flipped_faces,
            listed_edges: mesh.edges().iter().filter(is_listed).take(edge_limit).collect(),
        }
    }

    /// Whether every record is of kind [`EdgeKind::Consistent`]. A mesh with only degenerate faces has no records, so
    /// it counts as closed.
    pub fn is_closed(&self) -> bool {
        self.edges.boundary == 0 && self.edges.inconsistent == 0
    }
}

/// The number of components. Trees of vertices are joined along the faces; each root that a face leads to is a
/// component.
fn components(vertex_count: usize, faces: &[[u32; 3]]) -> usize {
    fn root(parents: &mut [u32], mut vertex: u32) -> u32 {
        while parents[vertex as usize] != vertex {
            let grandparent = parents[parents[vertex as usize] as usize];
            parents[vertex as usize] = grandparent;
            vertex = grandparent;
        }
        vertex
    }
    let mut parents: Vec<u32> = (0..vertex_count as u32).collect();
    let mut used = vec![false; vertex_count];
    for &[a, b, c] in faces.iter().filter(|face| !is_degenerate(**face)) {
        let first = root(&mut parents, a);
        for vertex in [b, c] {
            let other = root(&mut parents, vertex);
            // The higher root becomes a child of the lower one. This is cheap and, with the path halving above, nearly
            // linear.
            let (low, high) = (parents[first as usize].min(other), parents[first as usize].max(other));
            parents[high as usize] = low;
            parents[first as usize] = low;
        }
        for vertex in [a, b, c] {
            used[vertex as usize] = true;
        }
    }
    (0..vertex_count).filter(|&v| used[v] && parents[v] as usize == v).count()
}

/// The number of edges with more than one record. k faces at an edge make ⌈k / 2⌉ records, so more than one record
/// means more than two faces.
fn non_manifold_edges(records: &[[u32; 2]]) -> usize {
    let mut keys: Vec<[u32; 2]> = records.iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
    keys.sort_unstable();
    keys.chunk_by(|a, b| a == b).filter(|run| run.len() > 1).count()
}

/// The numbers of duplicate and of flipped faces.
fn copies(faces: &[[u32; 3]]) -> (usize, usize) {
    let mut keys: Vec<([u32; 3], bool)> = faces
        .iter()
        .filter(|face| !is_degenerate(**face))
        .map(|&[a, b, c]| {
            let mut key = [a, b, c];
            key.sort_unstable();
            (key, key != [a, b, c] && key != [b, c, a] && key != [c, a, b])
        })
        .collect();
    keys.sort_unstable();
    let runs = keys.chunk_by(|one, other| one.0 == other.0).map(|run| {
        let flipped = run.iter().filter(|key| key.1).count();
        (run.len() - 1, flipped.min(run.len() - flipped))
    });
    runs.fold((0, 0), |(duplicates, flipped), run| (duplicates + run.0, flipped + run.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn diagnose(vertices: usize, faces: &[[u32; 3]]) -> MeshDiagnostics {
        MeshDiagnostics::of(&Mesh::from_faces(vertices, faces.to_vec()).expect("indices are in range"), 2)
    }

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];

    #[test]
    fn a_tetrahedron_is_one_closed_part() {
        let found = diagnose(4, &TETRAHEDRON);
        assert!(found.is_closed());
        assert_eq!((found.components, found.edges.consistent), (1, 6));
        assert_eq!((found.non_manifold_edges, found.duplicate_faces), (0, 0));
        assert_eq!(found.listed_edges, []);
    }

    #[test]
    fn two_apart_and_one_touching_vertex() {
        let shifted = |by: u32| TETRAHEDRON.map(|face| face.map(|v| v + by));
        let apart = [TETRAHEDRON, shifted(4)].concat();
        assert_eq!(diagnose(9, &apart).components, 2);
        let touching = [TETRAHEDRON, shifted(3)].concat();
        assert_eq!(diagnose(7, &touching).components, 1);
    }

    #[test]
    fn parts_met_in_any_order_join() {
        // The triangles are separate at first, and the last ones join them: roots change after they were taken.
        let faces = [[6, 7, 8], [3, 4, 5], [0, 1, 2], [8, 5, 9], [9, 2, 10]];
        assert_eq!(diagnose(11, &faces).components, 1);
        assert_eq!(diagnose(11, &faces[..4]).components, 2);
    }

    #[test]
    fn an_open_mesh_names_its_first_open_edges() {
        let found = diagnose(4, &TETRAHEDRON[1..]);
        assert!(!found.is_closed());
        assert_eq!(found.edges.boundary, 3);
        assert_eq!(found.listed_edges.len(), 2);
        assert_eq!(found.listed_edges[0].vertices, [1, 0]);
    }

    #[test]
    fn three_faces_at_an_edge_and_repeated_ones_are_counted() {
        let found = diagnose(5, &[[0, 1, 2], [1, 0, 3], [0, 1, 4], [2, 1, 0], [3, 3, 4]]);
        assert_eq!(found.non_manifold_edges, 1);
        assert_eq!((found.duplicate_faces, found.degenerate_faces), (1, 1));
        assert_eq!(found.flipped_faces, 1);
    }

    #[test]
    fn flipped_copies_are_counted_by_direction() {
        // Two copies as the face is, one turned, another turned twice.
        let faces = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [3, 2, 1], [1, 3, 2], [2, 3, 1]];
        let found = diagnose(4, &faces);
        assert_eq!((found.duplicate_faces, found.flipped_faces), (5, 2));
        assert_eq!(diagnose(4, &faces[..3]).flipped_faces, 0);
        assert_eq!(diagnose(4, &[[0, 0, 1], [0, 1, 0]]).flipped_faces, 0);
    }
}
