//! Shadow volumes: which faces cast and how is counted, chosen on the GPU; sides and caps by indirect draws.

mod buffers;
mod choice;
mod draws;
mod errors;
mod frame;
mod pipelines;
mod volumes;

pub use errors::{ShadowDrawError, ShadowEncodeError, ShadowVolumesError};
pub use frame::ShadowFrame;
pub(crate) use pipelines::VolumeKey;
pub use pipelines::{ShadowFormat, ShadowFormatError, ShadowPipelines};
pub use volumes::{ShadowOptions, ShadowVolumes};
