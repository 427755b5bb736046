//! Rimline finds the silhouettes of triangle meshes on the GPU, for up to 1,024 lights at a time. It turns them into
//! shadow volumes. It reads nothing back: the results stay in GPU buffers. These are facing masks for each face,
//! silhouette and winding masks for each edge, a list of silhouette edges for each light, and the arguments of indirect
//! draws.
//!
//! Rimline follows Brabec and Seidel, "Shadow Volumes on Programmable Graphics Hardware" (2003). Unlike their method,
//! it decides a face's side once, so silhouettes close whatever the rounding.
//!
//! * [`Mesh`]: welds any triangles and finds their edge records. The surface may be closed, open, non-manifold or
//!   inconsistently oriented.
//! * [`gpu::Extractor`]: extracts silhouettes on your device, in your encoder, from your position buffer.
//! * [`gpu::Pipelines`]: the compiled pipelines, which many meshes on one device share.
//! * [`gpu::Deformer`]: computes morph targets, skins and your own displacement, from a [`Model`] and a [`Pose`].
//! * [`gpu::OutlinePipeline`]: draws silhouettes, boundaries, creases and marked edges as lines of a width, hidden behind your depth.
//! * [`gpu::Extraction::read_edges`]: a light's silhouette as oriented edges and chains, for tools.
//! * [`gpu::include_wgsl`]: WGSL that reads the results in your own shaders.
//! * [`gpu::Scene`]: stencil shadows of one caster or many in your render pass. The GPU chooses the counting method for each
//!   caster, light and view. It deforms models itself, as far as a frame needs them.
//! * [`gpu::ShadowMasks`]: the same as masks, from depth without a stencil.
//! * [`gpu::DepthMapVolumes`]: stencil shadows of what has no mesh, rebuilt from the depth map of a light. [`gpu::DepthMapCube`]
//!   takes six maps around a light, [`gpu::DepthMapMerge`] makes two maps one, [`gpu::DepthMapConversion`]
//!   takes distances, and [`gpu::MeshDepth`] and [`gpu::SceneDepth`] draw a mesh or a scene into a map.
//! * [`gpu::ShadowQuery`]: counts the faces between points and lights.
//! * [`AreaLight`]: samples lights that have an area. The samples share one extraction.
//! * [`cpu`]: extraction, deformation and the shadow depth query without a device. Extraction and query give the same
//!   bits as the GPU.
//! * `gltf`: loads models from glTF 2.0 files (feature `gltf`, on by default).
//! * Without the feature `gpu`, on by default, the library brings neither wgpu nor naga: meshes, models, lights and [`cpu`] stay.
//! * [`Origin`]: moves models with large coordinates, such as those of surveys, to where `f32` is fine.
//!
//! Files of `docs/numerics` that these pages name, with error bounds and proofs, and those of `tests` lie in the repository, not in
//! the package.
//!
//! ```no_run
//! use rimline::gpu::{Extraction, Extractor, ExtractorOptions, PositionBuffer};
//! use rimline::{Light, Mesh, mesh::Weld, wgpu};
//!
//! /// Call this once for each mesh.
//! fn prepare(
//!     device: &wgpu::Device,
//!     positions: &[[f32; 3]],
//!     faces: &[[u32; 3]],
//! ) -> Result<Extractor, Box<dyn std::error::Error>> {
//!     let mesh = Mesh::new(positions, faces, Weld::Position)?;
//!     Ok(Extractor::new(device, &mesh, ExtractorOptions { max_lights: 2, ..Default::default() })?)
//! }
//!
//! /// Call this every frame, after whatever moves the vertices.
//! fn silhouettes(
//!     extractor: &mut Extractor,
//!     encoder: &mut wgpu::CommandEncoder,
//!     position_buffer: &wgpu::Buffer,
//! ) -> Result<Extraction, Box<dyn std::error::Error>> {
//!     let vertices = PositionBuffer { buffer: position_buffer, offset: 0, stride: 12 };
//!     let lights = [Light::point([0.0, 5.0, 2.0]), Light::directional([1.0, 1.0, 0.0])];
//!     // `Extraction::draw` then draws a light's silhouette edges with your pipeline.
//!     Ok(extractor.encode(encoder, vertices, &lights)?)
//! }
//! ```
//!
//! Whatever writes depth casts: distance fields, alpha-tested leaves, points. A depth map of a light is all that it takes:
//!
//! ```no_run
//! use rimline::gpu::{DepthMap, DepthMapFrame, DepthMapOptions, DepthMapPipelines, DepthMapVolumes, ShadowFormat};
//! use rimline::{ShadowCamera, wgpu};
//!
//! /// Call this once for each size of map. A draw turns bit 0 of the stencil round where there is shadow. Where volumes of
//! /// meshes count in the same stencil, take `DepthMapPipelines::beside_meshes`.
//! fn prepare(
//!     device: &wgpu::Device,
//!     format: &ShadowFormat,
//! ) -> Result<(DepthMapPipelines, DepthMapVolumes), Box<dyn std::error::Error>> {
//!     let pipelines = DepthMapPipelines::new(device, format, 0)?;
//!     let volumes = DepthMapVolumes::new(&pipelines, [1024, 1024], DepthMapOptions::default())?;
//!     Ok((pipelines, volumes))
//! }
//!
//! /// Call this every frame, after whatever draws the map.
//! fn shadows(
//!     volumes: &mut DepthMapVolumes,
//!     encoder: &mut wgpu::CommandEncoder,
//!     map: &DepthMap<'_>,
//!     eye: &ShadowCamera,
//! ) -> Result<DepthMapFrame, Box<dyn std::error::Error>> {
//!     // `DepthMapFrame::draw` then draws into a pass that has your depth and a stencil of 0.
//!     Ok(volumes.encode(encoder, map, eye)?)
//! }
//! ```

#![forbid(unsafe_code)]
#![cfg_attr(
    not(feature = "reference"),
    allow(dead_code, unreachable_pub, reason = "CPU references and layouts that the feature `reference` shows")
)]
#![cfg_attr(docsrs, feature(doc_cfg))]

mod area;
#[cfg(feature = "gpu")]
mod compose;
pub mod cpu;
#[cfg(feature = "gpu")]
pub mod displace;
#[cfg(feature = "gltf")]
pub mod gltf;
#[cfg(feature = "gpu")]
pub mod gpu;
mod layout;
mod lift;
mod light;
pub mod mesh;
mod method;
pub mod model;
mod origin;
#[cfg(feature = "reference")]
pub mod reference;
mod shadow;
#[cfg(feature = "gpu")]
mod stages;
mod transform;
#[cfg(feature = "gpu")]
mod turns;

pub use area::{AreaLight, AreaShape};
#[cfg(feature = "gpu")]
pub use displace::{DisplaceError, Displacement};
pub use light::{Cone, Light, LightError, MAX_LIGHTS};
pub use mesh::{Mesh, MeshError};
pub use method::Predicate;
pub use model::{
    Geometry, GeometryOptions, Influences, Instance, InstancePose, Matrix3x4, Model, ModelBounds, ModelError, Pose,
};
pub use origin::Origin;
pub use shadow::{CameraError, Counting, DepthDirection, ShadowCamera, falloff};
pub use transform::Transform;

#[cfg(feature = "gpu")]
pub use wgpu;

/// Compiles the README's examples.
#[cfg(all(doctest, feature = "gpu"))]
#[doc = include_str!("../README.md")]
struct Readme;
