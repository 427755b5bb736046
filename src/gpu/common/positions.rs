//! The layout of positions in buffers.

use super::bindings::{Resource, part};
use super::device_error::DeviceError;
use super::dispatch_limits::{DispatchLimits, Windows};
use super::memory::scoped;

/// Vertex positions in a storage buffer: three consecutive `f32` for each vertex, in the space of the lights. Any
/// offset and stride that are multiples of 4 bytes will do.
#[derive(Clone, Copy, Debug)]
pub struct PositionBuffer<'a> {
    /// The buffer, with usage `STORAGE`.
    pub buffer: &'a wgpu::Buffer,
    /// Bytes from the start of the buffer to the x of vertex 0. A multiple of 4.
    pub offset: u64,
    /// Bytes from one vertex to the next. A multiple of 4, at least 12.
    pub stride: u64,
}

/// A position buffer that was checked, as stages bind it.
pub(crate) struct BoundPositions {
    /// The offset in the buffer where the windows begin.
    pub(crate) base: u64,
    /// Up to four ranges of the buffer, one a binding, counted from `base`.
    pub(crate) windows: Windows,
    /// The word of vertex 0, counted from `base`, and the words from one vertex to the next.
    pub(crate) offset_words: u32,
    pub(crate) stride_words: u32,
}

impl PositionBuffer<'_> {
    /// The end in the buffer of the last of `vertices`, in bytes. No vertices need the room of one.
    pub(crate) fn end(&self, vertices: u32) -> Result<u64, DeviceError> {
        self.end_of(vertices, 12)
    }

    /// The same for positions with this number of bytes from x on.
    pub(crate) fn end_of(&self, vertices: u32, bytes: u64) -> Result<u64, DeviceError> {
        let Self { buffer, offset, stride } = *self;
        if offset % 4 != 0 || stride % 4 != 0 || stride < 12 {
            return Err(DeviceError::PositionLayout { offset, stride });
        }
        if !buffer.usage().contains(wgpu::BufferUsages::STORAGE) {
            return Err(DeviceError::NotStorage);
        }
        let span = u128::from(vertices.max(1) - 1) * u128::from(stride) + u128::from(bytes) + u128::from(offset);
        if span > u128::from(buffer.size()) {
            let needed = u64::try_from(span).unwrap_or(u64::MAX);
            return Err(DeviceError::PositionsTooShort { vertices, offset, stride, needed, bytes: buffer.size() });
        }
        Ok(span as u64)
    }

    pub(crate) fn bind(&self, vertices: u32, limits: &DispatchLimits) -> Result<BoundPositions, DeviceError> {
        let Self { offset, stride, .. } = *self;
        let end = self.end(vertices)?;
        let base = limits.align_down(offset);
        let bytes = end - base;
        if bytes / 4 > u64::from(u32::MAX) {
            return Err(DeviceError::GatheredTooLarge { what: "positions", bytes, limit: 4 * u64::from(u32::MAX) });
        }
        let windows = limits.windows("positions", bytes)?;
        Ok(BoundPositions {
            base,
            windows,
            offset_words: ((offset - base) / 4) as u32,
            stride_words: (stride / 4) as u32,
        })
    }
}

/// Runs `make`, which makes bind groups over a caller's buffers, and returns an error for a buffer that the device
/// refuses.
pub(crate) fn bound<T>(device: &wgpu::Device, make: impl FnOnce() -> T) -> Result<T, DeviceError> {
    scoped(device, wgpu::ErrorFilter::Validation, make).map_err(|message| DeviceError::BufferRefused { message })
}

impl BoundPositions {
    /// The first window. It holds everything if there is only one.
    pub(crate) fn first_binding<'a>(&self, buffer: &'a wgpu::Buffer) -> Resource<'a> {
        let [first, ..] = &self.windows.ranges;
        part(buffer, self.base + first.start..self.base + first.end)
    }

    /// One of the four windows of the buffer, as `positions.wgsl` names them.
    pub(crate) fn named<'a>(&self, name: &str, buffer: &'a wgpu::Buffer) -> Option<Resource<'a>> {
        let window = self.windows.named("positions_", name)?;
        Some(part(buffer, self.base + window.start..self.base + window.end))
    }
}
