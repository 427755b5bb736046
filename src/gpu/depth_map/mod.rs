//! Volumes from depth maps: the boundary between light and shadow is rebuilt from what a light sees.

mod bound;
mod cast;
mod caster;
mod casters;
mod casters_errors;
mod casters_frame;
mod checks;
mod contours;
mod conversion;
mod convex;
mod cube;
mod edges;
mod frame;
mod frame_errors;
mod jitter;
mod meeting;
mod merge;
mod mesh_depth;
mod mesh_depth_errors;
pub(crate) mod metric;
pub(crate) mod near;
mod options;
pub(crate) mod pipelines;
mod recording;
mod scene_depth;
mod statistics;
mod texture;
pub(crate) mod view;
mod volumes;
mod volumes_errors;
mod written;

pub use caster::{
    DepthMapCaster, DepthMapCasterCounts, DepthMapCasterHandle, DepthMapCasterVolumes, DepthMapCastersOptions,
    DepthMapCubeCaster,
};
pub use casters::DepthMapCasters;
pub use casters_errors::DepthMapCastersError;
pub use casters_frame::DepthMapCastersFrame;
pub use conversion::DepthMapConversion;
pub use cube::DepthMapCube;
pub use frame::{DepthMapFrame, DepthMapNearCap};
pub use frame_errors::{DepthMapDrawError, DepthMapEncodeError, DepthMapTexture};
pub use merge::DepthMapMerge;
pub use mesh_depth::MeshDepth;
pub use mesh_depth_errors::{MeshDepthError, SceneDepthError};
pub use metric::DepthMetric;
pub use options::{DanglingEdges, DepthEdges, DepthMap, DepthMapOptions, DepthMapReconstruction};
pub use pipelines::DepthMapPipelines;
pub use scene_depth::{SceneDepth, SceneDepthCounts};
pub use statistics::DepthMapStatistics;
pub use volumes::DepthMapVolumes;
pub use volumes_errors::{CubeMismatch, DepthMapCubeError, DepthMapPipelinesError, DepthMapVolumesError};
