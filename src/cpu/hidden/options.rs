//! Options of the search for hidden faces.

use crate::cpu::common::parallel::Threads;

/// Bounds on the work, and what to leave out. Faces that the bounds leave undecided stay casters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HiddenOptions {
    /// The most nodes of all trees. A node and its planes take up to some 400 bytes. A tree has the share of its faces, and from
    /// there on no face hides others that did not before.
    pub max_nodes: usize,
    /// The most nodes and leaves that a face visits in a tree.
    pub max_steps: usize,
    /// Threads that search. The result does not depend on them.
    pub threads: Threads,
    /// Leave out all hidden faces, as published, also where that gives silhouettes more edges. Else the choice among them is the
    /// one with the fewest edges, and of several the one that leaves out most faces.
    pub leave_out_all: bool,
}

impl Default for HiddenOptions {
    fn default() -> Self {
        Self { max_nodes: 1 << 21, max_steps: 4096, threads: Threads::all(), leave_out_all: false }
    }
}
