//! Volumes from depth maps: the boundary between light and shadow is rebuilt from what a light sees.

mod errors;
mod frame;
mod options;
mod pipelines;
mod view;
mod volumes;

pub use errors::{DepthMapDrawError, DepthMapEncodeError, DepthMapPipelinesError, DepthMapVolumesError};
pub use frame::DepthMapFrame;
pub use options::{DepthEdges, DepthMap, DepthMapOptions};
pub use pipelines::DepthMapPipelines;
pub use volumes::DepthMapVolumes;
