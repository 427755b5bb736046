//! Occluded faces: their shadow lies wholly in the shadow of other faces; docs/numerics/occluded-faces.md.
//!
//! `occluded_faces` has the public type. For one light, `search` goes through `cones` of directions, and grows a BSP tree in
//! each (`tree`), front to back (`order`). Then `silhouette` chooses by a `min_cut` which of the occluded faces are left out.

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
