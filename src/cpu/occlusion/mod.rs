//! Occluded faces: their shadow lies wholly in the shadow of other faces; docs/numerics/occluded-faces.md.

pub(crate) mod clipped;
pub(crate) mod cones;
pub(crate) mod min_cut;
pub(crate) mod occluded_faces;
pub(crate) mod options;
pub(crate) mod order;
pub(crate) mod plane;
pub(crate) mod search;
pub(crate) mod silhouette;
pub(crate) mod tree;
