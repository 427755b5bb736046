//! Descriptions of a file's animations, skins, meshes and skipped primitives.

use gltf::json::mesh::Mode;

use super::document::Document;
use super::error::GltfError;

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
    /// The number of joints.
    pub joints: usize,
}

/// A mesh of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshInfo {
    /// The name, if it has one.
    pub name: Option<String>,
    /// The number of primitives, including skipped ones.
    pub primitives: usize,
    /// The number of morph targets of each primitive.
    pub morph_targets: usize,
    /// Indices into [`Model::geometries`](crate::Model::geometries): one, or two (skinned and rigid) if nodes use the mesh both
    /// ways.
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

impl SkippedPrimitives {
    pub(super) fn count(document: &Document) -> Self {
        let mut skipped = Self::default();
        for primitive in document.meshes.iter().flat_map(|mesh| &mesh.primitives) {
            match primitive.mode {
                Mode::Points => skipped.points += 1,
                Mode::Lines | Mode::LineLoop | Mode::LineStrip => skipped.lines += 1,
                _ if primitive.position.is_none() => skipped.without_position += 1,
                _ => {}
            }
        }
        skipped
    }
}
