//! The buffers of a mesh of polygons: their boundaries, those that are undecided, and the pieces of those that are
//! twisted.

use super::errors::ExtractorError;
use super::options::MAX_BOUNDARY_EDGES;
use crate::Mesh;
use crate::gpu::common::device_error::DeviceError;
use crate::gpu::common::dispatch_limits::DispatchLimits;
use crate::gpu::common::wanted::Wanted;
use crate::mesh::{Polygons, is_loop};
use crate::turns::POLYGON_TRIANGLES;

/// The largest number of edges of a boundary that is decided by an invocation for each edge and light, and of triangles of
/// its polygon, as in `boundaries.wgsl`. The other constants are there, too.
const SMALL_BOUNDARY: usize = 32;
const ENTRY_EDGES: usize = 4;
const ENTRY_LIGHTS: usize = 16;
/// Records of cuts that a workgroup takes, as in `boundaries.wgsl`.
const GROUP_CUTS: u64 = 8;
pub(crate) const HEAD_WORDS: u64 = 16;
const RECORD_WORDS: u64 = 10;
/// Bytes of the head before the arguments of the indirect dispatches over records, over entries, over those of
/// `cut_edges`, and over groups of cuts.
pub(super) const RECORD_WORKGROUPS: u64 = 0;
pub(super) const WORKGROUPS: u64 = 16;
pub(super) const CUT_WORKGROUPS: u64 = 32;
pub(super) const CUT_GROUP_WORKGROUPS: u64 = 48;
const ONE_LOOP: u32 = 1 << 31;
/// Bytes of the arguments of an indirect dispatch.
pub(super) const INDIRECT_BYTES: u64 = 12;
/// The head before an encode. No dispatch has workgroups; those over records have one row.
pub(super) const HEAD: [u32; HEAD_WORDS as usize] = [0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0];
/// Counts before the lists of pieces, and words of a piece.
pub(crate) const PIECE_COUNTS: u64 = 32;
pub(crate) const PIECE_WORDS: u64 = 9;
/// The room for pieces of all lights of a batch together, unless fewer are possible.
const SHARED_PIECES: u64 = 1 << 20;

/// Numbers of a mesh of polygons that all sizes follow from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PolygonCounts {
    pub(crate) polygons: usize,
    boundary_edges: usize,
    /// Entries for edges of small boundaries, for each few lights, and of large ones, for each light.
    small: u64,
    large: u64,
    /// The most pieces of a light.
    pieces: u64,
}

/// Numbers that sizes of polygons follow from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PolygonShape {
    pub(super) polygons: usize,
    /// Entries of all polygons for a batch of lights.
    entries: u64,
    /// Pieces of a light that there is room for. 0: none are listed.
    pub(crate) pieces: u32,
    /// The most workgroups of a dispatch over entries, or over groups of cuts.
    workgroups: u64,
}

impl PolygonCounts {
    pub(crate) fn new(polygons: &Polygons) -> Result<Self, ExtractorError> {
        let mut counts = Self { polygons: polygons.len(), boundary_edges: 0, small: 0, large: 0, pieces: 0 };
        for polygon in 0..polygons.len() {
            let edges = polygons.boundary(polygon).len();
            if edges > MAX_BOUNDARY_EDGES {
                return Err(ExtractorError::BoundaryTooLarge { polygon, edges });
            }
            let triangles = polygons.triangles(polygon).len();
            if triangles > POLYGON_TRIANGLES {
                return Err(ExtractorError::PolygonTooLarge { polygon, triangles });
            }
            counts.boundary_edges += edges;
            if edges.max(triangles) <= SMALL_BOUNDARY {
                counts.small += edges.div_ceil(ENTRY_EDGES) as u64;
            } else {
                counts.large += edges as u64;
            }
            // Every edge but its two neighbours may cut an edge.
            counts.pieces += (edges * edges.saturating_sub(2)) as u64;
        }
        Ok(counts)
    }

    /// Bytes of the table of [`boundaries`].
    pub(crate) fn boundary_bytes(&self) -> u64 {
        8 * (self.polygons + 1 + self.boundary_edges) as u64
    }
}

impl PolygonShape {
    /// `capacity` is the room for pieces of each light. `None`: room for all that there can be, up to a share of
    /// [`SHARED_PIECES`] and one for each sixteenth edge. A binding has room for `binding` bytes.
    pub(crate) fn new(counts: &PolygonCounts, max_lights: usize, capacity: Option<u32>, binding: u64) -> Self {
        let &PolygonCounts { polygons, boundary_edges, small, large, pieces } = counts;
        let lights = max_lights.min(32);
        let entries = small * lights.div_ceil(ENTRY_LIGHTS) as u64 + large * lights as u64;
        let fitting = (binding / 4).saturating_sub(PIECE_COUNTS) / (PIECE_WORDS * lights.max(1) as u64);
        let shared = SHARED_PIECES / lights.max(1) as u64 + boundary_edges as u64 / 16;
        let room = capacity.map_or(shared, u64::from).min(pieces.max(1)).min(fitting);
        let workgroups = entries.max(room.div_ceil(GROUP_CUTS) * lights as u64);
        Self { polygons, entries, pieces: u32::try_from(room).unwrap_or(u32::MAX), workgroups }
    }

    /// Refuses more workgroups than as many rows hold as the device allows.
    pub(crate) fn check_workgroups(&self, limits: &DispatchLimits) -> Result<(), DeviceError> {
        let (needed, there) = (self.workgroups.saturating_sub(1).isqrt() + 1, limits.workgroups);
        let (subject, limit) = ("a mesh of so many polygons", "max_compute_workgroups_per_dimension");
        if needed > there { Err(DeviceError::Limit { subject, limit, needed, there }) } else { Ok(()) }
    }

    pub(crate) fn undecided_bytes(&self) -> u64 {
        4 * (HEAD_WORDS + RECORD_WORDS * self.polygons as u64 + 2 * self.entries)
    }

    pub(crate) fn piece_bytes(&self, lights: usize) -> u64 {
        4 * (PIECE_COUNTS + PIECE_WORDS * u64::from(self.pieces) * lights as u64)
    }
}

/// The buffers of the polygons of a mesh.
#[derive(Debug)]
pub(crate) struct PolygonBuffers<B = wgpu::Buffer> {
    pub(super) boundaries: B,
    pub(super) undecided: B,
    /// The head before an encode.
    pub(super) head: B,
    /// The arguments of the indirect dispatches, at the same bytes as in the head.
    pub(super) arguments: B,
    /// For each batch of lights, if they are listed.
    pub(crate) pieces: Vec<B>,
}

impl<B> PolygonBuffers<B> {
    /// `boundaries` is the table of [`boundaries`], `batch_lights` has the number of lights of each batch.
    pub(super) fn plan(
        boundaries: &[[u32; 2]],
        shape: PolygonShape,
        batch_lights: impl Iterator<Item = usize>,
        make: &mut impl FnMut(Wanted<'_>) -> B,
    ) -> Self {
        let lists = batch_lights.filter(|_| shape.pieces > 0);
        Self {
            boundaries: make(Wanted::filled("boundaries", bytemuck::cast_slice(boundaries)).whole_if(true)),
            undecided: make(Wanted::new("undecided boundaries", shape.undecided_bytes()).whole_if(true)),
            head: make(Wanted::filled("boundary head", bytemuck::cast_slice(&HEAD)).free()),
            arguments: make(Wanted::new("boundary dispatch", 4 * HEAD_WORDS).indirect().free()),
            pieces: lists.map(|lights| make(Wanted::new("pieces", shape.piece_bytes(lights)).whole_if(true))).collect(),
        }
    }
}

/// The table of polygons and their boundaries, as `boundaries.wgsl` has them.
pub(super) fn boundaries(polygons: &Polygons) -> Vec<[u32; 2]> {
    let mut table = Vec::with_capacity(polygons.len() + 1);
    let mut edges = Vec::new();
    for polygon in 0..polygons.len() {
        let boundary = polygons.boundary(polygon);
        let first = edges.len() as u32 | if is_loop(boundary) { ONE_LOOP } else { 0 };
        table.push([first, polygons.triangles(polygon).start as u32]);
        edges.extend(boundary);
    }
    let triangles = polygons.len().checked_sub(1).map_or(0, |last| polygons.triangles(last).end);
    table.push([edges.len() as u32, triangles as u32]);
    table.append(&mut edges);
    table
}

/// The first triangle of each polygon: where edge records find the masks of the polygon.
pub(crate) fn faces_of_records(mesh: &Mesh) -> Option<Vec<[u32; 2]>> {
    let polygons = mesh.polygons()?;
    let first = |face: u32| {
        let inconsistent = face & crate::mesh::INCONSISTENT_BIT;
        polygons.triangles((face & !crate::mesh::INCONSISTENT_BIT) as usize).start as u32 | inconsistent
    };
    let second = |face: u32| if face == crate::mesh::NO_FACE { face } else { first(face) };
    Some(mesh.edges().packed_faces().iter().map(|&[face_0, face_1]| [first(face_0), second(face_1)]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quads(count: usize) -> PolygonCounts {
        let [small, pieces] = [count as u64, 8 * count as u64];
        PolygonCounts { polygons: count, boundary_edges: 4 * count, small, large: 0, pieces }
    }

    /// 32,768 pieces of each of 32 lights, by eights, are more than the entries.
    #[test]
    fn rows_hold_the_groups_of_cuts() {
        let shape = PolygonShape::new(&quads(4096), 32, None, 128 << 20);
        for (max_compute_workgroups_per_dimension, are_enough) in [(362, false), (363, true)] {
            let limits = wgpu::Limits { max_compute_workgroups_per_dimension, ..Default::default() };
            assert_eq!(shape.check_workgroups(&DispatchLimits::new(&limits)).is_ok(), are_enough);
        }
    }

    #[test]
    fn all_pieces_that_there_can_be_have_room_up_to_the_share_of_a_light() {
        for (lights, most) in [(1, 131_072), (8, 16_384), (32, 4096), (1024, 4096)] {
            let room = |count| PolygonShape::new(&quads(count), lights, None, 128 << 20).pieces;
            // Each sixteenth edge adds a little.
            assert_eq!(room(most), 8 * most as u32, "{lights} lights");
            assert!(room(2 * most) < 16 * most as u32, "{lights} lights: the room has no end");
        }
        // More is the caller's choice, up to one binding.
        let given = |pieces, binding| PolygonShape::new(&quads(8192), 32, Some(pieces), binding).pieces;
        assert_eq!(
            [given(u32::MAX, 128 << 20), given(50_000, 128 << 20), given(u32::MAX, 1 << 20)],
            [65_536, 50_000, 910]
        );
    }
}
