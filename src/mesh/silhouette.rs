//! The silhouette of a mesh as a list of edges, and as chains of them.

use super::faces::Mesh;
use super::topology::EdgeKind;

/// The silhouette edges of a mesh for one light, in the order of their records. For outlines the eye is the light.
///
/// Boundary edges are always part of it, but for those of twisted polygons. For a light for which a polygon is
/// twisted, the polygon counts nowhere, and the edges of its neighbours are boundaries.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Silhouette {
    edges: Vec<SilhouetteEdge>,
}

/// An edge of a [`Silhouette`]. Seen from the light, its faces lie to its left, so a closed body is surrounded
/// counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SilhouetteEdge {
    /// The index of the edge in [`Mesh::edges`].
    pub record: u32,
    /// The vertices that the edge runs from and to.
    pub vertices: [u32; 2],
    /// How its faces meet.
    pub kind: EdgeKind,
}

/// Silhouette edges in a row: each begins at the vertex where the one before ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chain {
    /// The vertices along the chain. A closed chain does not repeat its first vertex, so it has as many vertices as
    /// edges. An open one has one more.
    pub vertices: Vec<u32>,
    /// The index in [`Mesh::edges`] of the edge that begins at each vertex.
    pub records: Vec<u32>,
    /// Whether the last edge ends at the first vertex.
    pub is_closed: bool,
}

impl Silhouette {
    /// The edges of these records, in any order. Each has the winding bit, as in [`EdgeMasks`](crate::layout::EdgeMasks).
    pub(crate) fn new(mesh: &Mesh, records: impl IntoIterator<Item = (u32, bool)>) -> Self {
        let oriented = |(record, winding): (u32, bool)| {
            let edge = mesh.edges().get(record as usize)?;
            let [a, b] = edge.vertices;
            let vertices = if winding { [a, b] } else { [b, a] };
            Some(SilhouetteEdge { record, vertices, kind: edge.kind })
        };
        let mut edges: Vec<_> = records.into_iter().filter_map(oriented).collect();
        edges.sort_unstable_by_key(|edge| edge.record);
        Self { edges }
    }

    /// The edges, each once.
    pub fn edges(&self) -> &[SilhouetteEdge] {
        &self.edges
    }

    /// Joins the edges to chains, each edge in one of them: first open chains, then closed ones.
    ///
    /// The silhouette of a closed and consistently oriented mesh has closed chains only. On other meshes an edge between a
    /// front-facing and a back-facing face may end at a boundary, and the chain with it. Where several chains meet at a
    /// vertex, boundary edges go on as boundary edges if they can. It is not decided geometrically which of them goes
    /// on as which.
    pub fn chains(&self) -> Vec<Chain> {
        const NONE: u32 = u32::MAX;
        let ends_at = |end: usize| {
            let key = |(number, edge): (u32, &SilhouetteEdge)| End {
                vertex: edge.vertices[end],
                is_boundary: edge.kind == EdgeKind::Boundary,
                number,
            };
            let mut keys: Vec<_> = (0..).zip(&self.edges).map(key).collect();
            keys.sort_unstable();
            keys
        };
        let mut next = vec![NONE; self.edges.len()];
        let (ends, starts) = join(&mut next, ends_at(1), ends_at(0), |end| (end.vertex, end.is_boundary));
        join(&mut next, ends, starts, |end| (end.vertex, false));

        let mut is_begun = vec![true; self.edges.len()];
        next.iter().filter(|&&to| to != NONE).for_each(|&to| is_begun[to as usize] = false);
        let begins: Vec<usize> = (0..self.edges.len()).filter(|&edge| is_begun[edge]).collect();
        let mut is_taken = vec![false; self.edges.len()];
        let mut chains = Vec::new();
        for begin in begins.into_iter().chain(0..self.edges.len()) {
            let mut chain = Chain { vertices: Vec::new(), records: Vec::new(), is_closed: false };
            let mut edge = begin;
            while let Some(is_taken @ false) = is_taken.get_mut(edge) {
                *is_taken = true;
                chain.vertices.push(self.edges[edge].vertices[0]);
                chain.records.push(self.edges[edge].record);
                chain.is_closed = next[edge] as usize == begin;
                if next[edge] == NONE {
                    chain.vertices.push(self.edges[edge].vertices[1]);
                }
                edge = next[edge] as usize;
            }
            if !chain.records.is_empty() {
                chains.push(chain);
            }
        }
        chains
    }
}

/// An edge at a vertex where it ends or starts. Ends are sorted by their fields, in order.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct End {
    vertex: u32,
    /// Whether the edge is a boundary edge.
    is_boundary: bool,
    /// The number of the edge.
    number: u32,
}

/// Lets edges that end go on as edges that start with the same key, in order. Both are sorted by the key. Returns the rest.
fn join(next: &mut [u32], ends: Vec<End>, starts: Vec<End>, key: impl Fn(&End) -> (u32, bool)) -> (Vec<End>, Vec<End>) {
    let (mut other_ends, mut other_starts) = (Vec::new(), Vec::new());
    let mut starts = starts.into_iter().peekable();
    for end in ends {
        while let Some(start) = starts.next_if(|start| key(start) < key(&end)) {
            other_starts.push(start);
        }
        match starts.next_if(|start| key(start) == key(&end)) {
            Some(start) => next[end.number as usize] = start.number,
            None => other_ends.push(end),
        }
    }
    other_starts.extend(starts);
    (other_ends, other_starts)
}
