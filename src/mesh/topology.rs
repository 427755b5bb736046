//! Edge records: which faces meet at each edge, for any set of triangles or polygons.
//!
//! A stable counting sort puts the half-edges in buckets by their lower vertex. A stable sort orders each bucket, which mostly
//! has few, by the upper vertex. A run of equal vertex pairs holds all half-edges of one edge, lowest face first. It is split
//! into records of at most two faces.

/// How the two faces of an edge record traverse it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum EdgeKind {
    /// Face 1 traverses the edge `b→a`, opposite to face 0. Both faces have their fronts on one side of the surface.
    Consistent = 0,
    /// Face 1 traverses the edge `a→b`, as face 0 does. The faces have their fronts on different sides of the surface.
    Inconsistent = 1,
    /// There is no face 1.
    Boundary = 2,
}

/// One unpacked edge record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// The vertices `(a, b)`. Face 0 traverses the edge `a→b`.
    pub vertices: [u32; 2],
    /// Face 0. Its index is lower than that of face 1. The two are equal where a polygon walks the edge twice, both times
    /// `a→b`.
    pub face_0: u32,
    /// Face 1, if there is one.
    pub face_1: Option<u32>,
    /// How face 1 traverses the edge.
    pub kind: EdgeKind,
}

/// The number of edge records of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EdgeCounts {
    /// Records of kind [`EdgeKind::Consistent`].
    pub consistent: usize,
    /// Records of kind [`EdgeKind::Inconsistent`].
    pub inconsistent: usize,
    /// Records of kind [`EdgeKind::Boundary`].
    pub boundary: usize,
}

/// The edge records of a mesh, ordered by face 0 and its corner. The edge from corner 0 to corner 1 comes first.
///
/// An edge with more than two faces has several records that partition its faces. Faces of opposite traversal are
/// paired first, lowest face first. The faces that remain all traverse the edge in the same direction. Neighbours among them
/// are paired, and a last single face makes a boundary record.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EdgeRecords {
    vertices: Vec<[u32; 2]>,
    faces: Vec<[u32; 2]>,
    counts: EdgeCounts,
}

/// The index that stands for no face: face 1 of a boundary record in [`EdgeRecords::packed_faces`], and the face of a point
/// that is on none in [`cpu::shadow_depth_on_faces`](crate::cpu::shadow_depth_on_faces) and
/// [`gpu::QueryPoints`](crate::gpu::QueryPoints).
pub const NO_FACE: u32 = u32::MAX;
/// The bit that is set in face 0 of an inconsistent record of [`EdgeRecords::packed_faces`].
pub const INCONSISTENT_BIT: u32 = 1 << 31;

impl EdgeRecords {
    /// The number of records.
    pub fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Whether there are no records: every face is a degenerate triangle or a polygon without a boundary.
    pub fn is_empty(&self) -> bool {
        self.vertices.is_empty()
    }

    /// The number of records of each kind.
    pub fn counts(&self) -> EdgeCounts {
        self.counts
    }

    /// The record with this index, or `None` past the end.
    pub fn get(&self, index: usize) -> Option<Edge> {
        let (&vertices, &faces) = (self.vertices.get(index)?, self.faces.get(index)?);
        Some(unpack(vertices, faces))
    }

    /// All records, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Edge> + '_ {
        self.vertices.iter().zip(&self.faces).map(|(&vertices, &faces)| unpack(vertices, faces))
    }

    /// The vertices `(a, b)` of each record, as the GPU reads them.
    pub fn vertices(&self) -> &[[u32; 2]] {
        &self.vertices
    }

    /// The faces of each record, as the GPU reads them. Face 0 has bit 31 set in an inconsistent record. Face 1 is
    /// `0xFFFFFFFF` in a boundary record.
    pub fn packed_faces(&self) -> &[[u32; 2]] {
        &self.faces
    }

    /// Builds the records of faces whose vertices are below `vertex_count`.
    pub(super) fn build(vertex_count: usize, faces: &(impl HalfEdges + ?Sized)) -> Self {
        let mates = pair_half_edges(vertex_count, faces);
        let count = mates.iter().enumerate().filter(|&(half_edge, &mate)| is_first(half_edge, mate)).count();
        let (mut vertices, mut packed) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut counts = EdgeCounts::default();
        let face_of = faces.faces();
        faces.visit(|half_edge, edge| {
            let mate = mates[half_edge as usize];
            if !is_first(half_edge as usize, mate) {
                return;
            }
            vertices.push(edge);
            let face = face_of(half_edge);
            if mate == BOUNDARY {
                counts.boundary += 1;
                packed.push([face, NO_FACE]);
            } else {
                let inconsistent = mate & INCONSISTENT_BIT;
                counts.inconsistent += usize::from(inconsistent != 0);
                counts.consistent += usize::from(inconsistent == 0);
                packed.push([face | inconsistent, face_of(mate & !INCONSISTENT_BIT)]);
            }
        });
        Self { vertices, faces: packed, counts }
    }
}

/// The directed edges of faces. Each has a number, by which they are ordered: by face, and by corner in a face.
pub(super) trait HalfEdges {
    /// One more than the largest number there may be, at most `3·MAX_FACES`.
    fn number_limit(&self) -> usize;
    /// Calls `visit(number, [a, b])` for each half-edge, in order. `a` and `b` differ.
    fn visit(&self, visit: impl FnMut(u32, [u32; 2]));
    /// The function from a half-edge's number to its face.
    fn faces(&self) -> impl Fn(u32) -> u32;
}

/// Triangles: corner `c` of face `f` begins the half-edge `3·f + c`. Degenerate faces have none.
impl HalfEdges for [[u32; 3]] {
    fn number_limit(&self) -> usize {
        3 * self.len()
    }

    fn visit(&self, mut visit: impl FnMut(u32, [u32; 2])) {
        for (face, &corners) in self.iter().enumerate() {
            if is_degenerate(corners) {
                continue;
            }
            for (corner, next) in NEXT.into_iter().enumerate() {
                visit((3 * face + corner) as u32, [corners[corner], corners[next]]);
            }
        }
    }

    fn faces(&self) -> impl Fn(u32) -> u32 {
        |half_edge| half_edge / 3
    }
}

fn unpack(vertices: [u32; 2], [face_0, face_1]: [u32; 2]) -> Edge {
    let kind = match (face_0 & INCONSISTENT_BIT, face_1) {
        (_, NO_FACE) => EdgeKind::Boundary,
        (0, _) => EdgeKind::Consistent,
        _ => EdgeKind::Inconsistent,
    };
    Edge { vertices, face_0: face_0 & !INCONSISTENT_BIT, face_1: (face_1 != NO_FACE).then_some(face_1), kind }
}

/// The next corner after each corner of a face.
const NEXT: [usize; 3] = [1, 2, 0];
/// The mate of a half-edge without a mate. No half-edge has this number, with or without [`INCONSISTENT_BIT`]: the
/// largest number is `3·MAX_FACES − 1`, which is 2³¹ − 3.
const BOUNDARY: u32 = u32::MAX;
/// The mate of a number that no half-edge has, in a degenerate triangle.
const UNUSED: u32 = u32::MAX - 1;

/// Whether a half-edge is the first of its record, that of face 0. Records are in the order of their first half-edges.
fn is_first(half_edge: usize, mate: u32) -> bool {
    mate == BOUNDARY || (mate != UNUSED && half_edge < (mate & !INCONSISTENT_BIT) as usize)
}

/// A half-edge, stored at its lower vertex: the other vertex, and the half-edge's number. [`Entry::FORWARD`] is set
/// where it runs from the lower to the upper vertex.
#[derive(Clone, Copy, Default)]
struct Entry {
    upper: u32,
    tagged: u32,
}

impl Entry {
    const FORWARD: u32 = 1 << 31;
    fn half_edge(self) -> u32 {
        self.tagged & !Self::FORWARD
    }
    fn is_opposite(self, other: Self) -> bool {
        (self.tagged ^ other.tagged) & Self::FORWARD != 0
    }
}

/// Calls `visit(lower, entry)` for every half-edge, in order.
fn for_each_half_edge(faces: &(impl HalfEdges + ?Sized), mut visit: impl FnMut(u32, Entry)) {
    faces.visit(|half_edge, [a, b]| {
        let tagged = if a < b { half_edge | Entry::FORWARD } else { half_edge };
        visit(a.min(b), Entry { upper: a.max(b), tagged });
    });
}

/// For every number of a half-edge, the half-edge that shares its record, with [`INCONSISTENT_BIT`] set if both
/// traverse the edge in the same direction. [`BOUNDARY`] for a half-edge that is alone in its record, [`UNUSED`] for a
/// number that no half-edge has.
fn pair_half_edges(vertex_count: usize, faces: &(impl HalfEdges + ?Sized)) -> Vec<u32> {
    let named = (vertex_count / 4 > faces.number_limit()).then(|| lower_vertices(faces));
    let buckets = named.as_ref().map_or(vertex_count, Vec::len);
    let bucket = |lower: u32| named.as_ref().map_or(lower, |named| named.partition_point(|&of| of < lower) as u32);
    let mut starts = vec![0_u32; buckets + 1];
    for_each_half_edge(faces, |lower, _| starts[bucket(lower) as usize + 1] += 1);
    prefix_sum(&mut starts);
    let mut entries = vec![Entry::default(); starts[buckets] as usize];
    let mut next = starts.clone();
    for_each_half_edge(faces, |lower, entry| put(&mut next, &mut entries, bucket(lower), entry));
    let mut mates = vec![UNUSED; faces.number_limit()];
    for range in starts.windows(2) {
        let bucket = &mut entries[range[0] as usize..range[1] as usize];
        bucket.sort_by_key(|entry| entry.upper);
        for run in bucket.chunk_by(|a, b| a.upper == b.upper) {
            pair_run(run, &mut mates);
        }
    }
    mates
}

/// The lower vertices of all half-edges, each once, ascending. A mesh that names few of its vertices has buckets for these
/// alone. Else a large vertex count beside a few faces would need memory for all vertices.
fn lower_vertices(faces: &(impl HalfEdges + ?Sized)) -> Vec<u32> {
    let mut named = Vec::with_capacity(faces.number_limit());
    for_each_half_edge(faces, |lower, _| named.push(lower));
    named.sort_unstable();
    named.dedup();
    named
}

/// Replaces each count by its sum with all before it. Callers count bucket `b` at index `b + 1`, so its start is then at
/// index `b`.
pub(super) fn prefix_sum(starts: &mut [u32]) {
    let mut sum = 0;
    for start in starts {
        sum += *start;
        *start = sum;
    }
}

/// Appends a value to the bucket `key` of `sorted`. `next` has the index of the next free element of each bucket.
pub(super) fn put<T>(next: &mut [u32], sorted: &mut [T], key: u32, value: T) {
    let slot = &mut next[key as usize];
    sorted[*slot as usize] = value;
    *slot += 1;
}

/// Pairs the half-edges of one edge, lowest face first: opposite traversals first, then the rest.
fn pair_run(run: &[Entry], mates: &mut [u32]) {
    let mut record = |first: Entry, second: Option<Entry>| {
        let Some(second) = second else {
            mates[first.half_edge() as usize] = BOUNDARY;
            return;
        };
        // The flag is set here, where both entries are in the cache. Looking up the mate's corners later costs a cache miss
        // for each record.
        let inconsistent = if first.is_opposite(second) { 0 } else { INCONSISTENT_BIT };
        mates[first.half_edge() as usize] = second.half_edge() | inconsistent;
        mates[second.half_edge() as usize] = first.half_edge() | inconsistent;
    };
    match *run {
        [single] => record(single, None),
        [first, second] => record(first, Some(second)),
        _ => {
            // The i-th half-edge of one direction meets the i-th of the other.
            let forward = || run.iter().copied().filter(|entry| !entry.is_opposite(run[0]));
            let backward = || run.iter().copied().filter(|entry| entry.is_opposite(run[0]));
            forward().zip(backward()).for_each(|(first, second)| record(first, Some(second)));
            let paired = forward().count().min(backward().count());
            let mut rest = forward().skip(paired).chain(backward().skip(paired));
            while let Some(first) = rest.next() {
                record(first, rest.next());
            }
        }
    }
}

/// Whether a face names a vertex twice.
pub(crate) fn is_degenerate([a, b, c]: [u32; 3]) -> bool {
    a == b || b == c || c == a
}
