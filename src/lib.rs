//! Rimline finds the silhouettes of triangle meshes on the GPU, for up to 1,024 lights at a time, and leaves them in
//! GPU buffers: facing masks a face, silhouette and winding masks an edge, lists of silhouette edges a light, and
//! arguments for indirect draws. Nothing is read back. It follows Brabec and Seidel, "Shadow Volumes on Programmable
//! Graphics Hardware" (2003), with a face's side decided once, so that silhouettes close whatever the rounding.
//!
//! * [`Mesh`]: any triangles at all, welded, with edge records for closed, open, non-manifold and inconsistently
//!   oriented surfaces;
//! * [`gpu::Extractor`]: the extraction on your device, in your encoder, from your position buffer;
//! * [`gpu::Pipelines`]: what many meshes on one device share;
//! * [`gpu::Deformer`]: morph targets, skins and a displacement of yours, from a [`Model`] and a [`Pose`];
//! * [`gpu::include_wgsl`]: reads the results in your own shaders;
//! * [`gpu::ShadowVolumes`]: stencil shadows in your render pass, the counting method chosen on the GPU for every caster
//!   and light;
//! * [`gpu::ShadowQuery`]: how many faces lie between points and lights;
//! * [`AreaLight`]: lights with an area, as samples that share one extraction;
//! * [`cpu`]: the same stages on the CPU, the GPU's bit-for-bit reference;
//! * `gltf`: models from glTF 2.0 files (feature `gltf`, on by default).
//!
//! ```no_run
//! use rimline::gpu::{Extraction, Extractor, ExtractorOptions, PositionBuffer};
//! use rimline::{Light, Mesh, mesh::Weld, wgpu};
//!
//! /// Once a mesh.
//! fn prepare(
//!     device: &wgpu::Device,
//!     positions: &[[f32; 3]],
//!     faces: &[[u32; 3]],
//! ) -> Result<Extractor, Box<dyn std::error::Error>> {
//!     let mesh = Mesh::new(positions, faces, Weld::Position)?;
//!     Ok(Extractor::new(device, &mesh, ExtractorOptions { max_lights: 2, ..Default::default() })?)
//! }
//!
//! /// Every frame, after whatever moves the vertices.
//! fn silhouettes(
//!     extractor: &mut Extractor,
//!     encoder: &mut wgpu::CommandEncoder,
//!     position_buffer: &wgpu::Buffer,
//! ) -> Result<Extraction, Box<dyn std::error::Error>> {
//!     let vertices = PositionBuffer { buffer: position_buffer, offset: 0, stride: 12 };
//!     let lights = [Light::point([0.0, 5.0, 2.0]), Light::directional([1.0, 1.0, 0.0])];
//!     // `Extraction::draw` then draws a light's silhouette edges with your pipeline.
//!     Ok(extractor.encode(encoder, vertices, &lights, None)?)
//! }
//! ```

#![forbid(unsafe_code)]
#![cfg_attr(
    not(feature = "reference"),
    allow(dead_code, unreachable_pub, reason = "twins and layouts that the feature `reference` shows")
)]
#![cfg_attr(docsrs, feature(doc_cfg))]

mod area;
pub mod cpu;
pub mod displace;
#[cfg(feature = "gltf")]
pub mod gltf;
pub mod gpu;
mod layout;
mod light;
pub mod mesh;
mod method;
pub mod model;
#[cfg(feature = "reference")]
pub mod reference;
mod shadow;
mod stages;

pub use area::{AreaLight, AreaShape};
pub use displace::{DisplaceError, Displacement};
pub use light::{Light, LightError, MAX_LIGHTS};
pub use mesh::{Mesh, MeshError};
pub use method::Predicate;
pub use model::{
    Geometry, GeometryOptions, Influences, Instance, InstancePose, Matrix3x4, Model, ModelError, Pose, PoseMismatch,
    PosedMeshError,
};
pub use shadow::{CameraError, Counting, DepthDirection, ShadowCamera, falloff};

pub use wgpu;

/// The README's example, compiled.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
