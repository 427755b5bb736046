//! Why a model, a part of a model, or a pose is refused.

use crate::mesh::MeshError;

/// Why a [`Geometry`](super::Geometry), an [`Influences`](super::Influences), a [`Model`](super::Model) or an
/// [`InstancePose`](super::InstancePose) cannot be made from what was given, or a pose does not fit a model or
/// makes no mesh.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what fields are")]
pub enum ModelError {
    /// There are more vertices than `u32` indices can name.
    #[error("{vertices} vertices in all are more than u32 indices can name; split the model")]
    TooManyVertices { vertices: usize },
    /// A face names a vertex that does not exist.
    #[error(
        "face {face} names vertex {index} at corner {corner}, but the geometry has {vertices} vertices; use indices below that"
    )]
    FaceIndex { face: usize, corner: usize, index: u32, vertices: usize },
    /// A morph target has another length than the positions.
    #[error(
        "morph target {target} has {given} offsets, and the geometry has {vertices} vertices; give one offset a vertex"
    )]
    MorphTarget { target: usize, given: usize, vertices: usize },
    /// The source vertices have another length than the positions.
    #[error(
        "{given} source vertices were given for {vertices} vertices; give one a vertex, or `None` to number them in order"
    )]
    SourceVertices { given: usize, vertices: usize },
    /// The influences are for another number of vertices than the geometry has.
    #[error(
        "the influences are those of {given} vertices, and the geometry has {vertices}; give one more offset than vertices"
    )]
    InfluencedVertices { given: usize, vertices: usize },
    /// There are not as many joints as weights.
    #[error("the influences have {joints} joints and {weights} weights; give one weight a joint")]
    InfluenceWeights { joints: usize, weights: usize },
    /// The first offset is not 0, or there are no offsets.
    #[error("the influences' offsets must begin with 0, but begin with {found:?}")]
    FirstOffset { found: Option<u32> },
    /// An offset is smaller than the one before it.
    #[error("the influences of vertex {vertex} begin at {begin} and end at {end}; offsets must never fall")]
    FallingOffset { vertex: usize, begin: u32, end: u32 },
    /// The last offset is not the number of joints.
    #[error("the influences' last offset is {found}, and {joints} joints were given; the two must be equal")]
    LastOffset { found: u32, joints: usize },
    /// The weight of a joint is infinite or NaN.
    #[error("vertex {vertex} follows joint {joint} with weight {weight}; give a finite weight")]
    InfluenceWeight { vertex: usize, joint: u32, weight: f32 },
    /// An instance names a geometry that does not exist.
    #[error("instance {instance} names geometry {geometry}, but the model has {geometries}; use an index below that")]
    InstanceGeometry { instance: usize, geometry: usize, geometries: usize },
    /// A matrix of a pose has an infinite or NaN entry.
    #[error("matrix {joint} of the palette has {value} in row {row}, column {column}; give finite matrices")]
    Matrix { joint: usize, row: usize, column: usize, value: f32 },
    /// A morph weight of a pose is infinite or NaN.
    #[error("the weight of morph target {target} is {weight}; give a finite weight")]
    MorphWeight { target: usize, weight: f32 },
    /// The pose has another number of instances.
    #[error("the pose has {given} instances, and the model has {needed}; pose each instance once")]
    PoseInstances { given: usize, needed: usize },
    /// The pose has too few matrices.
    #[error("the pose of instance {instance} has {given} matrices, and its geometry needs {needed}; give one a joint")]
    PosePalette { instance: usize, given: usize, needed: usize },
    /// The number of morph weights is not the number of morph targets.
    #[error(
        "the pose of instance {instance} has {given} morph weights, and its geometry has {needed} targets; give one a target"
    )]
    PoseMorphWeights { instance: usize, given: usize, needed: usize },
    /// The mesh was made for a pose in which the instance mirrors and does not in this one, or the other way round.
    #[error(
        "the faces of instance {instance} are turned the other way in the mesh, because it mirrors in one of the poses only; \
         make the mesh again by `Model::mesh`"
    )]
    Turned { instance: usize },
    /// The mesh is not one of the model.
    #[error("the mesh is not one that `Model::mesh` made of this model")]
    OtherMesh,
    /// All instances together do not make a mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}
