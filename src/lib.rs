//! Rimline finds the silhouettes of triangle meshes on the GPU, for up to 1,024 lights at a time. It turns them into
//! shadow volumes. It reads nothing back: the results stay in GPU buffers. These are facing masks for each face,
//! silhouette and winding masks for each edge, a list of silhouette edges for each light, and the arguments of indirect
//! draws.
//!
//! Rimline follows Brabec and Seidel, "Shadow Volumes on Programmable Graphics Hardware" (2003). Unlike their method,
//! it decides a face's side once, so silhouettes close for any rounding.
//!
//! # Five tasks
//!
//! **Outlines** as lines of a width in pixels, behind your depth. The eye is the light. Casters of a scene have them,
//! too, by [`OutlineSource::Scene`](gpu::OutlineSource):
//!
//! ```no_run
//! # use rimline::{gpu::*, *};
//! # fn f(device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder, mesh: &Mesh, vertices: PositionBuffer<'_>, eye: [f32; 3],
//! #     camera: &ShadowCamera, depth: &wgpu::TextureView, pass: &wgpu::RenderPassDescriptor<'_>,
//! # ) -> Result<(), Box<dyn std::error::Error>> {
//! // Once:
//! let outlines = OutlinePipeline::new(device, &OutlineFormat::of_pass(pass, depth)?)?;
//! let mut extractor = Extractor::new(device, mesh, ExtractorOptions::default())?;
//! // Every frame, after your depth pass:
//! let extraction = &extractor.encode(encoder, vertices, &[Light::point(eye)])?;
//! let style = OutlineStyle { width: 3.0, ..OutlineStyle::default() };
//! let of = OutlineSource::Extraction(extraction, 0);
//! let outline = outlines.prepare(&OutlineInputs { of, camera, depth, style, marked: None })?;
//! outline.draw(&mut encoder.begin_render_pass(pass))?;
//! # Ok(()) }
//! ```
//!
//! **Shadows in your pass**, by the stencil. One mesh or many, rigid or deformed:
//!
//! ```no_run
//! # use rimline::{gpu::*, *};
//! # fn f(device: &wgpu::Device, queue: &wgpu::Queue, encoder: &mut wgpu::CommandEncoder, mesh: &Mesh, rest: &[[f32; 3]],
//! #     camera: ShadowCamera, light_pass: &wgpu::RenderPassDescriptor<'_>) -> Result<(), Box<dyn std::error::Error>> {
//! // Once:
//! let format = ShadowFormat::of_pass(light_pass, &camera)?;
//! let pipelines = ShadowPipelines::new(device, &format, Counting::Auto)?;
//! let mut scene = Scene::new(device, queue, SceneOptions::default())?;
//! let mesh = scene.add_mesh(mesh, rest)?;
//! scene.insert(Caster::rigid(mesh, glam::Affine3A::IDENTITY))?;
//! let light = scene.add_light(Light::point([0.0, 5.0, 2.0]))?;
//! // Every frame; then for each light, where the stencil is 0 the light is seen (`ShadowFormat::light_pass_depth_stencil`):
//! let frame = scene.encode(encoder, FrameInputs::new(&[camera.into()]))?;
//! let mut pass = format.begin_pass(encoder, light_pass)?;
//! frame.draw(&mut pass, &pipelines, 0, light)?;
//! # Ok(()) }
//! ```
//!
//! **Shadow masks**, for a renderer without a stencil: a bit for each light and pixel, or a share of light:
//!
//! ```no_run
//! # use rimline::{gpu::*, *};
//! # fn f(device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder, frame: &SceneFrame, lights: &[LightHandle],
//! #     depth: &wgpu::TextureView, target: &wgpu::Texture) -> Result<(), ShadowError> {
//! let mut masks = ShadowMasks::new(device)?; // once
//! frame.write_masks(encoder, &mut masks, &MaskInputs { depth, view: 0, lights, target })?;
//! # Ok(()) }
//! ```
//!
//! **The list of edges**, for a tool, with or without a device:
//!
//! ```
//! use rimline::cpu::{Threads, extract};
//! use rimline::{Light, Mesh, Predicate, mesh::Weld};
//!
//! let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0_f32]];
//! let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
//! let mesh = Mesh::new(&positions, &faces, Weld::Position)?;
//! let eye = Light::point([5.0, 4.0, 3.0]);
//! let found = extract(&positions, &mesh, &[eye], Predicate::Exact, Threads::all())?;
//! let silhouette = found.silhouette(&mesh, 0); // on the GPU: `Extraction::read_edges`
//! assert_eq!((silhouette.edges().len(), silhouette.chains().len()), (3, 1));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! **How many faces are between points and lights**, exactly: `0` is lit. [`cpu::shadow_depth`] needs no device:
//!
//! ```no_run
//! # use rimline::{gpu::*, *};
//! # fn f(device: &wgpu::Device, queue: &wgpu::Queue, mesh: &Mesh, vertices: PositionBuffer<'_>, points: PositionBuffer<'_>)
//! #     -> Result<Vec<i32>, Box<dyn std::error::Error>> {
//! let mut query = ShadowQuery::new(device, mesh, ShadowQueryOptions::default())?;
//! let mut encoder = device.create_command_encoder(&Default::default());
//! query.encode_at(&mut encoder, vertices, points, 1000, &[Light::point([0.0, 5.0, 2.0])])?;
//! queue.submit([encoder.finish()]);
//! Ok(query.read_occluder_counts(queue)?)
//! # }
//! ```
//!
//! # What else there is
//!
//! * [`Mesh`] welds any triangles and polygons: closed, open, non-manifold or inconsistently oriented.
//! * [`gpu::Extractor`] and [`gpu::include_wgsl`]: silhouettes for your own shaders. [`gpu::Pipelines`] are shared by
//!   many meshes.
//! * [`Model`], [`Pose`], [`gpu::Deformer`]: morph targets, skins and your own displacement. A [`gpu::Scene`] deforms
//!   the models that a frame needs. `gltf` (a feature, on by default) loads them from glTF 2.0.
//! * [`gpu::depth_map`]: shadows of what has no mesh, from depth maps of a light (feature `depth-map`, on by default).
//! * [`AreaLight`]: samples lights that have an area. The samples share one extraction.
//! * [`cpu`]: extraction and the query with the GPU's bits, and deformation, without a device. Without the
//!   feature `gpu`, on by default, the library brings neither wgpu nor naga.
//! * Errors: an enum for each subject, whose messages say what fields are and what to do.
//! * [`Origin`]: moves models with large coordinates, such as those of surveys, to where `f32` is fine.
//!
//! Files of `docs/numerics` that these pages name, with error bounds and proofs, and those of `tests` lie in the
//! repository, not in the package.

#![forbid(unsafe_code)]
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
#[doc(hidden)]
pub mod internals;
mod layout;
mod lift;
mod light;
mod light_batch;
pub mod mesh;
mod method;
pub mod model;
mod origin;
mod shadow;
#[cfg(feature = "gpu")]
mod stages;
mod transform;
#[cfg(feature = "gpu")]
mod turns;

pub use area::{AreaLight, AreaShape};
#[cfg(feature = "gpu")]
pub use displace::{DisplaceError, Displacement};
pub use light::{Cone, Light, LightError, MAX_LIGHTS, check_lights, check_shadow_lights};
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
