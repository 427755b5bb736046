//! Shadow volumes. The GPU chooses the faces that cast and the counting method. Indirect draws draw sides and caps.

pub(crate) mod buffers;
pub(crate) mod draws;
pub(crate) mod errors;
pub(crate) mod format;
mod frame;
mod options;
mod passes;
pub(crate) mod pipelines;
pub(crate) mod scene_pipelines;
pub(crate) mod sizes;
pub(crate) mod source;
pub(crate) mod stages;
mod volumes;

pub use format::ShadowFormat;
pub use frame::ShadowFrame;
pub use options::ShadowOptions;
pub use pipelines::ShadowPipelines;
pub use scene_pipelines::ScenePipelines;
pub use volumes::ShadowVolumes;
