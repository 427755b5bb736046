//! Boundaries: the edges of a polygon that remain when those that it walks both ways have cancelled.

/// An edge. Edges are sorted by their fields, in order.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct SortedEdge {
    /// The lower vertex first.
    vertices: [u32; 2],
    /// Whether that reversed it.
    is_reversed: bool,
    index: u32,
}

/// Finds boundaries. It reuses its memory from one polygon to the next.
#[derive(Default)]
pub(super) struct Walker {
    sorted: Vec<SortedEdge>,
    is_cancelled: Vec<bool>,
}

impl Walker {
    /// Appends the boundary of a polygon with these loops, in the order of its corners. Edges from a vertex to itself are
    /// left out. Edges of opposite directions between two vertices cancel, the earliest first.
    pub(super) fn append_boundary<'a>(&mut self, boundary: &mut Vec<[u32; 2]>, loops: impl Iterator<Item = &'a [u32]>) {
        let first = boundary.len();
        for corners in loops {
            let ends = corners.iter().skip(1).chain(corners.first());
            boundary.extend(corners.iter().zip(ends).map(|(&a, &b)| [a, b]).filter(|[a, b]| a != b));
        }
        let edges = (0..).zip(&boundary[first..]);
        self.sorted.clear();
        let sorted = |(index, &[a, b]): (u32, &[u32; 2])| {
            let vertices = [a.min(b), a.max(b)];
            SortedEdge { vertices, is_reversed: a > b, index }
        };
        self.sorted.extend(edges.map(sorted));
        self.sorted.sort_unstable();
        if self.sorted.windows(2).all(|pair| pair[0].vertices != pair[1].vertices) {
            return;
        }
        self.is_cancelled.clear();
        self.is_cancelled.resize(self.sorted.len(), false);
        for edges_of_pair in self.sorted.chunk_by(|p, q| p.vertices == q.vertices) {
            // Edges of one direction come before those of the other.
            let (forward, backward) = edges_of_pair.split_at(edges_of_pair.partition_point(|edge| !edge.is_reversed));
            for (one, other) in forward.iter().zip(backward) {
                self.is_cancelled[one.index as usize] = true;
                self.is_cancelled[other.index as usize] = true;
            }
        }
        let mut end = first;
        for (index, &is_cancelled) in (first..).zip(&self.is_cancelled) {
            if !is_cancelled {
                boundary[end] = boundary[index];
                end += 1;
            }
        }
        boundary.truncate(end);
    }
}

/// Whether directed edges are one loop of at least three, each beginning where the previous one ends.
pub(crate) fn is_loop<V: PartialEq>(edges: &[[V; 2]]) -> bool {
    let next = edges.iter().skip(1).chain(edges.first());
    edges.len() >= 3 && edges.iter().zip(next).all(|([_, end], [start, _])| end == start)
}
