//! Why a model, a part of a model, or a pose is refused.

use crate::mesh::MeshError;

/// Why a [`Geometry`](super::Geometry), an [`Influences`](super::Influences), a [`Model`](super::Model) or an
/// [`InstancePose`](super::InstancePose) cannot be made from what was given, or a pose does not fit a model or
/// makes no mesh.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// There are more vertices than `u32` indices can name.
    #[error("{vertices} vertices in all are more than u32 indices can name; split the model")]
    TooManyVertices {
        /// Vertices of the geometry, or of all instances together.
        vertices: usize,
    },
    /// A face names a vertex that does not exist.
    #[error(
        "face {face} names vertex {index} at corner {corner}, but the geometry has {vertices} vertices; use indices below that"
    )]
    FaceIndex {
        /// The face's index.
        face: usize,
        /// 0, 1 or 2.
        corner: usize,
        /// The vertex that it names.
        index: u32,
        /// Vertices of the geometry.
        vertices: usize,
    },
    /// A morph target has another length than the positions.
    #[error(
        "morph target {target} has {given} offsets, and the geometry has {vertices} vertices; give one offset a vertex"
    )]
    MorphTarget {
        /// The target's index.
        target: usize,
        /// Offsets given.
        given: usize,
        /// Vertices of the geometry.
        vertices: usize,
    },
    /// The source vertices have another length than the positions.
    #[error(
        "{given} source vertices were given for {vertices} vertices; give one a vertex, or `None` to number them in order"
    )]
    SourceVertices {
        /// Source vertices given.
        given: usize,
        /// Vertices of the geometry.
        vertices: usize,
    },
    /// The influences are for another number of vertices than the geometry has.
    #[error(
        "the influences are those of {given} vertices, and the geometry has {vertices}; give one more offset than vertices"
    )]
    InfluencedVertices {
        /// Vertices that the influences are for.
        given: usize,
        /// Vertices of the geometry.
        vertices: usize,
    },
    /// There are not as many joints as weights.
    #[error("the influences have {joints} joints and {weights} weights; give one weight a joint")]
    InfluenceWeights {
        /// Joints given.
        joints: usize,
        /// Weights given.
        weights: usize,
    },
    /// The first offset is not 0, or there are no offsets.
    #[error("the influences' offsets must begin with 0, but begin with {found:?}")]
    FirstOffset {
        /// The first offset, or `None` if there are no offsets.
        found: Option<u32>,
    },
    /// An offset is smaller than the one before it.
    #[error("the influences of vertex {vertex} begin at {begin} and end at {end}; offsets must never fall")]
    FallingOffset {
        /// The vertex.
        vertex: usize,
        /// Its offset.
        begin: u32,
        /// The offset of the next vertex.
        end: u32,
    },
    /// The last offset is not the number of joints.
    #[error("the influences' last offset is {found}, and {joints} joints were given; the two must be equal")]
    LastOffset {
        /// The last offset.
        found: u32,
        /// Joints given.
        joints: usize,
    },
    /// The weight of a joint is infinite or NaN.
    #[error("vertex {vertex} follows joint {joint} with weight {weight}; give a finite weight")]
    InfluenceWeight {
        /// The vertex.
        vertex: usize,
        /// The joint.
        joint: u32,
        /// Its weight.
        weight: f32,
    },
    /// An instance names a geometry that does not exist.
    #[error("instance {instance} names geometry {geometry}, but the model has {geometries}; use an index below that")]
    InstanceGeometry {
        /// The instance's index.
        instance: usize,
        /// The geometry that it names.
        geometry: usize,
        /// Geometries of the model.
        geometries: usize,
    },
    /// A matrix of a pose has an infinite or NaN entry.
    #[error("matrix {joint} of the palette has {value} in row {row}, column {column}; give finite matrices")]
    Matrix {
        /// The index of the matrix, which is that of the joint.
        joint: usize,
        /// 0, 1 or 2.
        row: usize,
        /// 0 to 3.
        column: usize,
        /// The entry.
        value: f32,
    },
    /// A morph weight of a pose is infinite or NaN.
    #[error("the weight of morph target {target} is {weight}; give a finite weight")]
    MorphWeight {
        /// The target's index.
        target: usize,
        /// Its weight.
        weight: f32,
    },
    /// The pose has another number of instances.
    #[error("the pose has {given} instances, and the model has {needed}; pose each instance once")]
    PoseInstances {
        /// Instances of the pose.
        given: usize,
        /// Instances of the model.
        needed: usize,
    },
    /// The pose has too few matrices.
    #[error("the pose of instance {instance} has {given} matrices, and its geometry needs {needed}; give one a joint")]
    PosePalette {
        /// The instance's index.
        instance: usize,
        /// Matrices of the pose.
        given: usize,
        /// Matrices needed.
        needed: usize,
    },
    /// The number of morph weights is not the number of morph targets.
    #[error(
        "the pose of instance {instance} has {given} morph weights, and its geometry has {needed} targets; give one a target"
    )]
    PoseMorphWeights {
        /// The instance's index.
        instance: usize,
        /// Weights of the pose.
        given: usize,
        /// Targets of the geometry.
        needed: usize,
    },
    /// The mesh was made for a pose in which the instance mirrors and does not in this one, or the other way round.
    #[error(
        "the faces of instance {instance} are turned the other way in the mesh, because it mirrors in one of the poses only; \
         make the mesh again by `Model::mesh`"
    )]
    Turned {
        /// The instance's index.
        instance: usize,
    },
    /// The mesh is not one of the model.
    #[error("the mesh is not one that `Model::mesh` made of this model")]
    OtherMesh,
    /// All instances together do not make a mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}
