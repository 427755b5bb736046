//! Checks the cameras of a cube of six maps. docs/numerics/depth-maps.md.

use glam::{DMat3, DVec3};

use super::error::DepthMapError;
use crate::ShadowCamera;
use crate::shadow::DepthDirection;

/// The largest error of a camera, from rounding of its matrix: below a hundredth of a texel of a map of 4,096 texels a side.
const TOLERANCE: f64 = 1.0 / 1_048_576.0;

/// Forward, right and up of each map, along the axes of the cube.
pub(super) const AXES: [[DVec3; 3]; 6] = [
    [DVec3::X, DVec3::Z, DVec3::Y],
    [DVec3::NEG_X, DVec3::NEG_Z, DVec3::Y],
    [DVec3::Y, DVec3::X, DVec3::Z],
    [DVec3::NEG_Y, DVec3::X, DVec3::NEG_Z],
    [DVec3::Z, DVec3::NEG_X, DVec3::Y],
    [DVec3::NEG_Z, DVec3::X, DVec3::Y],
];

/// The tangent of half the angle that a map of the cube sees: the middles of its outermost texels are 45° from its middle.
pub(super) fn tangent(side: u32) -> f64 {
    f64::from(side) / (f64::from(side) - 1.0)
}

/// A camera, from the rows of its matrix.
struct CubeCamera {
    /// Forward, right and up: unit vectors for a camera of a cube.
    axes: [DVec3; 3],
    position: DVec3,
    /// Clip w for a distance of 1.
    scale: f64,
    /// The depth at infinity, and the difference from it at a distance of 1.
    depths: [f64; 2],
    near: f64,
}

fn cube_camera(face: usize, camera: &ShadowCamera, side: u32) -> Result<CubeCamera, DepthMapError> {
    camera.check_any_hand().map_err(|error| DepthMapError::CubeLight { face, error })?;
    let matrix = camera.matrix();
    let [x, y, z, w] = [0, 1, 2, 3].map(|row| matrix.row(row));
    let scale = w.truncate().length();
    if scale == 0.0 {
        return Err(DepthMapError::Parallel { face });
    }
    // The point where x, y and w are 0.
    let rows = DMat3::from_cols(x.truncate(), y.truncate(), w.truncate()).transpose();
    let from = rows.inverse() * -DVec3::new(x.w, y.w, w.w);
    let at_infinity = z.truncate().dot(w.truncate()) / (scale * scale);
    let share = z.dot(from.extend(1.0)) / scale;
    let near_depth = if camera.depth == DepthDirection::Reversed { 1.0 } else { 0.0 };
    let tangent = tangent(side);
    Ok(CubeCamera {
        axes: [w, x * tangent, y * tangent].map(|row| row.truncate() / scale),
        position: from + camera.origin_point(),
        scale,
        depths: [at_infinity, share],
        near: share / (near_depth - at_infinity),
    })
}

/// Refuses cameras whose maps do not have their outermost samples on the same rays, with the same depths.
pub(super) fn check_meeting(cameras: &[ShadowCamera; 6], side: u32) -> Result<(), DepthMapError> {
    let camera = |face: usize| cube_camera(face, &cameras[face], side);
    let first = camera(0)?;
    let frame = DMat3::from_cols(first.axes[0], camera(2)?.axes[0], camera(4)?.axes[0]);
    let apart = |face, what| Err(DepthMapError::Apart { face, what });
    let is_off = |value: f64, limit: f64| value.is_nan() || value > limit;
    for (face, axes) in AXES.into_iter().enumerate() {
        if cameras[face].depth != cameras[0].depth {
            return apart(face, "its depth direction differs");
        }
        let other = camera(face)?;
        let [forward, right, up] =
            [0, 1, 2].map(|axis| is_off((other.axes[axis] - frame * axes[axis]).length(), TOLERANCE));
        let lengths = [1, 2].map(|axis| is_off((other.axes[axis].length() - 1.0).abs(), TOLERANCE));
        if lengths != [false; 2] {
            return apart(face, "the middles of its outermost texels are not 45° from its middle");
        }
        let is_skew =
            is_off(other.axes[0].dot(other.axes[1]).abs().max(other.axes[0].dot(other.axes[2]).abs()), TOLERANCE);
        if forward || right || up || is_skew {
            return apart(face, "it does not look along its axis of the cube, or is rotated");
        }
        // The rounding of an origin or a translation grows with its size.
        if is_off((other.position - first.position).length(), TOLERANCE * (first.position.length() + first.near)) {
            return apart(face, "it is at another position");
        }
        let scale = is_off((other.scale / first.scale - 1.0).abs(), TOLERANCE);
        let infinity = is_off((other.depths[0] - first.depths[0]).abs(), TOLERANCE);
        if scale || infinity || is_off((other.depths[1] / first.depths[1] - 1.0).abs(), TOLERANCE) {
            return apart(face, "its near or far distance, or the scale of its matrix, differs");
        }
    }
    Ok(())
}
