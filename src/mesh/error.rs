//! Why a mesh is refused.

/// The largest number of faces of a mesh. An edge's index and its winding bit share one `u32` in the edge lists, and a
/// mesh has at most three edge records for each face.
pub const MAX_FACES: usize = (1 << 31) / 3;

/// Refuses a mesh without faces, and more faces or vertices than indices can name.
pub(super) fn check_counts(vertices: usize, faces: usize) -> Result<(), MeshError> {
    match (faces, vertices) {
        (0, _) => Err(MeshError::NoFaces),
        (faces, _) if faces > MAX_FACES => Err(MeshError::TooManyFaces { faces }),
        (_, vertices) if vertices >= u32::MAX as usize => Err(MeshError::TooManyVertices { vertices }),
        _ => Ok(()),
    }
}

/// Why a mesh or a weld distance is refused. Loop 0 of a polygon is the outer one.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what fields are")]
pub enum MeshError {
    /// There are no faces, so there is no silhouette.
    #[error("the mesh has no faces; a silhouette needs triangles")]
    NoFaces,
    /// There are more faces than [`MAX_FACES`].
    #[error("the mesh has {faces} faces, more than the {MAX_FACES} that edge indices can count; split it")]
    TooManyFaces { faces: usize },
    /// There are more vertices than `u32` indices can name.
    #[error("the mesh has {vertices} vertices, more than u32 indices can name; split it")]
    TooManyVertices { vertices: usize },
    /// The polygons have more corners than edge indices can count.
    #[error("the polygons have {corners} corners, more than the {} that edge indices can count; split the mesh", 3 * MAX_FACES)]
    TooManyCorners { corners: usize },
    /// A polygon has more corners than [`MAX_POLYGON_CORNERS`](crate::mesh::MAX_POLYGON_CORNERS).
    #[error("polygon {polygon} has more than {} corners; cut it into several", crate::mesh::MAX_POLYGON_CORNERS)]
    PolygonTooLarge { polygon: usize },
    /// A polygon has no loop.
    #[error("polygon {polygon} has no loops; a polygon needs an outer loop, so leave it out")]
    PolygonWithoutLoops { polygon: usize },
    /// There are fewer loops than the polygons have.
    #[error("loop {loop_index} of polygon {polygon} has no size: only {loops} loop sizes are given")]
    MissingLoops { polygon: usize, loop_index: usize, loops: usize },
    /// There are fewer corners than the loops have.
    #[error("loop {loop_index} of polygon {polygon} ends after the last of the {corners} corners that are given")]
    MissingCorners { polygon: usize, loop_index: usize, corners: usize },
    /// There are more loops than the polygons have.
    #[error(
        "{loops} loops are left over after the last polygon; the numbers of loops must add up to the loop sizes given"
    )]
    LoopsLeftOver { loops: usize },
    /// There are more corners than the loops have.
    #[error("{corners} corners are left over after the last loop; the loop sizes must add up to the corners given")]
    CornersLeftOver { corners: usize },
    /// A loop has fewer than three corners.
    #[error("loop {loop_index} of polygon {polygon} has {corners} corners; a loop needs at least 3")]
    LoopTooSmall { polygon: usize, loop_index: usize, corners: usize },
    /// A corner of a polygon names a vertex that does not exist.
    #[error(
        "corner {corner} of loop {loop_index} of polygon {polygon} names vertex {index}, but there are {vertices} vertices"
    )]
    CornerOutOfRange { polygon: usize, loop_index: usize, corner: usize, index: u32, vertices: usize },
    /// A face names a vertex that does not exist.
    #[error("face {face} names vertex {index} at corner {corner}, but there are {vertices} vertices")]
    IndexOutOfRange { face: usize, corner: usize, index: u32, vertices: usize },
    /// A weld distance is negative, infinite or NaN.
    #[error("a weld distance is a finite number, 0 or more, and {distance} is not")]
    WeldDistance { distance: f32 },
}
