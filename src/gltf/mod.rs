//! Loads glTF 2.0 files: triangles, skins, morph targets, animations, instances, punctual lights.
//!
//! This is what is read, in the order of the glTF 2.0 specification, and what is decided where it leaves a choice:
//!
//! * **Scene.** All nodes of the default scene are loaded, or of the first scene if none is marked as default. A file
//!   without scenes gives all nodes, and then the meshes that no node names, without a transform. Nodes that
//!   `KHR_node_visibility` hides, and those below them, have no instances and no lights. Animations do not show or hide
//!   nodes.
//! * **Damage.** Every mesh, skin and animation of the file is read and checked, and so is every part that the scene
//!   needs. A fault is an error where the scene needs the part, or where a caller requests it: an animation by
//!   [`Asset::pose`], a light by [`Asset::lights`]. It is a warning everywhere else, see [`Asset::warnings`].
//! * **Primitives.** All triangle primitives of a mesh make one [`Geometry`](crate::Geometry). Points, lines, and
//!   primitives without positions are skipped and counted, see [`Asset::skipped`]. So a file may have no faces at all.
//! * **Colours.** `baseColorFactor` of materials and `COLOR_0` give [`Asset::colors`], without alpha and clamped to 0
//!   to 1. A fault in them is a warning, and the colour is then white. A primitive without triangles or positions needs no
//!   colour, and `COLOR_0` of one that shares the vertices of an earlier one is not read; faults there get no warning.
//!   Textures are never read. If vertices at one position have different colours, all faces of the geometry get the mean of
//!   their corners.
//! * **Cameras** are read where a caller asks for them: [`Asset::each_camera`]. A fault in one is then an error, and no
//!   warning.
//! * **Large coordinates.** Transforms of nodes are composed in `f64`. [`Asset::set_origin`] subtracts a point near the
//!   scene there, before anything becomes `f32`. The center of `CESIUM_RTC` is added once, in world space.
//! * **Shared children.** A child of two nodes is placed, with a warning, below the first of them that a walk of the scene
//!   meets, or else below the first in the file.
//! * **Corners.** One or two corners that are left over in a list of triangles are ignored, with a warning. An index must
//!   not be the largest of its type. One that is gets a warning: in a list of triangles it names a vertex, if there is
//!   one. Elsewhere it begins a new triangle, strip or fan.
//! * **Positions** may be infinite or NaN, with a warning. Their faces stay; they face no light.
//! * **Joints.** A vertex follows the joints whose weight is not zero. Weights are scaled to the sum 1. If all are
//!   zero, the vertex follows the first joint listed. A joint of weight zero may have any index. A mesh that is used
//!   both with and without a skin gives two geometries.
//! * **Matrices.** The last row of a matrix may differ from (0, 0, 0, 1) by 10⁻⁵, and is then read as that. Rotations
//!   are scaled to length 1; one of length 0 is no rotation, with a warning, and in an animation a fault. The warning
//!   of a node's instances names the first such.
//! * **Animations.** Several play together unless two move the same property of a node. If several channels of one
//!   animation do, the last one applies. Keys of the same time are a step. Channels are ignored with a warning if they
//!   have no target node, a pointer (`KHR_animation_pointer`) or an unknown path, or move the morph weights of a node
//!   without morph targets.
//! * **Extensions.** A required extension that is not known refuses the file. One that is used, and that is known neither
//!   to be read nor to leave triangles where they are, is a warning.
//! * **Accessors.** A quantised attribute is accepted if the file says that it uses `KHR_mesh_quantization`. Draco and
//!   meshopt data are never read; a file is refused where the plain data beside them is missing. Alignment is not
//!   checked.
//! * **Files.** Buffers are read from data URIs, and from regular files in the folder of the glTF or below it. Names with
//!   percent signs are decoded, or taken as they are where only such a file is there. A file outside, reached by a
//!   symbolic link or `..`, is refused unless [`LoadOptions::allow_outside`] is set. [`Asset::from_slices`] asks
//!   its caller for each path and refuses none. Images are never read.
//! * **Memory.** Memory is charged against [`LoadOptions::memory_limit`] before it is allocated. Buffers that a caller of
//!   [`Asset::from_slices`] gives are charged then.

mod animation;
mod asset;
mod budget;
mod camera;
mod cameras;
mod colors;
mod container;
mod curve;
mod document;
mod error;
mod estimate;
mod extensions;
mod files;
mod geometry;
mod graph;
mod info;
mod instances;
mod json;
mod origin;
mod parse;
mod parse_scene;
mod pose;
mod reader;
mod skin;
mod triangles;
mod vertices;
mod warning;

pub use asset::Asset;
pub use camera::{CameraProjection, SceneCamera};
pub use colors::Colors;
pub use error::GltfError;
pub use info::{
    AnimationInfo, LoadOptions, MeshInfo, SceneLight, SceneLightKind, SkinInfo, SkippedPrimitives, SpotCone,
};
pub use origin::SceneExtent;
pub use warning::GltfWarning;
