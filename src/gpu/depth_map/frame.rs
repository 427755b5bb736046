//! The result of an encode of volumes from a depth map: its draws and its counts.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::error::DepthMapError;
use super::pipelines::DepthMapPipelines;
use crate::gpu::common::memory::filled;
use crate::gpu::common::requirements::check_same;
use crate::shadow::DepthDirection;

/// Whether the near cap is drawn, which inverts the stencil bit where the eye's near rectangle is in shadow. It covers the
/// whole picture, so it is skipped where the whole near rectangle is lit.
#[derive(Clone, Debug, PartialEq)]
pub enum DepthMapNearCap {
    /// The whole near rectangle is lit for any depths of the map. Nothing is drawn.
    Skipped,
    /// Arguments of its draw, which the GPU writes: 3 vertices if samples around the near rectangle show that it may be in
    /// shadow, else 0. Then 1, 0 and 0.
    Indirect(wgpu::Buffer),
    /// It is drawn.
    Drawn,
}

impl DepthMapNearCap {
    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, pipeline: &wgpu::RenderPipeline) {
        match self {
            Self::Skipped => {}
            Self::Indirect(draw) => {
                pass.set_pipeline(pipeline);
                pass.draw_indirect(draw, 0);
            }
            Self::Drawn => {
                pass.set_pipeline(pipeline);
                pass.draw(0..3, 0..1);
            }
        }
    }
}

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
    /// Whether the list overflowed. [`DepthMapOptions::capacity`](crate::gpu::depth_map::DepthMapOptions::capacity) says
    /// which shadows are drawn then.
    pub fn is_overflowed(&self) -> bool {
        self.found > self.capacity
    }
}

/// The volumes of one encode. Draw them after it, in the same encoder or a later one.
#[derive(Clone, Debug)]
pub struct DepthMapFrame {
    pub(super) device: wgpu::Device,
    /// For each bit.
    pub(super) groups: Vec<wgpu::BindGroup>,
    pub(super) near_cap: DepthMapNearCap,
    /// Whether walls are drawn. Then there is one bit.
    pub(super) has_walls: bool,
    pub(super) draws: wgpu::Buffer,
    /// The count of cells or walls, then the cells or walls.
    pub(super) list: wgpu::Buffer,
    pub(super) capacity: u32,
    /// The format of the eye's depth. The boundary moves away from the eye by its errors.
    pub(super) format: wgpu::TextureFormat,
    pub(super) depth: DepthDirection,
    pub(super) encodes: Arc<AtomicU64>,
    pub(super) encode: u64,
}

impl DepthMapFrame {
    /// Draws into a pass with the attachments of `pipelines`. It inverts their stencil bit wherever the visible surface is
    /// in shadow; with several bits, each bit for the boundary moved by its part of a texel. The depth attachment holds the
    /// visible surfaces, and may be read-only; the stencil may not. The pipeline and bind group 0 of the pass change.
    ///
    /// # Errors
    /// [`DepthMapError`] if the pipelines do not fit, or a later encode overwrites what is drawn. Nothing is drawn then.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, pipelines: &DepthMapPipelines) -> Result<(), DepthMapError> {
        self.check(pipelines)?;
        let walls = if self.has_walls { Some(pipelines.walls()?) } else { None };
        for (group, bit) in self.groups.iter().zip(&pipelines.draws) {
            pass.set_bind_group(0, group, &[]);
            let (bit, cells) = match walls {
                Some((walls, bit)) => {
                    pass.set_pipeline(walls);
                    pass.draw_indirect(&self.draws, 0);
                    (bit, 16)
                }
                None => (bit, 0),
            };
            pass.set_pipeline(&bit.surface);
            pass.draw_indirect(&self.draws, cells);
            self.near_cap.draw(pass, &bit.near_cap);
        }
        Ok(())
    }

    /// The arguments of its indirect draws, which the GPU writes: vertices, instances, first vertex, first instance. There
    /// are six vertices for each listed cell, or for each cell of the map if the list overflowed. With
    /// [`DepthMapMethod::Contours`](crate::gpu::depth_map::DepthMapMethod::Contours) there are two draws: of walls, with 0
    /// vertices if their list overflowed, then of all cells, with 0 vertices if it did not. The buffer has usage `COPY_SRC`.
    pub fn draw_arguments(&self) -> &wgpu::Buffer {
        &self.draws
    }

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

    /// Whether its near cap is drawn.
    #[doc(hidden)]
    pub fn near_cap(&self) -> &DepthMapNearCap {
        &self.near_cap
    }

    /// Refuses pipelines that do not fit, and a frame whose list a later encode overwrites.
    fn check(&self, pipelines: &DepthMapPipelines) -> Result<(), DepthMapError> {
        check_same(["`DepthMapPipelines`", "the volumes"], [pipelines.shared.device(), &self.device])?;
        let (volumes, other) = (self.depth, pipelines.format().depth);
        if volumes != other {
            return Err(DepthMapError::Depth { what: "the pipelines", given: other, made: volumes });
        }
        let (volumes, other) = (self.format, pipelines.format().depth_stencil);
        if volumes != other {
            return Err(DepthMapError::DepthFormat { volumes, pipelines: other });
        }
        let [volumes, other] = [self.groups.len(), pipelines.draws.len()].map(|bits| bits as u32);
        if volumes != other {
            return Err(DepthMapError::DrawBits { volumes, pipelines: other });
        }
        self.check_current()
    }

    /// Refuses a frame whose list a later encode overwrites.
    fn check_current(&self) -> Result<(), DepthMapError> {
        if self.encodes.load(Ordering::Relaxed) == self.encode { Ok(()) } else { Err(DepthMapError::StaleFrame) }
    }
}
