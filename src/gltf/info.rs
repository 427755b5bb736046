//! How a file is loaded, and descriptions of its parts.

use super::error::GltfError;
use crate::light::Light;
use crate::mesh::Weld;

/// Options of [`Asset::open`](super::Asset::open), [`Asset::from_slice`](super::Asset::from_slice) and
/// [`Asset::from_slices`](super::Asset::from_slices).
///
/// A file beyond [`Self::memory_limit`] is refused: before its data is read if the counts in its JSON tell, else while it is
/// read. All allocations together, also those given back, may be eight times the limit, which bounds the time.
///
/// ```no_run
/// use rimline::gltf::{Asset, LoadOptions};
///
/// // An upload: refuse it if it takes more than 256 MiB.
/// let asset = Asset::open("upload.glb", LoadOptions { memory_limit: 256 << 20, ..LoadOptions::default() })?;
/// # Ok::<(), rimline::gltf::GltfError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoadOptions {
    /// Which vertices are welded. Default: [`Weld::Data`].
    pub weld: Weld,
    /// The largest memory, in bytes, that the file may take at one time: the files read, their JSON and data, the
    /// asset, and one pose, the lights, the cameras and the mesh of all instances ([`Model::mesh`](crate::Model::mesh)).
    /// [`GltfError::TooLarge`](super::GltfError::TooLarge) refuses the asset before more is taken. A mesh of a million
    /// faces and one instance counts about 0.1 GiB. The slice given to [`Asset::from_slice`](super::Asset::from_slice) or
    /// [`Asset::from_slices`](super::Asset::from_slices) and later data, such as a copy on the GPU, do not count. Default:
    /// [`LoadOptions::DEFAULT_MEMORY_LIMIT`].
    pub memory_limit: u64,
    /// Whether to read buffers outside the folder of the glTF, by `..`, an absolute path or a symbolic link. The author
    /// of the glTF chooses these files. Default: no. A buffer there that is used then gives
    /// [`GltfError::Outside`](super::GltfError::Outside), any other a warning.
    /// [`Asset::from_slices`](super::Asset::from_slices) ignores it.
    pub allow_outside: bool,
}

impl LoadOptions {
    /// 4 GiB, which is about forty million faces.
    pub const DEFAULT_MEMORY_LIMIT: u64 = 4 << 30;
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self { weld: Weld::default(), memory_limit: Self::DEFAULT_MEMORY_LIMIT, allow_outside: false }
    }
}

impl From<Weld> for LoadOptions {
    fn from(weld: Weld) -> Self {
        Self { weld, ..Self::default() }
    }
}

/// An animation of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct AnimationInfo {
    /// The name, if it has one.
    pub name: Option<String>,
    /// The time of the last key, in seconds. The animation starts at 0.
    pub duration_s: f32,
    /// The number of channels that move something.
    pub channels: usize,
    /// Why it cannot be played, if it is damaged. It then has no channels.
    pub fault: Option<GltfError>,
}

/// A skin of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SkinInfo {
    /// The name, if it has one.
    pub name: Option<String>,
    /// The number of joints. 0 if the JSON of the skin is damaged; damaged matrices do not change it.
    pub joints: usize,
}

/// A mesh of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshInfo {
    /// The name, if it has one.
    pub name: Option<String>,
    /// The number of primitives, including skipped ones. 0 if the JSON of the mesh is damaged.
    pub primitives: usize,
    /// The number of morph targets of each primitive.
    pub morph_targets: usize,
    /// Indices into [`Model::geometries`](crate::Model::geometries): one, or two (skinned and rigid) if nodes use the
    /// mesh both ways.
    pub geometries: Vec<usize>,
}

/// The number of primitives that were not loaded. Each counts once for its mesh, not for each instance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SkippedPrimitives {
    /// Point primitives.
    pub points: usize,
    /// Line, line loop and line strip primitives.
    pub lines: usize,
    /// Triangle primitives without a POSITION attribute.
    pub without_position: usize,
}

/// The kind of a light in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SceneLightKind {
    /// A light at infinity.
    Directional,
    /// A light at a point that shines to all sides.
    Point,
    /// A light at a point that shines in a cone.
    Spot,
}

/// A light of the file at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLight {
    /// The name of the light, or that of its node.
    pub name: Option<String>,
    /// The light in world space, relative to [`Asset::origin`](super::Asset::origin), without its range and cone: the fields
    /// below have them. A point or spot light has the node's position and w = 1. A directional light has the node's +Z at
    /// length 1 and w = 0: it shines along −Z, and [`Light`] points towards the light.
    pub light: Light,
    /// The kind of the light.
    pub kind: SceneLightKind,
    /// Red, green and blue, linear.
    pub color: [f32; 3],
    /// In candela for a point or spot light, in lux for a directional one.
    pub intensity: f32,
    /// The distance where a point or spot light ends, in the unit of the file. Nodes do not scale it. `None`: it does
    /// not end.
    pub range: Option<f32>,
    /// The cone of a spot light. `None` for other lights, and for a node without extent along Z.
    pub cone: Option<SpotCone>,
}

/// The cone of a spot light. It shines fully within the inner angle and not at all beyond the outer one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotCone {
    /// The direction in which it shines, in world space, at length 1: the node's −Z.
    pub direction: [f32; 3],
    /// The angle from the direction to where the light begins to fade, in radians.
    pub inner_angle: f32,
    /// The angle from the direction to where the light has faded, in radians. It is at least the inner angle.
    pub outer_angle: f32,
}
