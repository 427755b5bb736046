//! Shadow volumes. The GPU chooses the faces that cast and the counting method. Indirect draws draw sides and caps.

pub(crate) mod buffers;
pub(crate) mod errors;
pub(crate) mod format;
mod passes;
pub(crate) mod pipelines;
pub(crate) mod shadow_pipelines;
pub(crate) mod sizes;
pub(crate) mod stages;

pub use format::ShadowFormat;
pub use shadow_pipelines::ShadowPipelines;
