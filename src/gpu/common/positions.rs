//! Where positions lie.

use super::dispatch_limits::{DispatchLimits, Windows, binding};
use super::memory::{MemoryError, scoped};

/// Vertex positions in a storage buffer: three consecutive `f32` a vertex, at any offset and stride.
#[derive(Clone, Copy, Debug)]
pub struct PositionBuffer<'a> {
    /// A buffer with usage `STORAGE`.
    pub buffer: &'a wgpu::Buffer,
    /// Bytes before vertex 0's x; a multiple of 4.
    pub offset: u64,
    /// Bytes from a vertex to the next; a multiple of 4, at least 12.
    pub stride: u64,
}

/// Why positions cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PositionError {
    /// Offset or stride is not as it must be.
    #[error("positions at offset {offset}, stride {stride}: both must be multiples of 4, and the stride at least 12")]
    Alignment {
        /// The offset given.
        offset: u64,
        /// The stride given.
        stride: u64,
    },
    /// The buffer ends before the last vertex.
    #[error("{vertices} vertices at offset {offset}, stride {stride} need {needed} bytes, and the buffer has {bytes}")]
    TooShort {
        /// Vertices of the mesh.
        vertices: u32,
        /// The offset given.
        offset: u64,
        /// The stride given.
        stride: u64,
        /// Bytes needed.
        needed: u64,
        /// Bytes there are.
        bytes: u64,
    },
    /// The buffer cannot be bound in a shader.
    #[error("the position buffer lacks usage STORAGE")]
    NotStorage,
    /// The device cannot bind the buffer: it is another device's, or was destroyed.
    #[error(
        "the device does not bind the buffer; give one of the device that the stages are on, not destroyed: {message}"
    )]
    Refused {
        /// What the device said.
        message: String,
    },
    /// The positions do not fit the shaders' bindings.
    #[error(transparent)]
    Memory(#[from] MemoryError),
}

/// A checked position buffer, as it is bound.
pub(crate) struct BoundPositions {
    /// Where the windows begin in the buffer.
    pub(crate) base: u64,
    pub(crate) windows: Windows,
    /// First word of vertex 0 from `base`, and words from a vertex to the next.
    pub(crate) offset_words: u32,
    pub(crate) stride_words: u32,
}

impl PositionBuffer<'_> {
    /// The end of the last of `vertices` in the buffer, in bytes.
    pub(crate) fn end(&self, vertices: u32) -> Result<u64, PositionError> {
        let Self { buffer, offset, stride } = *self;
        if offset % 4 != 0 || stride % 4 != 0 || stride < 12 {
            return Err(PositionError::Alignment { offset, stride });
        }
        if !buffer.usage().contains(wgpu::BufferUsages::STORAGE) {
            return Err(PositionError::NotStorage);
        }
        let span = u128::from(vertices.max(1) - 1) * u128::from(stride) + 12 + u128::from(offset);
        if span > u128::from(buffer.size()) {
            let needed = u64::try_from(span).unwrap_or(u64::MAX);
            return Err(PositionError::TooShort { vertices, offset, stride, needed, bytes: buffer.size() });
        }
        Ok(span as u64)
    }

    pub(crate) fn bind(&self, vertices: u32, split: &DispatchLimits) -> Result<BoundPositions, PositionError> {
        let Self { offset, stride, .. } = *self;
        let end = self.end(vertices)?;
        let base = split.align_down(offset);
        let bytes = end - base;
        if bytes / 4 > u64::from(u32::MAX) {
            return Err(MemoryError::Gathered { what: "positions", bytes, limit: 4 * u64::from(u32::MAX) }.into());
        }
        let windows = split.windows("positions", bytes)?;
        Ok(BoundPositions {
            base,
            windows,
            offset_words: ((offset - base) / 4) as u32,
            stride_words: (stride / 4) as u32,
        })
    }
}

/// Runs what makes bind groups over a caller's buffers, and reports a buffer that the device does not take.
pub(crate) fn bound<T>(device: &wgpu::Device, make: impl FnOnce() -> T) -> Result<T, PositionError> {
    scoped(device, wgpu::ErrorFilter::Validation, make).map_err(|message| PositionError::Refused { message })
}

impl BoundPositions {
    /// The first window: everything, where there is one.
    pub(crate) fn first_binding<'a>(&self, buffer: &'a wgpu::Buffer) -> wgpu::BindingResource<'a> {
        let [first, ..] = &self.windows.ranges;
        binding(buffer, self.base + first.start..self.base + first.end)
    }

    /// The four windows of the buffer, as `positions.wgsl` binds them.
    pub(crate) fn bindings<'a>(
        &self,
        buffer: &'a wgpu::Buffer,
    ) -> impl Iterator<Item = (&'static str, wgpu::BindingResource<'a>)> + use<'a> {
        let base = self.base;
        let windows = self.windows.ranges.clone();
        let windows = windows.into_iter().map(move |window| binding(buffer, base + window.start..base + window.end));
        ["positions_0", "positions_1", "positions_2", "positions_3"].into_iter().zip(windows)
    }
}
