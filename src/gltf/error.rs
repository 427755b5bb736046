//! Why a glTF file or a pose of it is refused.

use std::path::PathBuf;
use std::sync::Arc;

/// Why a glTF file, or a part of it, is refused. Places are JSON paths into the file, such as
/// `meshes[0].primitives[2].attributes`. Two errors are equal if they say the same.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GltfError {
    /// The file, or a file that it names, cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        source: Arc<std::io::Error>,
    },
    /// The binary container is damaged.
    #[error("GLB, byte {offset}: {problem}; the file is cut short or damaged, export it again")]
    Glb {
        /// The place, in bytes from the start of the file.
        offset: usize,
        /// The fault at this offset.
        problem: String,
    },
    /// The text is not JSON.
    #[error("the glTF JSON cannot be parsed: {0}")]
    Json(#[source] Arc<gltf::json::Error>),
    /// A property has the wrong type or an impossible value.
    #[error("{place}: expected {expected}, found {found}")]
    Property {
        /// JSON path of the property.
        place: String,
        /// The value that should be there.
        expected: &'static str,
        /// The value that is there.
        found: String,
    },
    /// A required property is missing.
    #[error("{place} is missing")]
    Missing {
        /// JSON path of the property.
        place: String,
    },
    /// An index names an element that the file does not have.
    #[error("{place} is {index}, but the file has {count} {kind}")]
    Reference {
        /// JSON path of the index.
        place: String,
        /// The array that it points into.
        kind: &'static str,
        /// The index.
        index: u64,
        /// The array's length.
        count: usize,
    },
    /// The file has another glTF version than 2.
    #[error("glTF version {version} is not supported, only 2.0 is; convert the file")]
    Version {
        /// The version as written in the file.
        version: String,
    },
    /// The file needs an extension that is not supported.
    #[error("{place} needs the extension {name}, which is not supported; {advice}")]
    Extension {
        /// The extension.
        name: String,
        /// Where the file needs it.
        place: String,
        /// Advice to the user.
        advice: &'static str,
    },
    /// The content of the file does not make a model.
    #[error("{place}: {source}")]
    Model {
        /// JSON path of the mesh, or `nodes` for all instances together.
        place: String,
        /// Why it does not.
        source: crate::model::ModelError,
    },
    /// A URI that the loader does not read.
    #[error("{place}: {uri:?} {problem}")]
    Uri {
        /// JSON path of the URI.
        place: String,
        /// Its first characters.
        uri: String,
        /// Why it is not read, and what to do.
        problem: &'static str,
    },
    /// A buffer, or a view into it, is longer than its data.
    #[error("{place} needs {needed} bytes, but only {available} are there")]
    TooShort {
        /// JSON path of the buffer or buffer view.
        place: String,
        /// Bytes that it claims.
        needed: u64,
        /// Bytes that it can have.
        available: u64,
    },
    /// An accessor cannot be read in the way that the file uses it.
    #[error("accessors[{accessor}], used as {user}: {problem}")]
    Accessor {
        /// Index of the accessor.
        accessor: usize,
        /// JSON path of the property that refers to it.
        user: String,
        /// The fault of the accessor.
        problem: AccessorProblem,
    },
    /// Loading would take more memory than the caller allows. This guards against small files that fill the memory.
    #[error(
        "{what}: loading needs at least {needed} bytes of memory, more than the limit of {limit}; raise the limit if \
         the file is meant to be that large, else split it"
    )]
    TooLarge {
        /// The next allocation: a file, or a JSON path.
        what: String,
        /// Bytes that would be in use at one time, including this allocation.
        needed: u64,
        /// [`LoadOptions::memory_limit`](super::LoadOptions::memory_limit).
        limit: u64,
    },
    /// There are more vertices, or joints of vertices, than 32-bit indices can name.
    #[error("{place}: its mesh has more vertices or joints than 32-bit indices can name; split it")]
    TooManyVertices {
        /// JSON path of the primitive that exceeds the limit.
        place: String,
    },
    /// A file name leads outside the folder of the glTF.
    #[error(
        "{place}: {uri:?} leads to {}, which is outside the glTF's folder and is not read; put the file there, or \
         allow files outside if the glTF is trusted", path.display()
    )]
    Outside {
        /// JSON path of the URI.
        place: String,
        /// Its first characters.
        uri: String,
        /// The path that it leads to.
        path: PathBuf,
    },
    /// An attribute, morph target or instance attribute has another number of elements than the others.
    #[error("{place} has {count} elements, expected {expected}")]
    Count {
        /// JSON path of the attribute.
        place: String,
        /// Elements that it has.
        count: usize,
        /// Elements that it must have.
        expected: usize,
    },
    /// An index is past the last vertex.
    #[error(
        "meshes[{mesh}].primitives[{primitive}]: index {position} (face {face}, corner {corner}) is {index}, but \
         there are {vertices} vertices"
    )]
    IndexOutOfRange {
        /// Index of the mesh.
        mesh: usize,
        /// Index of the primitive in it.
        primitive: usize,
        /// Position in the index accessor.
        position: usize,
        /// The first triangle of the primitive that reads it.
        face: usize,
        /// The corner of this triangle: 0, 1 or 2.
        corner: usize,
        /// The index.
        index: u32,
        /// Vertices of the primitive.
        vertices: usize,
    },
    /// A skin weight is negative, infinite or NaN.
    #[error("{place}, vertex {vertex}: weight {weight} is not a finite number of 0 or more")]
    Weight {
        /// JSON path of the attribute.
        place: String,
        /// Index of the vertex in the attribute.
        vertex: usize,
        /// The weight.
        weight: f32,
    },
    /// A vertex names a joint that the skin does not have.
    #[error("{place}, vertex {vertex} names joint {joint}, but skins[{skin}] of nodes[{node}] has {joints} joints")]
    JointOutOfRange {
        /// JSON path of the attribute.
        place: String,
        /// Index of the vertex in the attribute.
        vertex: usize,
        /// The joint.
        joint: u32,
        /// The node that uses mesh and skin together.
        node: usize,
        /// Index of the skin.
        skin: usize,
        /// Joints of the skin.
        joints: usize,
    },
    /// The mesh of a skinned node has a primitive without joints, which glTF forbids.
    #[error("nodes[{node}] has a skin, but meshes[{mesh}].primitives[{primitive}] has no JOINTS_0 and WEIGHTS_0")]
    NotSkinned {
        /// Index of the node.
        node: usize,
        /// Index of its mesh.
        mesh: usize,
        /// Index of the primitive in the mesh.
        primitive: usize,
    },
    /// A skinned mesh is also instanced, which neither specification defines.
    #[error("nodes[{node}] has both a skin and EXT_mesh_gpu_instancing; remove one")]
    InstancedSkin {
        /// Index of the node.
        node: usize,
    },
    /// A matrix or rotation does not define a transform.
    #[error("{place}: {problem}")]
    Transform {
        /// JSON path of the matrix or rotation.
        place: String,
        /// Why it does not.
        problem: &'static str,
    },
    /// A node is its own ancestor.
    #[error("nodes[{node}] is its own ancestor; nodes must form trees")]
    NodeCycle {
        /// Index of a node in the cycle or below it.
        node: usize,
    },
    /// The keyframes of an animation do not make a curve.
    #[error("{place}: {problem}")]
    Keyframes {
        /// JSON path of the sampler.
        place: String,
        /// The fault of the sampler.
        problem: String,
    },
    /// An animation moves a node with a fixed matrix, which glTF forbids.
    #[error("{place} moves nodes[{node}], which has a matrix; give it translation, rotation and scale instead")]
    AnimatedMatrix {
        /// JSON path of the channel.
        place: String,
        /// Index of the node.
        node: usize,
    },
    /// There is no such animation.
    #[error("animation {index} was asked for, but the file has {count}")]
    NoAnimation {
        /// The index that was asked for.
        index: usize,
        /// Animations in the file.
        count: usize,
    },
    /// The animation is damaged. The rest of the file can be used.
    #[error("animation {index} cannot be played: {source}")]
    DamagedAnimation {
        /// The index that was asked for.
        index: usize,
        /// The fault, and where it is.
        source: Box<GltfError>,
    },
    /// Two of the animations move the same property of a node, so they cannot play together.
    #[error("animations {first} and {second} both move the {property} of nodes[{node}]; leave one of them out")]
    SameProperty {
        /// Index of an animation.
        first: usize,
        /// Index of another animation, asked for later.
        second: usize,
        /// Index of the node.
        node: usize,
        /// `translation`, `rotation`, `scale` or `weights`.
        property: &'static str,
    },
    /// A light is damaged. The rest of the file can be used.
    #[error("the light of nodes[{node}] cannot be used: {source}")]
    DamagedLight {
        /// Index of the light's node.
        node: usize,
        /// The fault, and where it is.
        source: Box<GltfError>,
    },
    /// The time is NaN.
    #[error("the time is not a number; give seconds")]
    Time,
    /// A matrix or a morph weight is infinite or NaN.
    #[error("{place} has no finite transform or morph weights at {time_s} s")]
    NotFinite {
        /// JSON path of the node that places the instance or light.
        place: String,
        /// The time that was asked for.
        time_s: f32,
    },
}

impl PartialEq for GltfError {
    fn eq(&self, other: &Self) -> bool {
        self.to_string() == other.to_string()
    }
}

/// Why an accessor cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AccessorProblem {
    /// The type or component type does not fit the use.
    #[error("it holds {found}, expected {expected}")]
    Format {
        /// The format that it has.
        found: String,
        /// The format that fits.
        expected: &'static str,
    },
    /// It reaches past the end of its buffer view.
    #[error("it needs {needed} bytes of bufferViews[{view}], which has {available}")]
    TooShort {
        /// Index of the buffer view.
        view: usize,
        /// Bytes from the view's start to the accessor's end.
        needed: u64,
        /// Bytes of the view.
        available: u64,
    },
    /// The stride is smaller than an element, so elements would overlap.
    #[error("the byteStride {stride} of bufferViews[{view}] is smaller than an element's {size} bytes")]
    Stride {
        /// Index of the buffer view.
        view: usize,
        /// Stride of the view, in bytes.
        stride: u64,
        /// Bytes of an element.
        size: u64,
    },
    /// Its buffer has no data: neither a URI nor the binary chunk.
    #[error("buffers[{buffer}] has no data")]
    NoData {
        /// Index of the buffer.
        buffer: usize,
    },
    /// The file replaces more elements than there are.
    #[error("it replaces {count} elements of {elements}")]
    SparseCount {
        /// Elements that are replaced.
        count: u64,
        /// Elements of the accessor.
        elements: u64,
    },
    /// The sparse indices do not increase, or one is not below the number of elements.
    #[error("sparse index {position} is {index}; they must increase and stay below {elements}")]
    SparseIndex {
        /// Position among the sparse indices.
        position: usize,
        /// The index.
        index: u32,
        /// Elements of the accessor.
        elements: u64,
    },
}
