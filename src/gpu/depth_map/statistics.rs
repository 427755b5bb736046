//! What the GPU found in an encode of volumes, for those who want to read it.

use super::frame::{DepthMapFrame, DepthMapNearCap};
use super::frame_errors::DepthMapDrawError;
use crate::gpu::common::memory::filled;

/// What the GPU found in an encode of volumes. Nothing is read back by itself: [`DepthMapFrame::statistics`] and
/// [`DepthMapCastersFrame::statistics`](crate::gpu::DepthMapCastersFrame::statistics) copy it into a buffer, which
/// [`read_back_vec`](crate::gpu::read_back_vec) reads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct DepthMapStatistics {
    /// Cells that the boundary has triangles in. With
    /// [`DepthMapReconstruction::Contours`](crate::gpu::DepthMapReconstruction::Contours), walls and flaps.
    pub found: u32,
    /// Those that the list has room for: [`DepthMapOptions::capacity`](crate::gpu::DepthMapOptions::capacity).
    pub capacity: u32,
    /// Vertices of the near cap: 3 if it is drawn, 0 if it is left out.
    pub near_cap_vertices: u32,
    /// 0.
    pub unused: u32,
}

impl DepthMapStatistics {
    /// Whether the list overflowed. Then every cell is drawn: nothing is lost, but the draw is slower.
    pub fn is_overflowed(&self) -> bool {
        self.found > self.capacity
    }
}

/// The bytes of one.
const BYTES: u64 = size_of::<DepthMapStatistics>() as u64;

impl DepthMapFrame {
    /// Records a copy of what the GPU finds in this encode. The buffer has one [`DepthMapStatistics`] once the encoder is
    /// submitted, and usage `COPY_SRC`. Call it after the encode, before the next one of the same volumes.
    ///
    /// # Errors
    /// [`DepthMapDrawError::StaleFrame`] if a later encode overwrites what is copied. Nothing is recorded then.
    pub fn statistics(&self, encoder: &mut wgpu::CommandEncoder) -> Result<wgpu::Buffer, DepthMapDrawError> {
        record(&self.device, encoder, &[self])
    }

    /// What is known of them before.
    fn known(&self) -> DepthMapStatistics {
        let near_cap_vertices = if self.near_cap == DepthMapNearCap::Drawn { 3 } else { 0 };
        DepthMapStatistics { capacity: self.capacity, near_cap_vertices, ..DepthMapStatistics::default() }
    }
}

/// Records copies of what the GPU finds, one after the other in one buffer.
pub(super) fn record(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    frames: &[&DepthMapFrame],
) -> Result<wgpu::Buffer, DepthMapDrawError> {
    frames.iter().try_for_each(|frame| frame.check_current())?;
    let known: Vec<_> = frames.iter().map(|frame| frame.known()).collect();
    let usage = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
    let statistics = filled(device, "statistics of depth maps", bytemuck::cast_slice(&known), usage);
    for (at, frame) in (0..).step_by(BYTES as usize).zip(frames) {
        // A list begins with what was found.
        encoder.copy_buffer_to_buffer(&frame.list, 0, &statistics, at, 4);
        if let DepthMapNearCap::Told(draw) = &frame.near_cap {
            encoder.copy_buffer_to_buffer(draw, 0, &statistics, at + 8, 4);
        }
    }
    Ok(statistics)
}
