//! Why functions of the CPU refuse what they are given.

use crate::light::LightError;
use crate::mesh::Mesh;

/// Why [`cpu::extract`](crate::cpu::extract()), [`cpu::Extraction`](crate::cpu::Extraction) or
/// [`cpu::shadow_depth`](crate::cpu::shadow_depth) refuses what it is given. On the GPU the same is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ArgumentError {
    /// The lights are refused.
    #[error(transparent)]
    Light(#[from] LightError),
    /// Positions are missing.
    #[error("{given} positions given, and the mesh has {needed} vertices; give one for each")]
    TooFewPositions {
        /// Positions given.
        given: usize,
        /// Vertices of the mesh.
        needed: u32,
    },
}

/// Checks that each vertex of the mesh has a position. There may be more.
///
/// # Errors
/// [`ArgumentError::TooFewPositions`] if there are fewer.
pub(crate) fn check_positions(positions: &[[f32; 3]], mesh: &Mesh) -> Result<(), ArgumentError> {
    let (given, needed) = (positions.len(), mesh.vertex_count());
    if given < needed as usize { Err(ArgumentError::TooFewPositions { given, needed }) } else { Ok(()) }
}
