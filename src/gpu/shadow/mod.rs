//! Shadow volumes: which faces cast and how is counted, chosen on the GPU; sides and caps by indirect draws.

mod buffers;
mod choice;
mod draws;
mod errors;
pub(crate) mod format;
mod frame;
mod options;
mod pipelines;
mod volumes;

pub use errors::{ShadowDrawError, ShadowEncodeError, ShadowVolumesError};
pub use format::{ShadowFormat, ShadowFormatError};
pub use frame::ShadowFrame;
pub use options::ShadowOptions;
pub use pipelines::ShadowPipelines;
pub use volumes::ShadowVolumes;
