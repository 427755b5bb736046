//! The mesh: faces over welded vertices, and their edge records.

use std::sync::atomic::{AtomicU64, Ordering};

use super::topology::{EdgeCounts, EdgeRecords, is_degenerate};
use super::weld::{self, Weld, WeldCounts};

/// The largest number of faces of a mesh. An edge's index and its winding bit share one `u32` in the edge lists, and a
/// mesh has at most three edge records for each face.
pub const MAX_FACES: usize = (1 << 31) / 3;

/// The faces of a mesh over welded vertices, and the edge records between them. Positions are not kept.
///
/// Vertices keep the caller's numbering. Faces and records name each welded group by its lowest source index, so the
/// stages read the caller's own position buffer as it is.
///
/// Memory besides positions and indices: 16 bytes for each edge record. That is 24 bytes a face on closed meshes (1.5
/// records a face), and at most 48 bytes (no two faces share an edge).
#[derive(Clone, Debug)]
pub struct Mesh {
    id: MeshId,
    vertex_count: u32,
    faces: Vec<[u32; 3]>,
    edges: EdgeRecords,
    weld: WeldCounts,
}

/// The identity of a mesh. A clone has the identity of its original, because a mesh never changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MeshId(u64);

impl MeshId {
    fn next() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// Compares vertex counts, faces, records and weld counts.
impl PartialEq for Mesh {
    fn eq(&self, other: &Self) -> bool {
        let Self { id: _, vertex_count, faces, edges, weld } = self;
        (vertex_count, faces, edges, weld) == (&other.vertex_count, &other.faces, &other.edges, &other.weld)
    }
}

impl Eq for Mesh {}

impl Mesh {
    /// Welds vertices and builds the edge records. `faces` are counter-clockwise triangles, as indices into
    /// `positions`. Positions may be non-finite; their faces never face a light. There is no skin or morph data here,
    /// so [`Weld::Data`] and [`Weld::Position`] do the same.
    ///
    /// # Errors
    /// [`MeshError`] for no faces, too many faces or vertices, or an index out of range.
    pub fn new(positions: &[[f32; 3]], faces: &[[u32; 3]], weld: Weld) -> Result<Self, MeshError> {
        check(positions.len(), faces)?;
        let (groups, counts) = weld::weld_positions(positions, weld);
        let faces = match weld {
            Weld::Keep => faces.to_vec(),
            _ => faces.iter().map(|face| face.map(|v| groups[v as usize])).collect(),
        };
        Ok(Self::build(positions.len(), faces, counts))
    }

    /// Builds the edge records of counter-clockwise triangles. `faces` are indices below `vertex_count`, and the
    /// vertices are already welded.
    ///
    /// # Errors
    /// [`MeshError`] for no faces, too many faces or vertices, or an index out of range.
    pub fn from_faces(vertex_count: usize, faces: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        check(vertex_count, &faces)?;
        Ok(Self::build(vertex_count, faces, WeldCounts::kept(vertex_count)))
    }

    fn build(vertex_count: usize, faces: Vec<[u32; 3]>, weld: WeldCounts) -> Self {
        let edges = EdgeRecords::build(vertex_count, &faces);
        Self { id: MeshId::next(), vertex_count: vertex_count as u32, faces, edges, weld }
    }

    /// The identity of this mesh.
    pub(crate) fn id(&self) -> MeshId {
        self.id
    }

    /// The number of source vertices, including those that were welded to others. A position buffer must hold so many.
    pub fn vertex_count(&self) -> u32 {
        self.vertex_count
    }

    /// Counter-clockwise triangles in the order given, as vertex indices. Degenerate faces are included.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// The edge records.
    pub fn edges(&self) -> &EdgeRecords {
        &self.edges
    }

    /// What welding did.
    pub fn weld_counts(&self) -> WeldCounts {
        self.weld
    }

    /// Whether every record is of kind [`EdgeKind::Consistent`](crate::mesh::EdgeKind::Consistent): the mesh is closed and consistently oriented.
    pub fn is_closed(&self) -> bool {
        let EdgeCounts { inconsistent, boundary, .. } = self.edges.counts();
        inconsistent == 0 && boundary == 0
    }

    /// The number of faces that name a vertex twice. They face no light and have no edge records.
    pub fn degenerate_faces(&self) -> usize {
        self.faces.iter().filter(|face| is_degenerate(**face)).count()
    }

    /// The size of the edge records in memory, in bytes: 16 for each record.
    pub fn edge_record_bytes(&self) -> usize {
        self.edges.bytes()
    }
}

fn check(vertex_count: usize, faces: &[[u32; 3]]) -> Result<(), MeshError> {
    if faces.is_empty() {
        return Err(MeshError::NoFaces);
    }
    if faces.len() > MAX_FACES {
        return Err(MeshError::TooManyFaces { faces: faces.len() });
    }
    if vertex_count >= u32::MAX as usize {
        return Err(MeshError::TooManyVertices { vertices: vertex_count });
    }
    for (face, corners) in faces.iter().enumerate() {
        if let Some(corner) = corners.iter().position(|&v| v as usize >= vertex_count) {
            return Err(MeshError::IndexOutOfRange { face, corner, index: corners[corner], vertices: vertex_count });
        }
    }
    Ok(())
}

/// Why a mesh is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// There are no faces, so there is no silhouette.
    #[error("the mesh has no faces; a silhouette needs triangles")]
    NoFaces,
    /// There are more faces than [`MAX_FACES`].
    #[error("the mesh has {faces} faces, more than the {MAX_FACES} that edge indices can count; split it")]
    TooManyFaces {
        /// Faces given.
        faces: usize,
    },
    /// There are more vertices than `u32` indices can name.
    #[error("the mesh has {vertices} vertices, more than u32 indices can name; split it")]
    TooManyVertices {
        /// Vertices given.
        vertices: usize,
    },
    /// A face names a vertex that does not exist.
    #[error("face {face} names vertex {index} at corner {corner}, but there are {vertices} vertices")]
    IndexOutOfRange {
        /// The face's index.
        face: usize,
        /// 0, 1 or 2.
        corner: usize,
        /// The vertex that it names.
        index: u32,
        /// Vertices of the mesh.
        vertices: usize,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_are_equal_by_what_they_hold() {
        let mesh = |vertices, faces: &[[u32; 3]]| Mesh::from_faces(vertices, faces.to_vec()).expect("good indices");
        let one = mesh(4, &[[0, 1, 2], [2, 1, 3]]);
        assert_eq!(one, mesh(4, &[[0, 1, 2], [2, 1, 3]]), "made anew");
        assert_eq!(one, one.clone());
        for other in [mesh(5, &[[0, 1, 2], [2, 1, 3]]), mesh(4, &[[0, 1, 2], [1, 2, 3]]), mesh(4, &[[0, 1, 2]])] {
            assert_ne!(one, other);
        }
    }

    /// A list entry has 31 bits for an edge record, of which a face has three at most.
    #[test]
    fn as_many_faces_as_edge_indices_can_count() {
        let records = 3 * MAX_FACES as u64;
        assert!(records <= 1 << 31 && records + 3 > 1 << 31);
    }
}
