//! Loads glTF 2.0 files: triangles, skins, morph targets, animations, instances, punctual lights.
//!
//! This is what is read, in the order of the glTF 2.0 specification, and what is decided where it leaves a choice:
//!
//! * **Scene.** All nodes of the default scene are loaded, or of the first scene if none is marked as default. A file
//!   without scenes gives all nodes, and then the meshes that no node names, without a transform. Every mesh, skin and
//!   animation of the file is read and checked, whatever the scene holds.
//! * **Primitives.** All triangle primitives of a mesh make one [`Geometry`](crate::Geometry). Points, lines, and
//!   primitives without positions are skipped and counted, see [`Asset::skipped`]. So a file may have no faces at all.
//! * **Large coordinates.** Transforms of nodes are composed in `f64`. [`Asset::set_origin`] subtracts a point near the
//!   scene there, before anything becomes `f32`. The center of `CESIUM_RTC` is added to the places of all nodes.
//! * **Joints.** A vertex follows the joints whose weight is not zero. Weights are scaled to the sum 1. If all are
//!   zero, the vertex follows the first joint listed. A joint of weight zero may have any index. A mesh that is used
//!   both with and without a skin gives two geometries.
//! * **Matrices.** The last row of a matrix may differ from (0, 0, 0, 1) by 10⁻⁵, and is then taken as that. Rotations
//!   are scaled to length 1.
//! * **Animations.** If several channels of an animation move the same property, the last one applies. Channels are
//!   ignored with a warning if they have no target node or an unknown path, or move the morph weights of a node without
//!   morph targets.
//! * **Accessors.** A quantised attribute is accepted if the file says that it uses `KHR_mesh_quantization`. Draco and
//!   meshopt data are never read; a file is refused where the plain data beside them is missing. Alignment is not
//!   checked.
//! * **Files.** Buffers are read from data URIs, and from regular files in the folder of the glTF or below it. A file
//!   outside, reached by a symbolic link or `..`, is refused unless [`LoadOptions::allow_outside`] is set. Images are
//!   never read.
//! * **Memory.** Memory is charged against [`LoadOptions::memory_limit`] before it is allocated.

mod animation;
mod asset;
mod budget;
mod buffers;
mod container;
mod curve;
mod document;
mod error;
mod estimate;
mod extensions;
mod files;
mod formats;
mod geometry;
mod graph;
mod info;
mod instances;
mod json;
mod lengths;
mod named_files;
mod node_state;
mod options;
mod origin;
mod parse;
mod parse_mesh;
mod parse_scene;
mod placement;
mod pose;
mod reader;
mod scene_light;
mod skin;
mod transforms;
mod triangles;
mod vertices;

pub use asset::Asset;
pub use error::{AccessorProblem, AnimationError, GltfError};
pub use info::{AnimationInfo, MeshInfo, SkinInfo, SkippedPrimitives};
pub use options::LoadOptions;
pub use origin::SceneExtent;
pub use scene_light::{SceneLight, SceneLightKind, SpotCone};
