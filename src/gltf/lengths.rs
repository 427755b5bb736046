//! The lengths of a document's lists.

/// The lengths of the lists that indices point into.
#[derive(Clone, Copy)]
pub(super) struct Lengths {
    pub(super) buffers: usize,
    pub(super) views: usize,
    pub(super) accessors: usize,
    pub(super) meshes: usize,
    pub(super) skins: usize,
    pub(super) nodes: usize,
    pub(super) scenes: usize,
    pub(super) lights: usize,
}
