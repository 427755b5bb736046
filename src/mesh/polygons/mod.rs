//! Polygons: faces of one or more loops of any number of corners, planar or not.

mod boundary;
mod check;
mod fans;
mod surface;
mod triangulate;

pub(crate) use boundary::is_loop;

use super::error::{MAX_FACES, MeshError};
use super::topology::HalfEdges;
use super::weld::{self, Weld, WeldCounts};

/// Polygons as they are given: three flat arrays, which are also those of a `.npz` file.
///
/// The first loop of a polygon is its outer loop, and the others are holes. The outer loop runs counter-clockwise as
/// seen from the polygon's front, and holes run clockwise. A hole may also be joined to the outer loop by a bridge, an
/// edge that the loop walks both ways. No loop repeats its first corner at its end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PolygonLoops<'a> {
    /// The number of loops of each polygon, at least 1.
    pub polygon_loops: &'a [u32],
    /// The number of corners of each loop, at least 3, one polygon's loops after the other's.
    pub loop_sizes: &'a [u32],
    /// The vertex at each corner, one loop after the other.
    pub loop_corners: &'a [u32],
}

impl PolygonLoops<'_> {
    /// The triangles that the polygons are drawn as, one polygon's after the other's: the faces of
    /// [`Mesh::from_polygons`](crate::Mesh::from_polygons), for other makers of geometry, and what welding did. Each welded
    /// group goes by its lowest index, or by the vertex at its smallest position where vertices are welded by distance.
    ///
    /// A polygon of three corners is its own triangle. The triangles of a larger one have the polygon's boundary, edge by
    /// edge. Polygons with the same corners around, in either direction, have the same triangles, so both sides of one
    /// surface coincide. A polygon without a boundary walks all its edges both ways and has no surface. It becomes one
    /// triangle that names a vertex twice, which is drawn nowhere.
    ///
    /// # Errors
    /// The errors of [`Mesh::from_polygons`](crate::Mesh::from_polygons).
    pub fn triangulate(self, positions: &[[f32; 3]], weld: Weld) -> Result<(Vec<[u32; 3]>, WeldCounts), MeshError> {
        self.triangulate_with_polygons(positions, weld).map(|triangles| (triangles.faces, triangles.counts))
    }

    /// The same as [`Self::triangulate`], with the polygon of each triangle.
    ///
    /// # Errors
    /// The errors of [`Self::triangulate`].
    pub fn triangulate_with_polygons(self, positions: &[[f32; 3]], weld: Weld) -> Result<PolygonTriangles, MeshError> {
        let Welded { polygons, triangles, counts } = Polygons::welded(positions, self, weld)?;
        let (faces, polygons) = polygons.surface(triangles);
        if faces.len() > MAX_FACES {
            return Err(MeshError::TooManyFaces { faces: faces.len() });
        }
        Ok(PolygonTriangles { faces, polygons, counts })
    }
}

/// The triangles that polygons were cut into.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PolygonTriangles {
    /// The vertices of each triangle.
    pub faces: Vec<[u32; 3]>,
    /// The index of each triangle's polygon.
    pub polygons: Vec<u32>,
    /// The counts of welding. [`WeldCounts::collapsed`] counts polygons that lost their boundary.
    pub counts: WeldCounts,
}

/// The largest number of corners of one polygon.
pub const MAX_POLYGON_CORNERS: usize = 1 << 24;

/// The polygons of a mesh that takes each as one face.
///
/// The **boundary** of a polygon is its edges, without those that it walks both ways and without edges from a vertex to
/// itself. Facing and edge records see boundaries only. Loops are the polygon as given, and triangles are its surface.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Polygons {
    /// Where each polygon's loops begin, and an end.
    loop_starts: Vec<u32>,
    /// Where each loop's corners begin, and an end.
    corner_starts: Vec<u32>,
    corners: Vec<u32>,
    /// Where each polygon's boundary begins, and an end.
    boundary_starts: Vec<u32>,
    boundaries: Vec<[u32; 2]>,
    /// Where each polygon's triangles begin, and an end.
    triangle_starts: Vec<u32>,
}

/// Welded polygons.
pub(super) struct Welded {
    pub(super) polygons: Polygons,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) counts: WeldCounts,
}

impl Polygons {
    /// Checks polygons, welds their vertices and makes polygons of them, with their triangles.
    pub(super) fn welded(positions: &[[f32; 3]], given: PolygonLoops<'_>, weld: Weld) -> Result<Welded, MeshError> {
        // Welding needs indices of 32 bits, so the number of vertices is checked first.
        check::check(positions.len(), given)?;
        let (groups, mut counts) = weld::weld_positions(positions, weld);
        let (polygons, triangles) = Self::new(positions, given, &groups);
        if counts.after < counts.before {
            counts.collapsed = polygons.collapsed(given);
        }
        Ok(Welded { polygons, triangles, counts })
    }

    /// Renames the corners of polygons that passed [`check::check`], and triangulates them at `positions`. The triangles
    /// come second. `rename` has an entry for each vertex, or none if they keep their names.
    fn new(positions: &[[f32; 3]], given: PolygonLoops<'_>, rename: &[u32]) -> (Self, Vec<[u32; 3]>) {
        let renamed = |&v: &u32| rename.get(v as usize).copied().unwrap_or(v);
        let mut polygons = Self {
            loop_starts: starts(given.polygon_loops),
            corner_starts: starts(given.loop_sizes),
            corners: given.loop_corners.iter().map(renamed).collect(),
            boundary_starts: vec![0],
            boundaries: Vec::with_capacity(given.loop_corners.len()),
            triangle_starts: vec![0],
        };
        let mut triangles = Vec::with_capacity(given.loop_corners.len());
        let (mut walker, mut triangulator) = (boundary::Walker::default(), triangulate::Triangulator::default());
        for polygon in 0..polygons.len() {
            let first = polygons.boundaries.len();
            let mut boundaries = std::mem::take(&mut polygons.boundaries);
            walker.append_boundary(&mut boundaries, polygons.loops(polygon));
            let boundary = &boundaries[first..];
            triangulator.append_triangles(&mut triangles, positions, polygons.loops(polygon), boundary);
            polygons.boundaries = boundaries;
            polygons.boundary_starts.push(polygons.boundaries.len() as u32);
            polygons.triangle_starts.push(triangles.len() as u32);
        }
        (polygons, triangles)
    }

    /// The number of polygons.
    pub fn len(&self) -> usize {
        self.loop_starts.len() - 1
    }

    /// Whether there are none. A mesh has at least one.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The loops of a polygon, as given but with welded vertices: its outer loop, then its holes.
    ///
    /// # Panics
    /// If there is no such polygon.
    pub fn loops(&self, polygon: usize) -> impl ExactSizeIterator<Item = &[u32]> + Clone {
        self.loops_of(&self.corners, polygon)
    }

    /// The loops of a polygon in these corners.
    fn loops_of<'a>(&'a self, corners: &'a [u32], polygon: usize) -> impl ExactSizeIterator<Item = &'a [u32]> + Clone {
        range(&self.loop_starts, polygon).map(move |index| &corners[range(&self.corner_starts, index)])
    }

    /// The directed edges of a polygon's boundary. Equally many begin and end at each vertex. They are in the order of the
    /// polygon's corners, without the edges that it walks both ways.
    ///
    /// # Panics
    /// If there is no such polygon.
    pub fn boundary(&self, polygon: usize) -> &[[u32; 2]] {
        &self.boundaries[range(&self.boundary_starts, polygon)]
    }

    /// Which of the mesh's triangles are those of a polygon. They have its boundary, edge by edge: inner
    /// diagonals cancel. A polygon without a boundary has none.
    ///
    /// # Panics
    /// If there is no such polygon.
    pub fn triangles(&self, polygon: usize) -> std::ops::Range<usize> {
        range(&self.triangle_starts, polygon)
    }

    /// The polygon of each triangle.
    pub fn triangle_polygons(&self) -> Vec<u32> {
        polygons_of(&self.triangle_starts)
    }

    /// The mask of each polygon from those of the mesh's triangles, for one batch of lights. They are the same for all of a
    /// polygon: masks of faces are those of triangles, as shaders draw them, and edge records name polygons. A polygon
    /// without triangles, and one that `of_triangles` does not reach, has no bits.
    pub fn masks_of(&self, of_triangles: &[u32]) -> Vec<u32> {
        let first = |polygon| self.triangles(polygon).next().and_then(|first| of_triangles.get(first));
        (0..self.len()).map(|polygon| first(polygon).copied().unwrap_or(0)).collect()
    }

    /// The masks of all triangles, from those of all polygons. Both are given for one batch of lights after the other.
    pub(crate) fn masks_of_triangles(&self, of_polygons: &[u32]) -> impl Iterator<Item = u32> {
        let of_polygon = |(polygon, &mask)| std::iter::repeat_n(mask, self.triangles(polygon).len());
        of_polygons.chunks(self.len().max(1)).flat_map(move |plane| plane.iter().enumerate().flat_map(of_polygon))
    }

    /// How many polygons have no boundary, though they had one as given, before their corners were renamed.
    fn collapsed(&self, given: PolygonLoops<'_>) -> usize {
        let mut walker = boundary::Walker::default();
        let mut had_boundary = |polygon: usize| {
            let mut boundary = Vec::new();
            walker.append_boundary(&mut boundary, self.loops_of(given.loop_corners, polygon));
            !boundary.is_empty()
        };
        (0..self.len()).filter(|&polygon| self.boundary(polygon).is_empty() && had_boundary(polygon)).count()
    }

    /// Whether every polygon is one loop of three corners, so that its triangle is the same.
    pub(super) fn are_triangles(&self) -> bool {
        let are_all = |starts: &[u32], size| starts.windows(2).all(|ends| ends[1] - ends[0] == size);
        are_all(&self.loop_starts, 1) && are_all(&self.corner_starts, 3)
    }

    /// The corners, as triangles where every polygon is one.
    pub(super) fn into_triangles(self) -> Vec<[u32; 3]> {
        self.corners.as_chunks::<3>().0.to_vec()
    }
}

/// The edges of all boundaries are the half-edges of a mesh of polygons.
impl HalfEdges for Polygons {
    fn number_limit(&self) -> usize {
        self.boundaries.len()
    }

    fn visit(&self, mut visit: impl FnMut(u32, [u32; 2])) {
        (0..).zip(&self.boundaries).for_each(|(half_edge, &edge)| visit(half_edge, edge));
    }

    fn faces(&self) -> impl Fn(u32) -> u32 {
        let faces = polygons_of(&self.boundary_starts);
        move |half_edge| faces[half_edge as usize]
    }
}

/// Prefix sums, which [`check::check`] has found to fit.
fn starts(sizes: &[u32]) -> Vec<u32> {
    let sums = sizes.iter().scan(0, |sum, size| {
        *sum += size;
        Some(*sum)
    });
    std::iter::once(0).chain(sums).collect()
}

/// The polygon of each element. `starts` has the index of the first element of each polygon, and an end.
fn polygons_of(starts: &[u32]) -> Vec<u32> {
    let count = |ends: &[u32]| (ends[1] - ends[0]) as usize;
    (0..).zip(starts.windows(2)).flat_map(|(polygon, ends)| std::iter::repeat_n(polygon, count(ends))).collect()
}

fn range(starts: &[u32], index: usize) -> std::ops::Range<usize> {
    starts[index] as usize..starts[index + 1] as usize
}
