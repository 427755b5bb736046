//! Positions of vertices, which may be missing or not finite.

/// Whether all three coordinates are finite.
pub fn is_finite(position: [f32; 3]) -> bool {
    position.iter().all(|c| c.is_finite())
}

/// The position of a vertex, or NaN if there is none.
pub(crate) fn position(positions: &[[f32; 3]], vertex: u32) -> [f32; 3] {
    positions.get(vertex as usize).copied().unwrap_or([f32::NAN; 3])
}
