//! Shadows of casters without a mesh, from depth maps of a light (feature `depth-map`). The boundary between light and
//! shadow is rebuilt from the depths that the light sees, after Michael `McCool` (2000).
//!
//! Everything that writes depth casts a shadow: distance fields, alpha-tested leaves, points. [`DepthMapVolumes`] draws the
//! shadows of one map, [`DepthMapCube`] those of six maps around a light. [`DepthMapTexture`] merges two maps or
//! converts distances. [`MeshDepth`] and [`SceneDepth`] draw a mesh or a scene into a map.
//!
//! ```no_run
//! use rimline::gpu::ShadowFormat;
//! use rimline::gpu::depth_map::{DepthMap, DepthMapFrame, DepthMapOptions, DepthMapPipelines, DepthMapVolumes};
//! use rimline::{ShadowCamera, wgpu};
//!
//! /// Call this once for each size of map. A draw inverts bit 0 of the stencil where there is shadow. Where volumes of meshes
//! /// count in the same stencil, use `DepthMapPipelines::beside_meshes`.
//! fn prepare(
//!     device: &wgpu::Device,
//!     format: &ShadowFormat,
//! ) -> Result<(DepthMapPipelines, DepthMapVolumes), Box<dyn std::error::Error>> {
//!     let pipelines = DepthMapPipelines::new(device, format, 0)?;
//!     let volumes = DepthMapVolumes::new(&pipelines, [1024, 1024], DepthMapOptions::default())?;
//!     Ok((pipelines, volumes))
//! }
//!
//! /// Call this every frame, after the map is drawn.
//! fn shadows(
//!     volumes: &mut DepthMapVolumes,
//!     encoder: &mut wgpu::CommandEncoder,
//!     map: &DepthMap<'_>,
//!     eye: &ShadowCamera,
//! ) -> Result<DepthMapFrame, Box<dyn std::error::Error>> {
//!     // Then call `DepthMapFrame::draw` in a pass with your depth buffer and a stencil cleared to 0.
//!     Ok(volumes.encode(encoder, map, eye)?)
//! }
//! ```

mod bound;
mod contours;
mod cube;
mod edges;
mod error;
pub(crate) mod frame;
mod jitter;
mod meeting;
mod mesh_depth;
pub(crate) mod metric;
pub(crate) mod near;
mod options;
pub(crate) mod pipelines;
mod recording;
mod scene_depth;
mod texture;
pub(crate) mod view;
mod volumes;
mod written;

pub use crate::gpu::scene::depths::SceneDepthCasters;
pub use cube::DepthMapCube;
pub use error::DepthMapError;
pub use frame::{DepthMapFrame, DepthMapStatistics};
pub use mesh_depth::MeshDepth;
pub use metric::DepthMetric;
pub use options::{DanglingEdges, DepthCubeMaps, DepthMap, DepthMapMethod, DepthMapOptions};
pub use pipelines::DepthMapPipelines;
pub use scene_depth::{SceneDepth, SceneDepthCounts};
pub use volumes::DepthMapVolumes;
pub use written::DepthMapTexture;
