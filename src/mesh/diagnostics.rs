//! Diagnostics of a mesh: whether it is closed and, if it is not, where it is open.

use glam::DVec3;

use super::faces::Mesh;
use super::topology::{Edge, EdgeCounts, EdgeKind, is_degenerate};
use super::weld::root;

/// Result of [`MeshDiagnostics::of`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshDiagnostics {
    /// The number of parts that share no vertex with each other. Degenerate faces do not count.
    pub components: usize,
    /// The number of edge records of each kind.
    pub edges: EdgeCounts,
    /// The number of undirected edges where more than two faces meet. Each has several records.
    pub non_manifold_edges: usize,
    /// The number of faces that name a vertex twice or, in a mesh of polygons, of polygons without a boundary:
    /// [`Mesh::degenerate_faces`]. They face no light and have no edge records.
    pub degenerate_faces: usize,
    /// The number of faces with the same three vertices as an earlier face, in any order. Degenerate faces do not
    /// count. In a mesh of polygons this and the next field count triangles.
    pub duplicate_faces: usize,
    /// The number of flipped copies, which are among [`Self::duplicate_faces`]: for each three vertices, the faces of the
    /// direction that has fewer. Both sides of such a face are seen, and drawing them at one depth takes care.
    pub flipped_faces: usize,
    /// The number of closed parts that are wound inwards: their signed volume is negative. A cavity is wound inwards,
    /// too. `None`: no positions were given. See [`Self::of_placed`].
    pub inward_components: Option<usize>,
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
            components: Components::of(mesh).count(),
            edges: mesh.edges().counts(),
            non_manifold_edges: non_manifold_edges(mesh.edges().vertices()),
            degenerate_faces: mesh.degenerate_faces(),
            duplicate_faces,
            flipped_faces,
            inward_components: None,
            listed_edges: mesh.edges().iter().filter(is_listed).take(edge_limit).collect(),
        }
    }

    /// The same, and whether closed parts are wound inwards. `positions` has one for each vertex of the mesh; those
    /// that are missing are at the origin. A part without a volume, such as two faces back to back, and one with a
    /// position that is not finite are not wound inwards.
    pub fn of_placed(mesh: &Mesh, positions: &[[f32; 3]], edge_limit: usize) -> Self {
        Self { inward_components: Some(Components::of(mesh).inward(mesh, positions)), ..Self::of(mesh, edge_limit) }
    }

    /// Whether every record is of kind [`EdgeKind::Consistent`]. A mesh with only degenerate faces has no records, so
    /// it counts as closed.
    pub fn is_closed(&self) -> bool {
        self.edges.boundary == 0 && self.edges.inconsistent == 0
    }
}

/// A volume below this share of the sum of its terms is none: each term is off by a few units of `f64`.
const LEAST_VOLUME: f64 = 1e-12;

/// The component of each vertex: its lowest vertex. `None` for vertices without a face.
struct Components(Vec<Option<u32>>);

impl Components {
    /// Joins trees of vertices along the faces.
    fn of(mesh: &Mesh) -> Self {
        let vertex_count = mesh.vertex_count();
        let mut parents: Vec<u32> = (0..vertex_count).collect();
        let mut used = vec![false; vertex_count as usize];
        for &[a, b, c] in mesh.faces().iter().filter(|face| !is_degenerate(**face)) {
            let first = root(&mut parents, a);
            for vertex in [b, c] {
                let other = root(&mut parents, vertex);
                // The higher root becomes a child of the lower one. This is cheap and, with the path halving of `root`,
                // nearly linear.
                let (low, high) = (parents[first as usize].min(other), parents[first as usize].max(other));
                parents[high as usize] = low;
                parents[first as usize] = low;
            }
            for vertex in [a, b, c] {
                used[vertex as usize] = true;
            }
        }
        Self((0..vertex_count).map(|vertex| used[vertex as usize].then(|| root(&mut parents, vertex))).collect())
    }

    fn count(&self) -> usize {
        (0..).zip(&self.0).filter(|(vertex, root)| **root == Some(*vertex)).count()
    }

    /// The number of closed components of negative volume.
    fn inward(&self, mesh: &Mesh, positions: &[[f32; 3]]) -> usize {
        let mut is_open = vec![false; self.0.len()];
        for edge in mesh.edges().iter().filter(|edge| edge.kind != EdgeKind::Consistent) {
            if let Some(root) = self.0[edge.vertices[0] as usize] {
                is_open[root as usize] = true;
            }
        }
        let at = |vertex: u32| DVec3::from(positions.get(vertex as usize).copied().unwrap_or_default().map(f64::from));
        // Six times the volume of each component, and the sum of the terms' sizes.
        let mut volumes = vec![[0.0_f64; 2]; self.0.len()];
        for &[a, b, c] in mesh.faces().iter().filter(|face| !is_degenerate(**face)) {
            let Some(root) = self.0[a as usize] else { continue };
            // From a point of the component, so that its position has no effect.
            let [a, b, c] = [a, b, c].map(|vertex| at(vertex) - at(root));
            let [sum, size] = &mut volumes[root as usize];
            *sum += a.dot(b.cross(c));
            *size += a.length() * b.length() * c.length();
        }
        volumes.iter().zip(is_open).filter(|([sum, size], is_open)| !is_open && *sum < -LEAST_VOLUME * size).count()
    }
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
    fn components_are_counted_by_common_edges_and_vertices() {
        let with = |by: u32| [TETRAHEDRON, TETRAHEDRON.map(|face| face.map(|v| v + by))].concat();
        // The last triangles join the others: roots change after they were read.
        let late = [[6, 7, 8], [3, 4, 5], [0, 1, 2], [8, 5, 9], [9, 2, 10]];
        for (faces, components) in
            [(&TETRAHEDRON[..], 1), (&with(4), 2), (&with(3), 1), (&late, 1), (&late[..4], 2), (&[[0, 0, 1]], 0)]
        {
            assert_eq!(diagnose(11, faces).components, components, "{faces:?}");
        }
    }

    const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    #[test]
    fn closed_parts_that_are_wound_inwards_are_counted() {
        let outwards = TETRAHEDRON.map(|[a, b, c]| [a, c, b]);
        let inward = |faces: &[[u32; 3]], positions: &[[f32; 3]]| {
            let mesh = Mesh::from_faces(positions.len(), faces.to_vec()).expect("indices are in range");
            MeshDiagnostics::of_placed(&mesh, positions, 0).inward_components
        };
        assert_eq!(diagnose(4, &TETRAHEDRON).inward_components, None);
        // Far from the origin as near it, at any size.
        for (size, at) in [(1.0, 0.0), (1e-3, 4096.0), (1e12, -1e15), (1e-12, 0.0)] {
            let placed: Vec<_> = CORNERS.iter().map(|corner| corner.map(|c| c * size + at)).collect();
            assert_eq!([inward(&outwards, &placed), inward(&TETRAHEDRON, &placed)], [Some(0), Some(1)], "{size}, {at}");
            let mirrored: Vec<_> = placed.iter().map(|&[x, y, z]| [-x, y, z]).collect();
            assert_eq!([inward(&outwards, &mirrored), inward(&TETRAHEDRON, &mirrored)], [Some(1), Some(0)]);
        }
        // Each part by itself; open, flat and infinite ones are not wound inwards.
        let both = [outwards, TETRAHEDRON.map(|face| face.map(|vertex| vertex + 4))].concat();
        assert_eq!(inward(&both, &[CORNERS, CORNERS].concat()), Some(1));
        for (faces, positions) in [
            (&TETRAHEDRON[1..], CORNERS),
            (&[[0, 1, 2], [0, 2, 1]], CORNERS),
            (&TETRAHEDRON, CORNERS.map(|[x, y, _]| [x, y, 0.1 * x + 0.3 * y])),
            (&TETRAHEDRON, CORNERS.map(|[x, y, z]| [x, y, z / 0.0])),
        ] {
            assert_eq!(inward(faces, &positions), Some(0), "{faces:?}, {positions:?}");
        }
    }

    #[test]
    fn edges_and_copies_are_counted() {
        let found = diagnose(4, &TETRAHEDRON);
        assert!(found.is_closed() && found.listed_edges.is_empty(), "{found:?}");
        assert_eq!((found.edges.consistent, found.non_manifold_edges, found.duplicate_faces), (6, 0, 0));
        let found = diagnose(4, &TETRAHEDRON[1..]);
        assert!(!found.is_closed());
        assert_eq!((found.edges.boundary, found.listed_edges.len(), found.listed_edges[0].vertices), (3, 2, [1, 0]));
        // Three faces at an edge, a copy that is turned, a degenerate one.
        let found = diagnose(5, &[[0, 1, 2], [1, 0, 3], [0, 1, 4], [2, 1, 0], [3, 3, 4]]);
        assert_eq!((found.non_manifold_edges, found.degenerate_faces), (1, 1));
        assert_eq!((found.duplicate_faces, found.flipped_faces), (1, 1));
        // Two copies as the face is, one turned, another turned twice.
        let faces = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [3, 2, 1], [1, 3, 2], [2, 3, 1]];
        let found = diagnose(4, &faces);
        assert_eq!((found.duplicate_faces, found.flipped_faces), (5, 2));
        assert_eq!(diagnose(4, &faces[..3]).flipped_faces, 0);
        assert_eq!(diagnose(4, &[[0, 0, 1], [0, 1, 0]]).flipped_faces, 0);
    }
}
