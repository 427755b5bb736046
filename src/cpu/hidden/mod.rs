//! Faces hidden by faces: those whose shadow lies wholly in the shadow of others; NUMERICS.md, "Faces hidden by faces".

pub(crate) mod hidden_faces;
pub(crate) mod order;
pub(crate) mod plane;
pub(crate) mod tree;
