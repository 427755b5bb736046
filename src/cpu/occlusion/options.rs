//! Options of the search for occluded faces.

use crate::cpu::common::parallel::Threads;

/// Bounds on the work, and which faces to leave out. Faces that the bounds leave undecided still cast.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OcclusionOptions {
    /// The most nodes of all trees together, of up to 400 bytes each with its planes. Default: 2²¹. Each tree has a
    /// share by its faces. Once it is full, no further face occludes others, so fewer faces are left out.
    pub max_nodes: usize,
    /// The most nodes and leaves that a face visits in a tree. Default: 4,096. A face that exceeds it still casts.
    pub max_steps: usize,
    /// Threads that search. Default: all. The result does not depend on them.
    pub threads: Threads,
    /// Leave out all occluded faces, as published, even if silhouettes then have more edges. Default: false, which leaves
    /// out those for which silhouettes have the fewest edges, and of several such choices the one with the most faces.
    pub leave_out_all: bool,
}

impl Default for OcclusionOptions {
    fn default() -> Self {
        Self { max_nodes: 1 << 21, max_steps: 4096, threads: Threads::all(), leave_out_all: false }
    }
}
