//! Where instances come from.

use glam::DAffine3;

/// What moves an instance.
#[derive(Clone, Copy, Debug)]
pub(super) enum Frame {
    /// The node's world matrix times this one.
    Node(DAffine3),
    /// The joints of a skin; the node's own matrix counts for nothing.
    Skin(usize),
}

/// Where an instance of the model comes from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    pub(super) mesh: usize,
    /// `None`: a mesh that no node names, in a file without scenes.
    pub(super) node: Option<usize>,
    pub(super) frame: Frame,
}
