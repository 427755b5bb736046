//! Rotations and matrices in the form that glTF gives them.

use glam::{DAffine3, DMat4, DQuat};

use super::error::GltfError;

/// A quaternion scaled to length 1, or `None` if its length is zero or not finite.
pub(super) fn unit(rotation: [f64; 4]) -> Option<DQuat> {
    let largest = rotation.iter().fold(0.0_f64, |most, c| most.max(c.abs()));
    let scaled = DQuat::from_array(rotation.map(|c| c / largest));
    let normalized = scaled / scaled.length();
    normalized.is_finite().then_some(normalized)
}

/// A column-major matrix. Its last row must be (0, 0, 0, 1), except for rounding on export.
pub(super) fn affine(columns: [f64; 16], place: impl Fn() -> String) -> Result<DAffine3, GltfError> {
    const TOLERANCE: f64 = 1e-5;
    let matrix = DMat4::from_cols_array(&columns);
    let row = matrix.row(3).to_array();
    let problem = if !matrix.is_finite() {
        "the matrix is not finite"
    } else if row.iter().zip([0.0, 0.0, 0.0, 1.0]).any(|(a, b)| (a - b).abs() > TOLERANCE) {
        "the matrix's last row must be (0, 0, 0, 1)"
    } else {
        return Ok(DAffine3::from_mat4(matrix));
    };
    Err(GltfError::Transform { place: place(), problem })
}
