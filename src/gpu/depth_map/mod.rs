//! Volumes from depth maps: the boundary between light and shadow is rebuilt from what a light sees.

mod bound;
mod contours;
mod conversion;
mod cube;
mod edges;
mod error;
pub(crate) mod frame;
mod jitter;
mod meeting;
mod merge;
mod mesh_depth;
pub(crate) mod metric;
pub(crate) mod near;
mod options;
pub(crate) mod pipelines;
mod recording;
mod scene_depth;
mod stage;
mod statistics;
mod texture;
pub(crate) mod view;
mod volumes;
mod written;

pub use conversion::DepthMapConversion;
pub use cube::DepthMapCube;
pub use error::DepthMapError;
pub use frame::DepthMapFrame;
pub use merge::DepthMapMerge;
pub use mesh_depth::MeshDepth;
pub use metric::DepthMetric;
pub use options::{DanglingEdges, DepthCubeMaps, DepthMap, DepthMapMethod, DepthMapOptions};
pub use pipelines::DepthMapPipelines;
pub use scene_depth::{SceneDepth, SceneDepthCounts};
pub use statistics::DepthMapStatistics;
pub use volumes::DepthMapVolumes;
