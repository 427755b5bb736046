//! Deformation on the GPU: morph targets, skins, displacement.

pub(crate) mod deformer;
mod model_data;
