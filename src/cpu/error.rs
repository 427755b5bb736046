//! Why functions of the CPU refuse what they are given.

use crate::light::LightError;
use crate::mesh::{Mesh, NO_FACE};

/// Why [`cpu::extract`](crate::cpu::extract()), [`cpu::Extraction`](crate::cpu::Extraction),
/// [`cpu::shadow_depth`](crate::cpu::shadow_depth) or [`cpu::OccludedFaces`](crate::cpu::OccludedFaces) refuses what it
/// is given. On the GPU the same is refused, but for faces of points, which are in a buffer.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what fields are")]
pub enum CpuError {
    /// The lights are refused.
    #[error(transparent)]
    Light(#[from] LightError),
    /// Positions are missing.
    #[error("{given} positions given, and the mesh has {needed} vertices; give one for each")]
    TooFewPositions { given: usize, needed: u32 },
    /// Positions of a caster are missing.
    #[error("caster {caster} has {given} positions, and its mesh has {needed} vertices; give one for each")]
    TooFewCasterPositions { caster: usize, given: usize, needed: u32 },
    /// Points name their faces, and there are not as many of these as points.
    #[error("{given} faces given for {points} points; give one for each, `NO_FACE` for a point that is on none")]
    FaceForEachPoint { given: usize, points: usize },
    /// A point names a face that the mesh lacks.
    #[error(
        "point {point} is on face {face}, and the mesh has {faces}; give a number in `Mesh::faces`, or `NO_FACE` for none"
    )]
    NoSuchFace { point: usize, face: u32, faces: usize },
    /// The caller ended the search.
    #[error("the search for occluded faces was cancelled")]
    Cancelled,
}

/// Checks that each vertex of the mesh has a position. There may be more.
pub(crate) fn check_positions(positions: &[[f32; 3]], mesh: &Mesh) -> Result<(), CpuError> {
    let (given, needed) = (positions.len(), mesh.vertex_count());
    if given < needed as usize { Err(CpuError::TooFewPositions { given, needed }) } else { Ok(()) }
}

/// Checks the faces that points name: one for each point, and each a face of the mesh or [`NO_FACE`].
pub(crate) fn check_on_face(on_face: Option<&[u32]>, points: usize, faces: usize) -> Result<(), CpuError> {
    let Some(given) = on_face else { return Ok(()) };
    if given.len() != points {
        return Err(CpuError::FaceForEachPoint { given: given.len(), points });
    }
    match given.iter().position(|&face| face != NO_FACE && face as usize >= faces) {
        Some(point) => Err(CpuError::NoSuchFace { point, face: given[point], faces }),
        None => Ok(()),
    }
}
