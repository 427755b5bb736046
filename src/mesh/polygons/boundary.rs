//! Boundaries: the edges of a polygon that remain when those that it walks both ways have cancelled.

/// Finds boundaries. It reuses its memory from one polygon to the next.
#[derive(Default)]
pub(super) struct Walker {
    /// Edges with their lower vertex first, whether that reversed them, and their index.
    sorted: Vec<([u32; 2], bool, u32)>,
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
        self.sorted.extend(edges.map(|(index, &[a, b])| ([a.min(b), a.max(b)], a > b, index)));
        self.sorted.sort_unstable();
        if self.sorted.windows(2).all(|pair| pair[0].0 != pair[1].0) {
            return;
        }
        self.is_cancelled.clear();
        self.is_cancelled.resize(self.sorted.len(), false);
        for edges_of_pair in self.sorted.chunk_by(|p, q| p.0 == q.0) {
            // Edges of one direction come before those of the other.
            let (forward, backward) =
                edges_of_pair.split_at(edges_of_pair.partition_point(|&(_, is_reversed, _)| !is_reversed));
            for (&(.., one), &(.., other)) in forward.iter().zip(backward) {
                self.is_cancelled[one as usize] = true;
                self.is_cancelled[other as usize] = true;
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
