//! The parts of a glTF document that shape, transform and move triangles, as plain structs with checked indices. Types of
//! the `gltf` crate refuse legal files, for example a scene without nodes, and their errors name a line and no mesh.

use glam::{DAffine3, DMat4, DQuat, DVec3};

use super::camera::CameraProjection;
use super::error::GltfError;
use super::info::SceneLightKind;

/// A part of the file, or its fault, which is an error of a user of the part.
pub(super) type Part<T> = Result<T, Box<GltfError>>;

/// A document. Every index in it is in range of the list it points into.
#[derive(Debug, Default)]
pub(super) struct Document {
    pub(super) buffers: Vec<Part<Buffer>>,
    pub(super) views: Vec<Part<View>>,
    pub(super) accessors: Vec<Part<Accessor>>,
    pub(super) meshes: Vec<Named<Mesh>>,
    pub(super) skins: Vec<Named<Skin>>,
    pub(super) nodes: Vec<Node>,
    /// The root nodes of each scene.
    pub(super) scenes: Vec<Part<Vec<usize>>>,
    pub(super) scene: Option<usize>,
    pub(super) animations: Vec<Named<Animation>>,
    pub(super) lights: Vec<Named<PunctualLight>>,
    pub(super) cameras: Vec<Named<CameraProjection>>,
    /// The base colour factor of each material, without alpha.
    pub(super) materials: Vec<Named<[f32; 3]>>,
    /// Whether positions may be of an integer type.
    pub(super) quantized: bool,
    /// The center of `CESIUM_RTC`, or zero: the scene's zero in the world.
    pub(super) center: DVec3,
}

/// A part with a name.
#[derive(Debug)]
pub(super) struct Named<T> {
    pub(super) name: Option<String>,
    pub(super) part: Part<T>,
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

#[derive(Clone, Copy, Debug)]
pub(super) struct Accessor {
    pub(super) view: Option<usize>,
    pub(super) offset: u64,
    pub(super) count: u64,
    pub(super) component: Component,
    pub(super) kind: Kind,
    pub(super) normalized: bool,
    pub(super) sparse: Option<Sparse>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Sparse {
    pub(super) count: u64,
    pub(super) indices: ArrayStart,
    /// The type of the indices.
    pub(super) component: Component,
    pub(super) values: ArrayStart,
}

/// Where an array begins: in which view, and how many bytes after its begin.
#[derive(Clone, Copy, Debug)]
pub(super) struct ArrayStart {
    pub(super) view: usize,
    pub(super) offset: u64,
}

/// The type of a number in a buffer, as the file numbers it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8 = 5120,
    U8 = 5121,
    I16 = 5122,
    U16 = 5123,
    U32 = 5125,
    F32 = 5126,
}

/// The type of an accessor's elements: its name in the file, the one in messages, and the number of components.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Kind(pub(super) &'static str, pub(super) &'static str, pub(super) usize);

pub(super) const SCALAR: Kind = Kind("SCALAR", "Scalar", 1);
pub(super) const VEC3: Kind = Kind("VEC3", "Vec3", 3);
pub(super) const VEC4: Kind = Kind("VEC4", "Vec4", 4);
pub(super) const MAT4: Kind = Kind("MAT4", "Mat4", 16);
pub(super) const KINDS: [Kind; 7] =
    [SCALAR, Kind("VEC2", "Vec2", 2), VEC3, VEC4, Kind("MAT2", "Mat2", 4), Kind("MAT3", "Mat3", 9), MAT4];

#[derive(Debug, Default)]
pub(super) struct Mesh {
    pub(super) primitives: Vec<Primitive>,
    pub(super) weights: Option<Vec<f64>>,
    /// The number of morph targets of each primitive.
    pub(super) targets: usize,
}

#[derive(Debug)]
pub(super) struct Primitive {
    pub(super) mode: Mode,
    pub(super) indices: Option<usize>,
    pub(super) position: Option<usize>,
    /// The accessors of `JOINTS_n` and `WEIGHTS_n`, by n. Only a skin needs them.
    pub(super) influences: Part<Vec<InfluenceSet>>,
    /// The accessor of each target's POSITION. `None`: the target moves nothing here.
    pub(super) targets: Vec<Option<usize>>,
    pub(super) material: Part<Option<usize>>,
    /// The accessor of `COLOR_0`.
    pub(super) color: Part<Option<usize>>,
    /// Whether it has Draco-compressed data, too.
    pub(super) draco: bool,
}

/// The shapes that the vertices of a primitive make.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    Points,
    /// Separate lines, strips and loops.
    Lines,
    Triangles,
    Strip,
    Fan,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct InfluenceSet {
    pub(super) set: u32,
    pub(super) joints: usize,
    pub(super) weights: usize,
}

#[derive(Debug, Default)]
pub(super) struct Skin {
    pub(super) joints: Vec<usize>,
    pub(super) inverse_binds: Option<usize>,
}

/// A node. One with a fault has no content beside its name, its light and its camera.
#[derive(Debug, Default)]
pub(super) struct Node {
    pub(super) name: Option<String>,
    pub(super) children: Vec<usize>,
    pub(super) trs: Trs,
    /// The matrix that replaces translation, rotation and scale.
    pub(super) matrix: Option<DAffine3>,
    pub(super) mesh: Option<usize>,
    pub(super) skin: Option<usize>,
    pub(super) weights: Option<Vec<f64>>,
    pub(super) light: Option<Part<usize>>,
    pub(super) camera: Option<Part<usize>>,
    /// The accessors of [`INSTANCED`].
    pub(super) instancing: Option<[Option<usize>; 3]>,
    /// Whether the node and what is below it are hidden (`KHR_node_visibility`).
    pub(super) is_hidden: bool,
    pub(super) fault: Option<Box<GltfError>>,
}

/// The attributes of `EXT_mesh_gpu_instancing`.
pub(super) const INSTANCED: [&str; 3] = ["TRANSLATION", "ROTATION", "SCALE"];

/// A transform: scale, then rotation, then translation. The rotation has length 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trs {
    pub(super) translation: DVec3,
    pub(super) rotation: DQuat,
    pub(super) scale: DVec3,
}

#[derive(Debug, Default)]
pub(super) struct Animation {
    pub(super) samplers: Vec<Sampler>,
    /// The channels whose target glTF defines.
    pub(super) channels: Vec<ChannelTarget>,
}

#[derive(Debug)]
pub(super) struct Sampler {
    pub(super) input: usize,
    pub(super) output: usize,
    pub(super) interpolation: Interpolation,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Interpolation {
    Linear,
    Step,
    CubicSpline,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct ChannelTarget {
    /// Its index in the animation's list in the file, which has channels that are not here.
    pub(super) channel: usize,
    pub(super) sampler: usize,
    pub(super) node: usize,
    pub(super) property: Property,
}

/// A property that an animation moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Property {
    Translation,
    Rotation,
    Scale,
    Weights,
}

#[derive(Debug)]
pub(super) struct PunctualLight {
    pub(super) kind: SceneLightKind,
    pub(super) color: [f32; 3],
    pub(super) intensity: f32,
    pub(super) range: Option<f32>,
    /// The inner and outer angle of a spot light's cone.
    pub(super) cone: Option<[f32; 2]>,
}

/// The transform of an instance.
#[derive(Clone, Copy, Debug)]
pub(super) enum Frame {
    /// The node's world matrix times this matrix.
    Node(DAffine3),
    /// The joints of a skin. The node's matrix has no effect.
    Skin(usize),
}

/// The origin of an instance of the model.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    pub(super) mesh: usize,
    /// The node. `None`: a mesh that no node names, in a file without scenes.
    pub(super) node: Option<usize>,
    pub(super) frame: Frame,
}

/// The part, or a copy of its fault.
pub(super) fn checked<T>(part: &Part<T>) -> Result<&T, GltfError> {
    part.as_ref().map_err(|fault| GltfError::clone(fault))
}

impl Document {
    /// The number of morph targets of a mesh.
    pub(super) fn targets(&self, mesh: usize) -> usize {
        self.meshes[mesh].part.as_ref().map_or(0, |mesh| mesh.targets)
    }
}

impl View {
    /// The distance between elements of `size` bytes, and the bytes from the first of `count` of them to the end of the
    /// last.
    pub(super) fn extent(&self, count: u64, size: u64) -> [u64; 2] {
        let stride = self.stride.unwrap_or(size);
        let steps = count.saturating_sub(1).saturating_mul(stride);
        [stride, if count == 0 { 0 } else { steps.saturating_add(size) }]
    }
}

impl Accessor {
    /// Bytes of an element.
    pub(super) fn element(&self) -> usize {
        self.kind.2 * self.component.size()
    }
}

impl Component {
    pub(super) const ALL: [Self; 6] = [Self::I8, Self::U8, Self::I16, Self::U16, Self::U32, Self::F32];

    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

impl Mode {
    /// Whether it makes triangles. Points and lines do not.
    pub(super) fn has_triangles(self) -> bool {
        !matches!(self, Self::Points | Self::Lines)
    }
}

impl Property {
    pub(super) const ALL: [Self; 4] = [Self::Translation, Self::Rotation, Self::Scale, Self::Weights];

    /// The name of a property, as a channel's path has it.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Translation => "translation",
            Self::Rotation => "rotation",
            Self::Scale => "scale",
            Self::Weights => "weights",
        }
    }
}

impl Default for Trs {
    fn default() -> Self {
        Self { translation: DVec3::ZERO, rotation: DQuat::IDENTITY, scale: DVec3::ONE }
    }
}

impl Trs {
    pub(super) fn matrix(&self) -> DAffine3 {
        DAffine3::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

/// A quaternion scaled to length 1, or `None` if its length is zero or not finite.
pub(super) fn unit(rotation: [f64; 4]) -> Option<DQuat> {
    let largest = rotation.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
    let scaled = DQuat::from_array(rotation.map(|c| c / largest));
    let normalized = scaled / scaled.length();
    normalized.is_finite().then_some(normalized)
}

/// A vector scaled to length 1. It is not finite if its length is zero or not finite.
pub(super) fn unit_vector(vector: DVec3) -> DVec3 {
    // Squares of a component may be more or less than a number holds.
    (vector / vector.abs().max_element()).normalize()
}

/// A column-major matrix. Its last row must be (0, 0, 0, 1), except for rounding on export.
pub(super) fn affine(columns: [f64; 16], json_path: impl Fn() -> String) -> Result<DAffine3, GltfError> {
    const TOLERANCE: f64 = 1e-5;
    let matrix = DMat4::from_cols_array(&columns);
    let row = matrix.row(3).to_array();
    let problem = if !matrix.is_finite() {
        ": the matrix is not finite"
    } else if row.iter().zip([0.0, 0.0, 0.0, 1.0]).any(|(a, b)| (a - b).abs() > TOLERANCE) {
        ": the matrix's last row must be (0, 0, 0, 1)"
    } else {
        return Ok(DAffine3::from_mat4(matrix));
    };
    Err(GltfError::invalid(json_path(), problem))
}
