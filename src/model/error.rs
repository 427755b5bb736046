//! Why a model, a part of one, or a pose is refused.

use crate::mesh::MeshError;

/// Why a [`Geometry`](super::Geometry), [`Influences`](super::Influences), a [`Model`](super::Model) or an
/// [`InstancePose`](super::InstancePose) cannot be made of what was given.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// More vertices than `u32` indices can name.
    #[error("{vertices} vertices in all are more than u32 indices can name; split the model")]
    TooManyVertices {
        /// Vertices of the geometry, or of all instances together.
        vertices: usize,
    },
    /// A face names a vertex that is not there.
    #[error(
        "face {face} names vertex {index} at corner {corner}, but the geometry has {vertices} vertices; use indices below that"
    )]
    FaceIndex {
        /// The face's index.
        face: usize,
        /// 0, 1 or 2.
        corner: usize,
        /// The vertex it names.
        index: u32,
        /// Vertices there are.
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
        /// Vertices there are.
        vertices: usize,
    },
    /// The source vertices have another length than the positions.
    #[error(
        "{given} source vertices were given for {vertices} vertices; give one a vertex, or `None` to number them in order"
    )]
    SourceVertices {
        /// Source vertices given.
        given: usize,
        /// Vertices there are.
        vertices: usize,
    },
    /// Influences of another number of vertices than the geometry's.
    #[error(
        "the influences are those of {given} vertices, and the geometry has {vertices}; give one more offset than vertices"
    )]
    InfluencedVertices {
        /// Vertices that the influences tell of.
        given: usize,
        /// Vertices there are.
        vertices: usize,
    },
    /// Joints and weights do not pair up.
    #[error("the influences have {joints} joints and {weights} weights; give one weight a joint")]
    InfluenceWeights {
        /// Joints given.
        joints: usize,
        /// Weights given.
        weights: usize,
    },
    /// The offsets do not begin at 0, or there is none.
    #[error("the influences' offsets must begin with 0, but begin with {found:?}")]
    FirstOffset {
        /// The first offset; `None` where there is none at all.
        found: Option<u32>,
    },
    /// An offset is below the one before it.
    #[error("the influences of vertex {vertex} begin at {begin} and end at {end}; offsets must never fall")]
    FallingOffset {
        /// The vertex.
        vertex: usize,
        /// Its offset.
        begin: u32,
        /// The next vertex's.
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
    /// A joint's weight is infinite or no number.
    #[error("vertex {vertex} follows joint {joint} with weight {weight}; give a finite weight")]
    InfluenceWeight {
        /// The vertex.
        vertex: usize,
        /// The joint.
        joint: u32,
        /// Its weight.
        weight: f32,
    },
    /// An instance names a geometry that is not there.
    #[error("instance {instance} names geometry {geometry}, but the model has {geometries}; use an index below that")]
    InstanceGeometry {
        /// The instance's index.
        instance: usize,
        /// The geometry it names.
        geometry: usize,
        /// Geometries there are.
        geometries: usize,
    },
    /// A matrix of a pose has an infinite entry or one that is no number.
    #[error("matrix {joint} of the palette has {value} in row {row}, column {column}; give finite matrices")]
    Matrix {
        /// The matrix's index, which is the joint's.
        joint: usize,
        /// 0, 1 or 2.
        row: usize,
        /// 0 to 3.
        column: usize,
        /// What stands there.
        value: f32,
    },
    /// A morph weight of a pose is infinite or no number.
    #[error("the weight of morph target {target} is {weight}; give a finite weight")]
    MorphWeight {
        /// The target's index.
        target: usize,
        /// Its weight.
        weight: f32,
    },
}

/// Why a pose is not one of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PoseMismatch {
    /// Another number of instances.
    #[error("the pose has {given} instances, and the model has {needed}; pose each instance once")]
    Instances {
        /// Instances of the pose.
        given: usize,
        /// Instances of the model.
        needed: usize,
    },
    /// Too few matrices.
    #[error("the pose of instance {instance} has {given} matrices, and its geometry needs {needed}; give one a joint")]
    Palette {
        /// The instance's index.
        instance: usize,
        /// Matrices of the pose.
        given: usize,
        /// Matrices needed.
        needed: usize,
    },
    /// Another number of morph weights than targets.
    #[error(
        "the pose of instance {instance} has {given} morph weights, and its geometry has {needed} targets; give one a target"
    )]
    MorphWeights {
        /// The instance's index.
        instance: usize,
        /// Weights of the pose.
        given: usize,
        /// Targets of the geometry.
        needed: usize,
    },
}

/// Why a pose of a model makes no mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PosedMeshError {
    /// The pose is not one of the model.
    #[error(transparent)]
    Pose(#[from] PoseMismatch),
    /// All instances together are no mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}
