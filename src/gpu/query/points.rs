//! The points of a query of occluder counts, and the faces that they are on.

use super::errors::QueryError;
use crate::gpu::common::positions::PositionBuffer;

/// Points of a [`ShadowQuery`](crate::gpu::ShadowQuery). A [`PositionBuffer`] becomes points that name no face.
#[derive(Clone, Copy, Debug)]
pub struct QueryPoints<'a> {
    /// Where the points are.
    pub points: PositionBuffer<'a>,
    /// Bytes from the x of a point to the index of the face that it is on, a `u32` in the same buffer: a multiple of 4
    /// from 12 on, before the next point. Default: `None`, points name no face. This face, in
    /// [`Mesh::faces`](crate::Mesh::faces) a triangle where the mesh has polygons, does not count for its point, as if
    /// the point were exactly in it. [`NO_FACE`](crate::mesh::NO_FACE) is none, and so is an index that the mesh lacks,
    /// which [`crate::cpu::shadow_depth_on_faces`] refuses.
    pub on_face: Option<u64>,
}

impl<'a> From<PositionBuffer<'a>> for QueryPoints<'a> {
    fn from(points: PositionBuffer<'a>) -> Self {
        Self { points, on_face: None }
    }
}

impl QueryPoints<'_> {
    /// Checks that the buffer has `count` points with their faces.
    pub(super) fn check(&self, count: u32) -> Result<(), QueryError> {
        let Self { points, on_face } = *self;
        points.end(count).map_err(QueryError::Points)?;
        let Some(offset) = on_face else { return Ok(()) };
        if !offset.is_multiple_of(4) || offset < 12 || offset > points.stride - 4 {
            return Err(QueryError::FaceOffset { offset, stride: points.stride });
        }
        points.end_of(count, offset + 4).map_err(QueryError::Points)?;
        Ok(())
    }
}
