//! Why a glTF file or a pose of it is refused.

use std::path::PathBuf;

/// Why a glTF file is refused. Places are JSON paths into the file, such as `meshes[0].primitives[2].attributes`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GltfError {
    /// The file, or one that it names, cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The binary container is damaged.
    #[error("GLB, byte {offset}: {problem}; the file is cut short or damaged, export it again")]
    Glb {
        /// Where, from the start of the file.
        offset: usize,
        /// What is wrong there.
        problem: String,
    },
    /// The text is no JSON.
    #[error("the glTF JSON cannot be parsed: {0}")]
    Json(#[source] gltf::json::Error),
    /// A property has the wrong type or an impossible value.
    #[error("{place}: expected {expected}, found {found}")]
    Property {
        /// JSON path of the property.
        place: String,
        /// What should stand there.
        expected: &'static str,
        /// What does.
        found: String,
    },
    /// A property that must be there is not.
    #[error("{place} is missing")]
    Missing {
        /// JSON path of the property.
        place: String,
    },
    /// An index names something that the file does not have.
    #[error("{place} is {index}, but the file has {count} {kind}")]
    Reference {
        /// JSON path of the index.
        place: String,
        /// The array it should point into.
        kind: &'static str,
        /// The index.
        index: u64,
        /// The array's length.
        count: usize,
    },
    /// The file is of another glTF version than 2.
    #[error("glTF version {version} is not supported, only 2.0 is; convert the file")]
    Version {
        /// As written in the file.
        version: String,
    },
    /// The file cannot be drawn right without an extension that is not supported.
    #[error("{place} needs the extension {name}, which is not supported; {advice}")]
    Extension {
        /// The extension.
        name: String,
        /// Where it is needed.
        place: String,
        /// A way out.
        advice: &'static str,
    },
    /// What the file holds makes no model.
    #[error("{place}: {source}")]
    Model {
        /// JSON path of the mesh, or `nodes` for all instances together.
        place: String,
        /// What is wrong with it.
        source: crate::model::ModelError,
    },
    /// A URI that is not read.
    #[error("{place}: {uri:?} {problem}")]
    Uri {
        /// JSON path of the URI.
        place: String,
        /// Its first characters.
        uri: String,
        /// Why it is not read, and what to do.
        problem: &'static str,
    },
    /// A buffer or a view into it reaches past the bytes that are there.
    #[error("{place} needs {needed} bytes, but only {available} are there")]
    TooShort {
        /// JSON path of the buffer or buffer view.
        place: String,
        /// Bytes it claims.
        needed: u64,
        /// Bytes it can have.
        available: u64,
    },
    /// An accessor cannot be read the way that it is used.
    #[error("accessors[{accessor}], used as {user}: {problem}")]
    Accessor {
        /// Index of the accessor.
        accessor: usize,
        /// JSON path of what refers to it.
        user: String,
        /// What is wrong.
        problem: AccessorProblem,
    },
    /// Loading would take more memory than the caller allows; a guard against small files that fill the memory.
    #[error(
        "{what}: loading needs at least {needed} bytes of memory, more than the limit of {limit}; raise the limit if \
         the file is meant to be that large, else split it"
    )]
    TooLarge {
        /// What would have been made next: a file, or a JSON path.
        what: String,
        /// Bytes that loading would have taken with it.
        needed: u64,
        /// [`LoadOptions::memory_limit`](super::LoadOptions::memory_limit).
        limit: u64,
    },
    /// More vertices, or joints of vertices, than 32-bit indices can name.
    #[error("{place}: its mesh has more vertices or joints than 32-bit indices can name; split it")]
    TooManyVertices {
        /// JSON path of the primitive that goes over.
        place: String,
    },
    /// A file name that leads outside the glTF's folder.
    #[error(
        "{place}: {uri:?} leads to {}, which is outside the glTF's folder and is not read; put the file there, or \
         allow files outside if the glTF is trusted", path.display()
    )]
    Outside {
        /// JSON path of the URI.
        place: String,
        /// Its first characters.
        uri: String,
        /// Where it leads.
        path: PathBuf,
    },
    /// An attribute, morph target or instance attribute has another number of elements than its fellows.
    #[error("{place} has {count} elements, expected {expected}")]
    Count {
        /// JSON path.
        place: String,
        /// Elements it has.
        count: usize,
        /// Elements it must have.
        expected: usize,
    },
    /// Triangles that are not three corners each.
    #[error("meshes[{mesh}].primitives[{primitive}]: {corners} corners are no whole number of triangles")]
    CornerCount {
        /// Index of the mesh.
        mesh: usize,
        /// Index of the primitive in it.
        primitive: usize,
        /// Indices, or vertices where there are none.
        corners: usize,
    },
    /// An index past the vertices.
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
        /// The first triangle of the primitive that it belongs to.
        face: usize,
        /// Its corner there.
        corner: usize,
        /// The index.
        index: u32,
        /// Vertices of the primitive.
        vertices: usize,
    },
    /// An index that means "start a new strip", which glTF forbids.
    #[error("meshes[{mesh}].primitives[{primitive}]: index {position} is the primitive restart value {index}")]
    PrimitiveRestart {
        /// Index of the mesh.
        mesh: usize,
        /// Index of the primitive in it.
        primitive: usize,
        /// Position in the index accessor.
        position: usize,
        /// The largest value of its type.
        index: u32,
    },
    /// A position or position offset is infinite or not a number.
    #[error("{place}, vertex {vertex} is ({}, {}, {}), and every position must be finite", .value[0], .value[1], .value[2])]
    NonFinitePosition {
        /// JSON path of the attribute.
        place: String,
        /// Index of the vertex in it.
        vertex: usize,
        /// The position or offset.
        value: [f32; 3],
    },
    /// A skin weight is negative, infinite or not a number.
    #[error("{place}, vertex {vertex}: weight {weight} is not a finite number of 0 or more")]
    Weight {
        /// JSON path of the attribute.
        place: String,
        /// Index of the vertex in it.
        vertex: usize,
        /// The weight.
        weight: f32,
    },
    /// A vertex names a joint that the skin does not have.
    #[error("{place}, vertex {vertex} names joint {joint}, but skins[{skin}] of nodes[{node}] has {joints} joints")]
    JointOutOfRange {
        /// JSON path of the attribute.
        place: String,
        /// Index of the vertex in it.
        vertex: usize,
        /// The joint.
        joint: u32,
        /// The node that uses mesh and skin together.
        node: usize,
        /// The skin.
        skin: usize,
        /// Its joints.
        joints: usize,
    },
    /// A skinned node's mesh has a primitive without joints, which glTF forbids.
    #[error("nodes[{node}] has a skin, but meshes[{mesh}].primitives[{primitive}] has no JOINTS_0 and WEIGHTS_0")]
    NotSkinned {
        /// The node.
        node: usize,
        /// Its mesh.
        mesh: usize,
        /// The primitive.
        primitive: usize,
    },
    /// A skinned mesh is also instanced, which neither specification defines.
    #[error("nodes[{node}] has both a skin and EXT_mesh_gpu_instancing; remove one")]
    InstancedSkin {
        /// The node.
        node: usize,
    },
    /// A matrix or rotation is no transform of space.
    #[error("{place}: {problem}")]
    Transform {
        /// JSON path.
        place: String,
        /// What is wrong.
        problem: &'static str,
    },
    /// A node is its own ancestor.
    #[error("nodes[{node}] is its own ancestor; nodes must form trees")]
    NodeCycle {
        /// A node on the cycle or below it.
        node: usize,
    },
    /// Two nodes list the same child, or one lists it twice.
    #[error("nodes[{node}] is a child of nodes[{first}] and again of nodes[{second}]; nodes must form trees")]
    TwoParents {
        /// The child.
        node: usize,
        /// The lower parent.
        first: usize,
        /// The other, or the same again.
        second: usize,
    },
    /// An animation's keyframes make no curve.
    #[error("{place}: {problem}")]
    Keyframes {
        /// JSON path of the sampler.
        place: String,
        /// What is wrong.
        problem: String,
    },
    /// An animation moves a node that has a fixed matrix, which glTF forbids.
    #[error("{place} moves nodes[{node}], which has a matrix; give it translation, rotation and scale instead")]
    AnimatedMatrix {
        /// JSON path of the channel.
        place: String,
        /// The node.
        node: usize,
    },
}

/// Why an accessor cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AccessorProblem {
    /// Type or component type do not fit the use.
    #[error("it holds {found}, expected {expected}")]
    Format {
        /// What it holds.
        found: String,
        /// What fits.
        expected: &'static str,
    },
    /// It reaches past its buffer view.
    #[error("it needs {needed} bytes of bufferViews[{view}], which has {available}")]
    TooShort {
        /// Index of the buffer view.
        view: usize,
        /// Bytes from the view's start to the accessor's end.
        needed: u64,
        /// The view's bytes.
        available: u64,
    },
    /// Elements would overlap.
    #[error("the byteStride {stride} of bufferViews[{view}] is smaller than an element's {size} bytes")]
    Stride {
        /// Index of the buffer view.
        view: usize,
        /// Its stride.
        stride: u64,
        /// Bytes of an element.
        size: u64,
    },
    /// Its buffer has neither URI nor binary chunk.
    #[error("buffers[{buffer}] has no data")]
    NoData {
        /// Index of the buffer.
        buffer: usize,
    },
    /// More replaced elements than elements.
    #[error("it replaces {count} elements of {elements}")]
    SparseCount {
        /// Elements replaced.
        count: u64,
        /// Elements there are.
        elements: u64,
    },
    /// Sparse indices must increase and stay below the element count.
    #[error("sparse index {position} is {index}; they must increase and stay below {elements}")]
    SparseIndex {
        /// Position among the sparse indices.
        position: usize,
        /// The index.
        index: u32,
        /// Elements there are.
        elements: u64,
    },
}

/// Why a model has no pose at some time.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseError {
    /// No such animation.
    #[error("animation {index} was asked for, but the file has {count}")]
    NoAnimation {
        /// The index asked for.
        index: usize,
        /// Animations in the file.
        count: usize,
    },
    /// The time is not a number.
    #[error("the time is not a number; give seconds")]
    Time,
    /// A matrix or morph weight overflows or is not a number.
    #[error("{place} has no finite transform or morph weights at {time_s} s")]
    NotFinite {
        /// JSON path of the node that places the instance or light.
        place: String,
        /// The time asked for.
        time_s: f32,
    },
}
