//! Shadow volumes: which faces cast and how is counted, chosen on the GPU; sides and caps by indirect draws.

mod choice;
mod draws;
mod pipelines;
mod volumes;

pub(super) use pipelines::VolumeKey;
pub use pipelines::{ShadowFormat, ShadowFormatError, ShadowPipelines};
pub use volumes::{ShadowDrawError, ShadowError, ShadowOptions, ShadowVolumes};
