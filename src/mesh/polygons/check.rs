//! Checks of polygons as they are given.

use super::{MAX_POLYGON_CORNERS, PolygonLoops};
use crate::mesh::error::{MAX_FACES, MeshError, check_counts};

/// Refuses arrays that do not fit together, small loops and bad indices. The error names the first one.
pub(super) fn check(vertex_count: usize, given: PolygonLoops<'_>) -> Result<(), MeshError> {
    let PolygonLoops { polygon_loops, loop_sizes, loop_corners } = given;
    check_counts(vertex_count, polygon_loops.len())?;
    if loop_corners.len() > 3 * MAX_FACES {
        return Err(MeshError::TooManyCorners { corners: loop_corners.len() });
    }
    let (mut sizes, mut corners) = (loop_sizes.iter(), loop_corners);
    for (polygon, &loops) in polygon_loops.iter().enumerate() {
        if loops == 0 {
            return Err(MeshError::PolygonWithoutLoops { polygon });
        }
        let mut polygon_corners = 0;
        for loop_index in 0..loops as usize {
            let Some(&size) = sizes.next() else {
                return Err(MeshError::MissingLoops { polygon, loop_index, loops: loop_sizes.len() });
            };
            let size = size as usize;
            if size < 3 {
                return Err(MeshError::LoopTooSmall { polygon, loop_index, corners: size });
            }
            polygon_corners += size;
            if polygon_corners > MAX_POLYGON_CORNERS {
                return Err(MeshError::PolygonTooLarge { polygon });
            }
            let Some((of_loop, rest)) = corners.split_at_checked(size) else {
                return Err(MeshError::MissingCorners { polygon, loop_index, corners: loop_corners.len() });
            };
            if let Some(corner) = of_loop.iter().position(|&v| v as usize >= vertex_count) {
                let index = of_loop[corner];
                let vertices = vertex_count;
                return Err(MeshError::CornerOutOfRange { polygon, loop_index, corner, index, vertices });
            }
            corners = rest;
        }
    }
    if sizes.len() > 0 {
        return Err(MeshError::LoopsLeftOver { loops: sizes.len() });
    }
    if !corners.is_empty() {
        return Err(MeshError::CornersLeftOver { corners: corners.len() });
    }
    Ok(())
}
