//! Parts that the commands that make pictures share: the camera, faces that coincide, limits.

pub(crate) mod camera;
pub(crate) mod coincident;

use rimline::gpu::DeviceError;
use rimline_picture::Bounds;

use crate::device::{self, Gpu};
use crate::failure::{InputError, UsageError};
use crate::gpu_error::GpuError;

/// Refuses bounds that no camera and no light can be chosen by.
pub(crate) fn check_bounds(bounds: &Bounds) -> Result<(), InputError> {
    if bounds.extent().is_finite() { Ok(()) } else { Err(InputError::Boundless) }
}

/// Why a picture that takes so many bytes a pixel in one array cannot be drawn, and one that can.
pub(crate) fn too_large(gpu: &Gpu, [width, height]: [u32; 2], bytes: u64) -> UsageError {
    let needed = (bytes * u64::from(width) * u64::from(height)) >> 20;
    let fits = fitting([width, height], gpu.device.limits().max_buffer_size / bytes);
    UsageError::PictureMemory { width, height, needed, adapter: device::describe(&gpu.info), fits }
}

/// A smaller picture of about the same shape and at most so many pixels: half of each side, if that is enough.
fn fitting([width, height]: [u32; 2], pixels: u64) -> [u32; 2] {
    let asked = f64::from(width) * f64::from(height);
    let part = (pixels as f64 / asked).sqrt().min(0.5);
    [width, height].map(|side| ((f64::from(side) * part) as u32).max(1))
}

pub(crate) fn check_size(gpu: &Gpu, [width, height]: [u32; 2]) -> Result<(), UsageError> {
    let limit = gpu.device.limits().max_texture_dimension_2d;
    if width.max(height) > limit {
        let adapter = device::describe(&gpu.info);
        return Err(UsageError::Size { width, height, limit, adapter });
    }
    Ok(())
}

/// Refuses models of which the device cannot read all faces and vertices at once, as pictures do.
pub(crate) fn check_model(gpu: &Gpu, faces: usize, vertices: usize) -> Result<(), GpuError> {
    const BYTES: u64 = 12;
    let limit = gpu.device.limits().max_storage_buffer_binding_size;
    for (what, count) in [("the model's array of faces", faces), ("its array of positions", vertices)] {
        let bytes = BYTES * count as u64;
        if bytes > limit {
            return Err(DeviceError::BindingTooLarge { what, bytes, limit }.into());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_that_is_advised_fits() {
        for (size, pixels, advised) in
            [([16384, 16384], 1 << 27, [8192, 8192]), ([16384, 8192], 1 << 23, [4096, 2048]), ([9, 9], 1, [1, 1])]
        {
            assert_eq!(fitting(size, pixels), advised);
            assert!(u64::from(advised[0]) * u64::from(advised[1]) <= pixels);
        }
    }
}
