//! The mesh: faces over welded vertices, and their edge records.

use std::sync::atomic::{AtomicU64, Ordering};

use super::error::{MeshError, check_counts};
use super::polygons::{PolygonLoops, Polygons, Welded};
use super::topology::{EdgeCounts, EdgeRecords, is_degenerate};
use super::weld::{self, Weld, WeldCounts};

/// The faces of a mesh over welded vertices, and the edge records between them. It has no positions.
///
/// Faces are triangles, or polygons by [`Self::from_polygons_by_loop`]. A mesh of such polygons also has triangles, which
/// are its surface. Edge records name polygons, because a polygon is one face. Extractions return a facing mask for each
/// triangle, the same for all of a polygon.
///
/// Vertices keep the caller's numbering. Faces and records name each welded group by its lowest source index, or by the
/// vertex at its smallest position where vertices are welded by distance. So the stages read the caller's own position
/// buffer as it is.
///
/// Memory beside positions and indices: 16 bytes for each edge record. A closed mesh takes 24 bytes a face (1.5 records a
/// face). The most is 48 bytes (no two faces share an edge).
#[derive(Clone, Debug)]
pub struct Mesh {
    pub(crate) id: MeshId,
    vertex_count: u32,
    /// The faces, or the triangles of the polygons.
    faces: Vec<[u32; 3]>,
    polygons: Option<Polygons>,
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

/// Compares vertex counts, faces, polygons, records and weld counts.
impl PartialEq for Mesh {
    fn eq(&self, other: &Self) -> bool {
        let Self { id, vertex_count, faces, polygons, edges, weld } = self;
        *id == other.id
            || (vertex_count, faces, polygons, edges, weld)
                == (&other.vertex_count, &other.faces, &other.polygons, &other.edges, &other.weld)
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
        let (groups, mut counts) = weld::weld_positions(positions, weld);
        let welded = match weld {
            Weld::Keep => faces.to_vec(),
            _ => faces.iter().map(|face| face.map(|v| groups[v as usize])).collect(),
        };
        counts.collapsed = weld::collapsed(faces, &welded);
        Ok(Self::build(positions.len(), welded, counts))
    }

    /// Builds the edge records of counter-clockwise triangles. `faces` are indices below `vertex_count`, and the
    /// vertices are already welded.
    ///
    /// # Errors
    /// [`MeshError`] for no faces, too many faces or vertices, or an index out of range.
    pub fn from_faces(vertex_count: usize, faces: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        check(vertex_count, &faces)?;
        Ok(Self::build(vertex_count, faces, WeldCounts::unchanged(vertex_count)))
    }

    /// Welds vertices, cuts polygons into triangles, and builds the edge records of these. This is the mesh of what is
    /// drawn: the triangles are [`Self::faces`], and facing, silhouettes and shadows are theirs. Faces of a modelling tool,
    /// planar or not, belong here. [`PolygonLoops::triangulate`] returns the same triangles.
    ///
    /// `positions` decide the triangles once. They stay as they are when vertices move. [`Self::from_polygons_by_loop`]
    /// takes each polygon as one face instead.
    ///
    /// # Errors
    /// [`MeshError`] for no polygons or too many, arrays that do not fit together, a loop of fewer than three corners,
    /// or a corner out of range.
    pub fn from_polygons(positions: &[[f32; 3]], polygons: PolygonLoops<'_>, weld: Weld) -> Result<Self, MeshError> {
        let (triangles, counts) = polygons.triangulate(positions, weld)?;
        Ok(Self::build(positions.len(), triangles, counts))
    }

    /// Welds vertices and builds the edge records between polygons, planar or not. A polygon is one face, as in Bergeron's
    /// paper of 1986: its boundary decides whether it faces a light, and its inner diagonals are no edges. An edge that a
    /// polygon walks both ways is none either: the bridge to a hole. Polygons that are all triangles make the same mesh as
    /// [`Self::new`].
    ///
    /// A light may see the boundary of a polygon that is not planar otherwise than its triangles, [`Self::faces`]. Where
    /// these are drawn, silhouettes and shadows then differ from the picture. [`Self::from_polygons`] is for what is drawn.
    ///
    /// `positions` decide the triangles that are the surface of each polygon. These stay as they are when vertices
    /// move.
    ///
    /// # Errors
    /// The errors of [`Self::from_polygons`].
    pub fn from_polygons_by_loop(
        positions: &[[f32; 3]],
        polygons: PolygonLoops<'_>,
        weld: Weld,
    ) -> Result<Self, MeshError> {
        let Welded { polygons, triangles, counts: weld } = Polygons::welded(positions, polygons, weld)?;
        if polygons.are_triangles() {
            return Ok(Self::build(positions.len(), polygons.into_triangles(), weld));
        }
        Ok(Self {
            id: MeshId::next(),
            vertex_count: positions.len() as u32,
            edges: EdgeRecords::build(positions.len(), &polygons),
            faces: triangles,
            polygons: Some(polygons),
            weld,
        })
    }

    fn build(vertex_count: usize, faces: Vec<[u32; 3]>, weld: WeldCounts) -> Self {
        let edges = EdgeRecords::build(vertex_count, &*faces);
        Self { id: MeshId::next(), vertex_count: vertex_count as u32, faces, polygons: None, edges, weld }
    }

    /// The number of source vertices, including those that were welded to others. A position buffer must hold this number of
    /// positions.
    pub fn vertex_count(&self) -> u32 {
        self.vertex_count
    }

    /// Counter-clockwise triangles, as vertex indices: the surface of the mesh, which callers draw. In a mesh of
    /// triangles these are the faces in the order given, degenerate ones included. In a mesh of polygons they are the
    /// triangles of one polygon after the other: see [`Polygons::triangles`]. Polygons by [`Self::from_polygons_by_loop`]
    /// may all be without a surface; then there are none.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// The number of faces, which edge records name: polygons or triangles. Facing masks are of [`Self::faces`], which in a
    /// mesh of polygons have another number.
    pub fn face_count(&self) -> usize {
        self.polygons.as_ref().map_or(self.faces.len(), Polygons::len)
    }

    /// The polygons, of [`Self::from_polygons_by_loop`]. `None` if all faces are triangles.
    pub fn polygons(&self) -> Option<&Polygons> {
        self.polygons.as_ref()
    }

    /// The edge records.
    pub fn edges(&self) -> &EdgeRecords {
        &self.edges
    }

    /// Result of welding.
    pub fn weld_counts(&self) -> WeldCounts {
        self.weld
    }

    /// Whether every record is of kind [`EdgeKind::Consistent`](crate::mesh::EdgeKind::Consistent): the mesh is closed and
    /// consistently oriented.
    pub fn is_closed(&self) -> bool {
        let EdgeCounts { inconsistent, boundary, .. } = self.edges.counts();
        inconsistent == 0 && boundary == 0
    }

    /// The number of faces without edge records: triangles that name a vertex twice, and polygons that walk all their
    /// edges both ways. They face no light.
    pub fn degenerate_faces(&self) -> usize {
        if let Some(polygons) = &self.polygons {
            return (0..polygons.len()).filter(|&polygon| polygons.boundary(polygon).is_empty()).count();
        }
        self.faces.iter().filter(|face| is_degenerate(**face)).count()
    }

    /// The size of the edge records in memory, in bytes: 16 for each record.
    pub fn edge_record_bytes(&self) -> usize {
        size_of_val(self.edges.vertices()) + size_of_val(self.edges.packed_faces())
    }
}

fn check(vertex_count: usize, faces: &[[u32; 3]]) -> Result<(), MeshError> {
    check_counts(vertex_count, faces.len())?;
    match out_of_range(faces, vertex_count) {
        Some([face, corner]) => {
            let index = faces[face][corner];
            Err(MeshError::IndexOutOfRange { face, corner, index, vertices: vertex_count })
        }
        None => Ok(()),
    }
}

/// The first face and corner that name a vertex that does not exist.
pub(crate) fn out_of_range(faces: &[[u32; 3]], vertex_count: usize) -> Option<[usize; 2]> {
    let corner = faces.as_flattened().iter().position(|&vertex| vertex as usize >= vertex_count);
    corner.map(|corner| [corner / 3, corner % 3])
}
