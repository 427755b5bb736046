//! Shadow volumes. The GPU chooses the faces that cast and the counting method. Indirect draws draw sides and caps.

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
