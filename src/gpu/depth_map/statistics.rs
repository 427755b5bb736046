//! Statistics of an encode of volumes.

use super::error::DepthMapError;
use super::frame::{DepthMapFrame, DepthMapNearCap};
use crate::gpu::common::memory::filled;

/// Counts of an encode of volumes on the GPU. [`DepthMapFrame::statistics`] copies them into a buffer, which
/// [`read_back_vec`](crate::gpu::read_back_vec) reads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct DepthMapStatistics {
    /// Cells in which the boundary has triangles. With
    /// [`DepthMapMethod::Contours`](crate::gpu::depth_map::DepthMapMethod::Contours), walls and flaps.
    pub found: u32,
    /// Entries that the list has room for: [`DepthMapOptions::capacity`](crate::gpu::depth_map::DepthMapOptions::capacity).
    pub capacity: u32,
    /// Vertices of the near cap: 3 if it is drawn, 0 if it is skipped.
    pub near_cap_vertices: u32,
    /// 0.
    pub unused: u32,
}

impl DepthMapStatistics {
    /// Whether the list overflowed. Then every cell is drawn: the result is the same, but slower.
    pub fn is_overflowed(&self) -> bool {
        self.found > self.capacity
    }
}

impl DepthMapFrame {
    /// Records a copy of the counts of this encode. The buffer has one [`DepthMapStatistics`] once the encoder is
    /// submitted, and usage `COPY_SRC`. Call it after the encode, before the next one of the same volumes.
    ///
    /// # Errors
    /// [`DepthMapError::StaleFrame`] if a later encode overwrites what is copied. Nothing is recorded then.
    pub fn statistics(&self, encoder: &mut wgpu::CommandEncoder) -> Result<wgpu::Buffer, DepthMapError> {
        self.check_current()?;
        let near_cap_vertices = if self.near_cap == DepthMapNearCap::Drawn { 3 } else { 0 };
        let known = DepthMapStatistics { capacity: self.capacity, near_cap_vertices, ..DepthMapStatistics::default() };
        let usage = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let statistics = filled(&self.device, "statistics of depth maps", bytemuck::bytes_of(&known), usage);
        // A list begins with its count.
        encoder.copy_buffer_to_buffer(&self.list, 0, &statistics, 0, 4);
        if let DepthMapNearCap::Indirect(draw) = &self.near_cap {
            encoder.copy_buffer_to_buffer(draw, 0, &statistics, 8, 4);
        }
        Ok(statistics)
    }
}
