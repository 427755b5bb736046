//! An encode of volumes from a depth map, to be drawn.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::error::DepthMapError;
use super::pipelines::DepthMapPipelines;
use crate::gpu::common::requirements::check_same;
use crate::shadow::DepthDirection;

/// Whether a near cap is drawn: where the eye's near rectangle is in shadow. It is a pass over the whole picture, so it is left
/// out where no place of the near rectangle can be.
#[derive(Clone, Debug, PartialEq)]
pub enum DepthMapNearCap {
    /// The near rectangle is in light as a whole, whatever is in the map. Nothing is drawn.
    Lit,
    /// The arguments of its draw, for the GPU to tell: 3 vertices if the samples of the map around the near rectangle say that it
    /// may be in shadow, else 0. Then 1, 0 and 0.
    Told(wgpu::Buffer),
    /// It is drawn.
    Drawn,
}

impl DepthMapNearCap {
    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, pipeline: &wgpu::RenderPipeline) {
        match self {
            Self::Lit => {}
            Self::Told(draw) => {
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

/// The volumes of one encode. They are drawn after it, in the same encoder or a later one.
#[derive(Clone, Debug)]
pub struct DepthMapFrame {
    pub(super) device: wgpu::Device,
    /// For each bit.
    pub(super) groups: Vec<wgpu::BindGroup>,
    pub(super) near_cap: DepthMapNearCap,
    /// Whether walls are drawn. Then there is one bit.
    pub(super) has_walls: bool,
    pub(super) draws: wgpu::Buffer,
    /// Cells or walls: their number, then they themselves.
    pub(super) list: wgpu::Buffer,
    pub(super) capacity: u32,
    /// The format of the eye's depth. It decides how far the boundary moves away from the eye.
    pub(super) format: wgpu::TextureFormat,
    pub(super) depth: DepthDirection,
    pub(super) encodes: Arc<AtomicU64>,
    pub(super) encode: u64,
}

impl DepthMapFrame {
    /// Draws into a pass with the attachments of `pipelines`: turns their bit of the stencil round wherever the surface
    /// that is seen is in shadow, or each of their bits for the boundary moved by its part of a texel.
    /// The depth attachment holds what is seen, and may be read-only. The stencil may not. It changes the pipeline and bind group
    /// 0 of the pass.
    ///
    /// # Errors
    /// [`DepthMapError`] if the pipelines do not fit, or a later encode overwrites what is drawn. Nothing is drawn then.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, pipelines: &DepthMapPipelines) -> Result<(), DepthMapError> {
        self.check(pipelines)?;
        if let (true, [group, ..]) = (self.has_walls, &self.groups[..]) {
            let (walls, own) = pipelines.walls()?;
            pass.set_bind_group(0, group, &[]);
            pass.set_pipeline(walls);
            pass.draw_indirect(&self.draws, 0);
            pass.set_pipeline(&own.surface);
            pass.draw_indirect(&self.draws, 16);
            self.near_cap.draw(pass, &own.near_cap);
            return Ok(());
        }
        for (group, own) in self.groups.iter().zip(&pipelines.draws) {
            pass.set_bind_group(0, group, &[]);
            pass.set_pipeline(&own.surface);
            pass.draw_indirect(&self.draws, 0);
            self.near_cap.draw(pass, &own.near_cap);
        }
        Ok(())
    }

    /// The arguments of its indirect draws, as the GPU wrote them: vertices, instances, first vertex, first instance. There are
    /// six vertices for each listed cell, and for each cell of the map if the list overflowed. With
    /// [`DepthMapMethod::Contours`](crate::gpu::depth_map::DepthMapMethod::Contours) six for each wall, or 0 if the list
    /// overflowed; then the arguments of a second draw follow, with six for each cell of the map, or 0 if it did not. Usage
    /// `COPY_SRC`.
    pub fn draw_arguments(&self) -> &wgpu::Buffer {
        &self.draws
    }

    /// Whether its near cap is drawn.
    #[doc(hidden)]
    pub fn near_cap(&self) -> &DepthMapNearCap {
        &self.near_cap
    }

    /// Refuses pipelines that do not fit, and a frame whose list a later encode overwrites.
    pub(super) fn check(&self, pipelines: &DepthMapPipelines) -> Result<(), DepthMapError> {
        check_same(["the pipelines", "the volumes"], [pipelines.shared().device(), &self.device])?;
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
    pub(super) fn check_current(&self) -> Result<(), DepthMapError> {
        if self.encodes.load(Ordering::Relaxed) == self.encode { Ok(()) } else { Err(DepthMapError::StaleFrame) }
    }
}
