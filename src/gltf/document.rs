//! The parts of a glTF document that shape, place and move triangles, as plain structs with checked indices.
//!
//! `gltf::json::Root` is not used. It refuses legal files (a scene without nodes, an animation channel without a target
//! node), and its errors name a line where a user needs a mesh.

use glam::{DAffine3, DQuat, DVec3};
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::animation::{Interpolation, Property};
use gltf::json::mesh::Mode;

use super::error::GltfError;

/// A part of the file, or what it is refused for once somebody asks for it.
pub(super) type Part<T> = Result<T, Box<GltfError>>;

/// A document. Every index in it is in range of the list it points into. A part with a `fault` has no content beside its
/// name.
#[derive(Debug, Default)]
pub(super) struct Document {
    pub(super) buffers: Vec<Part<Buffer>>,
    pub(super) views: Vec<Part<View>>,
    pub(super) accessors: Vec<Part<Accessor>>,
    pub(super) meshes: Vec<Mesh>,
    pub(super) skins: Vec<Skin>,
    pub(super) nodes: Vec<Node>,
    /// The root nodes of each scene.
    pub(super) scenes: Vec<Part<Vec<usize>>>,
    pub(super) scene: Option<usize>,
    pub(super) animations: Vec<Animation>,
    pub(super) lights: Vec<NamedLight>,
    /// Whether positions may be of an integer type.
    pub(super) quantized: bool,
    /// The center of `CESIUM_RTC`, or zero: where the scene's own zero is in the world.
    pub(super) center: DVec3,
}

#[derive(Debug)]
pub(super) struct Buffer {
    pub(super) uri: Option<String>,
    pub(super) bytes: u64,
}

#[derive(Debug)]
pub(super) struct View {
    pub(super) buffer: usize,
    pub(super) offset: u64,
    pub(super) bytes: u64,
    pub(super) stride: Option<u64>,
    /// The name of the extension if the view has meshopt-compressed data, too.
    pub(super) compressed: Option<&'static str>,
}

#[derive(Debug)]
pub(super) struct Accessor {
    pub(super) view: Option<usize>,
    pub(super) offset: u64,
    pub(super) count: u64,
    pub(super) component: ComponentType,
    pub(super) kind: Type,
    pub(super) normalized: bool,
    pub(super) sparse: Option<Sparse>,
}

#[derive(Debug)]
pub(super) struct Sparse {
    pub(super) count: u64,
    pub(super) indices: (usize, u64, ComponentType),
    pub(super) values: (usize, u64),
}

#[derive(Debug, Default)]
pub(super) struct Mesh {
    pub(super) name: Option<String>,
    pub(super) primitives: Vec<Primitive>,
    pub(super) weights: Option<Vec<f64>>,
    /// The number of morph targets of each primitive.
    pub(super) targets: usize,
    pub(super) fault: Option<Box<GltfError>>,
}

#[derive(Debug)]
pub(super) struct Primitive {
    pub(super) mode: Mode,
    pub(super) indices: Option<usize>,
    pub(super) position: Option<usize>,
    /// The accessors of `JOINTS_n` and `WEIGHTS_n`, by n.
    pub(super) influences: Vec<InfluenceSet>,
    /// The fault of `JOINTS_n` and `WEIGHTS_n`, which only a skin needs.
    pub(super) influences_fault: Option<Box<GltfError>>,
    /// The accessor of each target's POSITION. `None`: the target moves nothing here.
    pub(super) targets: Vec<Option<usize>>,
    /// Whether it has Draco-compressed data, too.
    pub(super) draco: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct InfluenceSet {
    pub(super) set: u32,
    pub(super) joints: usize,
    pub(super) weights: usize,
}

#[derive(Debug, Default)]
pub(super) struct Skin {
    pub(super) name: Option<String>,
    pub(super) joints: Vec<usize>,
    pub(super) inverse_binds: Option<usize>,
    pub(super) fault: Option<Box<GltfError>>,
}

#[derive(Debug, Default)]
pub(super) struct Node {
    pub(super) name: Option<String>,
    pub(super) children: Vec<usize>,
    pub(super) transform: Transform,
    pub(super) mesh: Option<usize>,
    pub(super) skin: Option<usize>,
    pub(super) weights: Option<Vec<f64>>,
    pub(super) light: Option<Part<usize>>,
    pub(super) instancing: Option<Instancing>,
    /// Whether the node and what is below it are hidden (`KHR_node_visibility`).
    pub(super) is_hidden: bool,
    pub(super) fault: Option<Box<GltfError>>,
}

/// The accessors of the attributes of `EXT_mesh_gpu_instancing`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Instancing {
    pub(super) translation: Option<usize>,
    pub(super) rotation: Option<usize>,
    pub(super) scale: Option<usize>,
}

/// A node's transform relative to its parent.
#[derive(Clone, Copy, Debug)]
pub(super) enum Transform {
    Matrix(DAffine3),
    Trs(Trs),
}

impl Default for Transform {
    fn default() -> Self {
        Self::Trs(Trs::IDENTITY)
    }
}

/// Scale, then rotation, then translation. The rotation has length 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trs {
    pub(super) translation: DVec3,
    pub(super) rotation: DQuat,
    pub(super) scale: DVec3,
}

#[derive(Debug, Default)]
pub(super) struct Animation {
    pub(super) name: Option<String>,
    pub(super) samplers: Vec<Sampler>,
    /// The channels whose target glTF defines.
    pub(super) channels: Vec<ChannelTarget>,
    pub(super) fault: Option<Box<GltfError>>,
}

#[derive(Debug)]
pub(super) struct Sampler {
    pub(super) input: usize,
    pub(super) output: usize,
    pub(super) interpolation: Interpolation,
}

#[derive(Debug)]
pub(super) struct ChannelTarget {
    /// Its index in the file.
    pub(super) channel: usize,
    pub(super) sampler: usize,
    pub(super) node: usize,
    pub(super) property: Property,
}

#[derive(Debug)]
pub(super) struct NamedLight {
    pub(super) name: Option<String>,
    pub(super) light: Part<PunctualLight>,
}

#[derive(Debug)]
pub(super) struct PunctualLight {
    pub(super) kind: super::scene_light::SceneLightKind,
    pub(super) color: [f32; 3],
    pub(super) intensity: f32,
    pub(super) range: Option<f32>,
    /// The inner and outer angle of a spot light's cone.
    pub(super) cone: Option<[f32; 2]>,
}

impl Trs {
    pub(super) const IDENTITY: Self = Self { translation: DVec3::ZERO, rotation: DQuat::IDENTITY, scale: DVec3::ONE };

    pub(super) fn matrix(&self) -> DAffine3 {
        DAffine3::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

impl Transform {
    pub(super) fn matrix(&self) -> DAffine3 {
        match self {
            Self::Matrix(matrix) => *matrix,
            Self::Trs(trs) => trs.matrix(),
        }
    }
}
