//! The origin of instances.

use glam::DAffine3;

/// The transform of an instance.
#[derive(Clone, Copy, Debug)]
pub(super) enum Frame {
    /// The node's world matrix times this matrix.
    Node(DAffine3),
    /// The joints of a skin. The node's own matrix does not matter.
    Skin(usize),
}

/// The origin of an instance of the model.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    pub(super) mesh: usize,
    /// The node. `None`: a mesh that no node names, in a file without scenes.
    pub(super) node: Option<usize>,
    pub(super) frame: Frame,
}
