//! What the commands that make pictures share: camera, shading normals, a short way to pipelines.

pub(crate) mod camera;
pub(crate) mod kit;
pub(crate) mod normals;
pub(crate) mod support;

use rimline::mesh::Bounds;

use crate::device::{self, Gpu};
use crate::failure::UsageError;

/// The largest side of the bounds, or 1 for a single point.
pub(crate) fn extent(bounds: &Bounds) -> f32 {
    let sides = (0..3).map(|axis| bounds.max[axis] - bounds.min[axis]);
    let largest = sides.fold(0.0, f32::max);
    if largest > 0.0 { largest } else { 1.0 }
}

/// The middle of the bounds.
pub(crate) fn centre(bounds: &Bounds) -> [f32; 3] {
    std::array::from_fn(|axis| bounds.min[axis] + 0.5 * (bounds.max[axis] - bounds.min[axis]))
}

/// Refuses pictures that the device cannot draw.
pub(crate) fn check_size(gpu: &Gpu, [width, height]: [u32; 2]) -> Result<(), UsageError> {
    let limit = gpu.device.limits().max_texture_dimension_2d;
    if width.max(height) > limit {
        let adapter = device::describe(&gpu.info);
        return Err(UsageError::Size { width, height, limit, adapter });
    }
    Ok(())
}
