//! Vertices and faces of any number of corners, as a file lists them one after the other.

use rimline::gltf::Colors;
use rimline::mesh::MAX_POLYGON_CORNERS;

use crate::charge;
use crate::coordinates::placed;
use crate::npz::{Arrays, PolygonArrays};

/// Bytes for a vertex in `f64`, a face and a corner in the lists that are read. A list that doubles has its new room beside
/// the old one for a moment: three times what is in it.
const LISTED_VERTEX: u64 = 3 * 24;
const LISTED_FACE: u64 = 3 * 4;
const LISTED_CORNER: u64 = 3 * 4;
/// Bytes for a colour in a list that doubles, for that of a triangle, and for a vertex with a colour while vertices are
/// welded.
const LISTED_COLOR: u64 = 3 * 12;
const TRIANGLE_COLOR: u64 = 12;
const WELDED_COLOR: u64 = 12 + 4;

pub(crate) const WHITE: [f32; 3] = [1.0; 3];

/// Why a vertex or a face is not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refused {
    /// The face has fewer than three corners.
    Corners(usize),
    /// The face has more than [`MAX_POLYGON_CORNERS`].
    FaceTooLarge,
    /// With it the model takes more memory than the limit.
    TooLarge { needed: u64, limit: u64 },
}

/// A model as far as it was read.
#[derive(Default)]
pub(crate) struct Collected {
    /// In `f64` until all of them are known.
    positions: Vec<[f64; 3]>,
    sizes: Vec<u32>,
    corners: Vec<u32>,
    /// Linear colours of the first faces and vertices; the others are white.
    face_colors: Vec<[f32; 3]>,
    vertex_colors: Vec<[f32; 3]>,
    /// Corners of the faces that are complete: where those of the face that is being read begin.
    complete: usize,
    /// The faces so far, as long as all of them are triangles. Counted only if polygons `are_whole`.
    triangles: usize,
    /// Whether a mesh of polygons is made of polygons.
    are_whole: bool,
    /// Bytes of the lists that are read, and of the mesh that is made of them. The lists are gone by then, so the larger
    /// sum is what is in use at one time.
    listed: u64,
    meshed: u64,
    limit: u64,
}

impl Collected {
    /// The model may take `limit` bytes with its mesh. The mesh is one of polygons where these `are_whole`, else one of
    /// their triangles.
    pub(crate) fn new(limit: u64, are_whole: bool) -> Self {
        Self { are_whole, limit, ..Self::default() }
    }

    /// The memory that is left.
    pub(crate) fn room(&self) -> u64 {
        self.limit - self.listed.max(self.meshed)
    }

    pub(crate) fn vertices(&self) -> usize {
        self.positions.len()
    }

    /// Refuses vertices that are announced, if there is no room for them.
    pub(crate) fn check_vertices(&self, count: u64) -> Result<(), Refused> {
        self.check(self.listed.saturating_add(count.saturating_mul(LISTED_VERTEX)))
    }

    pub(crate) fn vertex(&mut self, position: [f64; 3]) -> Result<(), Refused> {
        self.take(LISTED_VERTEX, charge::VERTEX)?;
        self.positions.push(position);
        Ok(())
    }

    /// The colour of the last vertex, which has none yet.
    pub(crate) fn color_vertex(&mut self, color: [f32; 3]) -> Result<(), Refused> {
        let (old, new) = (self.vertex_colors.len(), self.positions.len());
        self.charge((LISTED_COLOR + WELDED_COLOR) * new.saturating_sub(old) as u64)?;
        self.vertex_colors.resize(new.saturating_sub(1), WHITE);
        self.vertex_colors.push(color);
        Ok(())
    }

    /// The colour of the complete faces since the last call.
    pub(crate) fn color_faces(&mut self, color: [f32; 3]) -> Result<(), Refused> {
        let faces = self.sizes.get(self.face_colors.len()..).unwrap_or_default();
        let corners = faces.iter().map(|&size| u64::from(size)).sum::<u64>();
        self.charge(LISTED_COLOR * faces.len() as u64 + TRIANGLE_COLOR * corners)?;
        self.face_colors.resize(self.sizes.len(), color);
        Ok(())
    }

    /// Begins a face. What it takes in the mesh is known once it is complete.
    pub(crate) fn begin_face(&mut self) -> Result<(), Refused> {
        self.complete = self.corners.len();
        self.take(LISTED_FACE, 0)
    }

    /// The next corner of the face.
    pub(crate) fn corner(&mut self, vertex: u32) -> Result<(), Refused> {
        self.take(LISTED_CORNER, 0)?;
        self.corners.push(vertex);
        Ok(())
    }

    /// Ends the face.
    pub(crate) fn end_face(&mut self) -> Result<(), Refused> {
        let size = self.corners.len() - self.complete;
        if size < 3 {
            return Err(Refused::Corners(size));
        }
        if size > MAX_POLYGON_CORNERS {
            return Err(Refused::FaceTooLarge);
        }
        self.sizes.push(size as u32);
        let polygon = |corners: usize| charge::POLYGON + charge::LOOP + charge::CORNER * corners as u64;
        if !self.are_whole {
            return self.take(0, (size as u64 - 2) * charge::FACE);
        }
        if size == 3 && self.triangles + 1 == self.sizes.len() {
            self.triangles += 1;
            return self.take(0, charge::FACE);
        }
        // One polygon makes polygons of all faces, the triangles before it too.
        let before = std::mem::take(&mut self.triangles) as u64;
        self.take(0, before.saturating_mul(polygon(3).saturating_sub(charge::FACE)))?;
        self.take(0, polygon(size))
    }

    fn check(&self, needed: u64) -> Result<(), Refused> {
        if needed > self.limit { Err(Refused::TooLarge { needed, limit: self.limit }) } else { Ok(()) }
    }

    /// Charges bytes of the lists, and bytes of the mesh.
    fn take(&mut self, listed: u64, meshed: u64) -> Result<(), Refused> {
        let (listed, meshed) = (self.listed.saturating_add(listed), self.meshed.saturating_add(meshed));
        self.check(listed.max(meshed))?;
        (self.listed, self.meshed) = (listed, meshed);
        Ok(())
    }

    /// Charges bytes that stay beside both, which may be those of something else.
    pub(crate) fn charge(&mut self, bytes: u64) -> Result<(), Refused> {
        self.take(bytes, bytes)
    }

    /// Positions relative to an origin near them, and triangles if all faces are, else polygons. All corners must be
    /// below the number of vertices; nothing checks them here. `None` without faces.
    pub(crate) fn finish(mut self) -> Result<Option<Arrays>, Refused> {
        if self.sizes.is_empty() {
            return Ok(None);
        }
        if !self.face_colors.is_empty() {
            self.color_faces(WHITE)?;
        } else if !self.vertex_colors.is_empty() {
            // Faces get colours where vertices cannot keep theirs.
            self.charge(TRIANGLE_COLOR * (self.sizes.len() + self.corners.len()) as u64)?;
        }
        let Self { positions, sizes, corners, face_colors, mut vertex_colors, .. } = self;
        if !vertex_colors.is_empty() {
            vertex_colors.resize(positions.len(), WHITE);
        }
        let colored = |colors: Vec<[f32; 3]>| Some(colors).filter(|colors| colors.iter().any(|&color| color != WHITE));
        let colors = Colors { faces: colored(face_colors), vertices: colored(vertex_colors) };
        let (positions, origin) = placed(positions, &sizes, &corners);
        if sizes.iter().all(|&size| size == 3) {
            let faces = corners.as_chunks().0.to_vec();
            return Ok(Some(Arrays { positions, faces, polygons: None, origin, colors }));
        }
        let polygons = PolygonArrays { polygon_loops: vec![1; sizes.len()], loop_sizes: sizes, loop_corners: corners };
        Ok(Some(Arrays { positions, faces: Vec::new(), polygons: Some(polygons), origin, colors }))
    }
}
