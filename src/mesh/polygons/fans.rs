//! Fans over closed loops of edges.

/// Directed edges that have no triangle yet. Equally many begin and end at each vertex.
#[derive(Default)]
pub(super) struct OpenEdges {
    /// Edges with their lower vertex first, and whether that reversed them.
    added: Vec<([u32; 2], bool)>,
    edges: Vec<[u32; 2]>,
    /// For each vertex that edges begin at: the vertex, and which of these edges was not walked yet.
    next: Vec<(u32, usize)>,
    /// The vertices of a walk, and for each vertex of `next` its index in it.
    path: Vec<u32>,
    path_indices: Vec<Option<usize>>,
}

impl OpenEdges {
    pub(super) fn clear(&mut self) {
        self.added.clear();
    }

    pub(super) fn add(&mut self, [a, b]: [u32; 2]) {
        self.added.push(([a.min(b), a.max(b)], a > b));
    }

    /// Appends fans whose boundary is the edges, where those that run both ways have cancelled.
    pub(super) fn append_fans(&mut self, triangles: &mut Vec<[u32; 3]>) {
        self.cancel();
        if self.edges.is_empty() {
            return;
        }
        self.edges.sort_unstable();
        self.next.clear();
        for (index, &[start, _]) in self.edges.iter().enumerate() {
            if self.next.last().is_none_or(|&(last, _)| last != start) {
                self.next.push((start, index));
            }
        }
        self.path_indices.clear();
        self.path_indices.resize(self.next.len(), None);
        for first in 0..self.next.len() {
            self.walk(first, triangles);
        }
    }

    fn cancel(&mut self) {
        self.added.sort_unstable();
        self.edges.clear();
        for run in self.added.chunk_by(|p, q| p.0 == q.0) {
            let [a, b] = run[0].0;
            let reversed = run.iter().filter(|edge| edge.1).count();
            let straight = run.len() - reversed;
            let edge = if reversed > straight { [b, a] } else { [a, b] };
            self.edges.extend(std::iter::repeat_n(edge, reversed.abs_diff(straight)));
        }
    }

    /// Walks along edges from a vertex of `next` until none leads on. Where the walk meets a vertex of its path again, it
    /// has closed a loop.
    fn walk(&mut self, first: usize, triangles: &mut Vec<[u32; 3]>) {
        let mut current = first;
        self.path.push(self.next[current].0);
        self.path_indices[current] = Some(0);
        while let Some(end) = self.take_edge(current) {
            // Every vertex that an edge ends at has an edge that begins there.
            let Ok(reached) = self.next.binary_search_by_key(&end, |&(vertex, _)| vertex) else { break };
            current = reached;
            let Some(loop_start) = self.path_indices[reached] else {
                self.path_indices[reached] = Some(self.path.len());
                self.path.push(end);
                continue;
            };
            let around = &self.path[loop_start..];
            triangles.extend(around[1..].windows(2).map(|pair| [end, pair[0], pair[1]]));
            for vertex in self.path.drain(loop_start + 1..) {
                if let Ok(left) = self.next.binary_search_by_key(&vertex, |&(vertex, _)| vertex) {
                    self.path_indices[left] = None;
                }
            }
        }
        self.path.clear();
        self.path_indices[first] = None;
    }

    /// The end of an edge from the current vertex that was not walked yet.
    fn take_edge(&mut self, current: usize) -> Option<u32> {
        let (vertex, index) = &mut self.next[current];
        let &[start, end] = self.edges.get(*index)?;
        *index += 1;
        (start == *vertex).then_some(end)
    }
}
