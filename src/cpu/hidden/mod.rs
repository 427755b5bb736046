//! Occluded faces: their shadow lies wholly in the shadow of other faces; docs/numerics/hidden-faces.md.

pub(crate) mod clipped;
pub(crate) mod cones;
pub(crate) mod hidden_faces;
pub(crate) mod min_cut;
pub(crate) mod options;
pub(crate) mod order;
pub(crate) mod plane;
pub(crate) mod search;
pub(crate) mod silhouette;
pub(crate) mod tree;
