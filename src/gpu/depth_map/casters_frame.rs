//! An encode of depth maps that cast in a scene, to be drawn.

use std::sync::Arc;

use super::caster::{DepthMapCasterCounts, DepthMapCasterHandle};
use super::casters_errors::DepthMapCastersError;
use super::frame::DepthMapFrame;
use super::pipelines::DepthMapPipelines;
use super::statistics::record;
use crate::Light;
use crate::gpu::common::requirements::check_same;
use crate::gpu::scene::handles::{LightHandle, SceneId};

/// The volumes of one [`DepthMapCasters::encode`](crate::gpu::DepthMapCasters::encode). A later encode that finds the cells of a
/// map anew overwrites those of this frame, whose draw is then refused.
#[derive(Clone, Debug)]
pub struct DepthMapCastersFrame {
    pub(super) device: wgpu::Device,
    pub(super) casters: SceneId,
    pub(super) scene: SceneId,
    pub(super) lights: Arc<[(LightHandle, Light)]>,
    pub(super) views: usize,
    /// The bits of the stencil that counts of the scene's meshes own. `None`: the scene draws nothing.
    pub(super) count_bits: Option<u32>,
    pub(super) drawn: Vec<DrawnCaster>,
    pub(super) counts: DepthMapCasterCounts,
}

/// A caster, with a frame for each camera that draws it.
#[derive(Clone, Debug)]
pub(super) struct DrawnCaster {
    pub(super) handle: DepthMapCasterHandle,
    pub(super) light: LightHandle,
    pub(super) frames: Vec<(usize, DepthMapFrame)>,
}

impl DepthMapCastersFrame {
    /// Draws the volumes of all maps of a light, as the camera with number `view` sees them: see
    /// [`DepthMapFrame::draw`](crate::gpu::DepthMapFrame::draw). Maps that are skipped take nothing.
    ///
    /// Parities of two maps in one bit would undo each other where both are dark. So with several maps of a light take
    /// [`DepthMapPipelines::counting`], or give each bits of its own and draw it by [`Self::draw_caster`], or make them one by
    /// [`DepthMapMerge`](crate::gpu::DepthMapMerge).
    ///
    /// # Errors
    /// [`DepthMapCastersError`] if the frame has no such view or light, the pipelines do not fit, counts of the scene own one of
    /// their bits, there are several maps in one bit, or a later encode overwrites what is drawn. Nothing is drawn then.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &DepthMapPipelines,
        view: usize,
        light: LightHandle,
    ) -> Result<(), DepthMapCastersError> {
        self.check(pipelines, view)?;
        if light.scene != self.scene {
            return Err(DepthMapCastersError::OtherScene { what: "light" });
        }
        if !self.lights.iter().any(|(handle, _)| *handle == light) {
            return Err(DepthMapCastersError::NotEncoded { what: "light" });
        }
        let own: Vec<_> = self.drawn.iter().filter(|drawn| drawn.light == light).collect();
        if own.len() > 1 && !pipelines.is_counting() {
            return Err(DepthMapCastersError::OneParity { casters: own.len() });
        }
        let frames: Vec<_> = own.iter().flat_map(|drawn| drawn.of_view(view)).collect();
        frames.iter().try_for_each(|frame| frame.check(pipelines))?;
        frames.iter().try_for_each(|frame| frame.draw(pass, pipelines))?;
        Ok(())
    }

    /// Draws the volumes of one map, as [`Self::draw`] does.
    ///
    /// # Errors
    /// [`DepthMapCastersError`], as for [`Self::draw`], or of the handle. Nothing is drawn then.
    pub fn draw_caster(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &DepthMapPipelines,
        view: usize,
        caster: DepthMapCasterHandle,
    ) -> Result<(), DepthMapCastersError> {
        self.check(pipelines, view)?;
        if !caster.is_of(self.casters) {
            return Err(DepthMapCastersError::OtherScene { what: "caster" });
        }
        let drawn = self.drawn.iter().find(|drawn| drawn.handle == caster);
        let drawn = drawn.ok_or(DepthMapCastersError::NotEncoded { what: "caster" })?;
        drawn.of_view(view).try_for_each(|frame| frame.draw(pass, pipelines))?;
        Ok(())
    }

    /// The maps that are drawn, each with the number of a camera that draws it.
    pub fn drawn(&self) -> impl Iterator<Item = (DepthMapCasterHandle, usize)> {
        self.drawn.iter().flat_map(|drawn| drawn.frames.iter().map(|(view, _)| (drawn.handle, *view)))
    }

    /// Records a copy of what the GPU finds in this encode: a [`DepthMapStatistics`](crate::gpu::DepthMapStatistics) for each of
    /// [`Self::drawn`], in the same order, in a buffer with usage `COPY_SRC`. They tell whose list overflowed, and which near
    /// caps the GPU left out. Call it before the next encode. `None`: nothing is drawn.
    ///
    /// # Errors
    /// [`DepthMapCastersError::Draw`] if a later encode overwrites what is copied. Nothing is recorded then.
    pub fn statistics(&self, encoder: &mut wgpu::CommandEncoder) -> Result<Option<wgpu::Buffer>, DepthMapCastersError> {
        let frames: Vec<_> = self.drawn.iter().flat_map(|drawn| drawn.frames.iter().map(|(_, frame)| frame)).collect();
        Ok(if frames.is_empty() { None } else { Some(record(&self.device, encoder, &frames)?) })
    }

    /// What was done with the maps.
    pub fn counts(&self) -> DepthMapCasterCounts {
        self.counts
    }

    fn check(&self, pipelines: &DepthMapPipelines, view: usize) -> Result<(), DepthMapCastersError> {
        check_same(["the pipelines", "the scene"], [pipelines.shared().device(), &self.device])?;
        let views = self.views;
        if view >= views {
            return Err(DepthMapCastersError::NoSuchView { view, views });
        }
        let Some(scene) = self.count_bits else { return Ok(()) };
        let (bits, own) = (pipelines.bits(), pipelines.format().count_bits);
        if pipelines.is_counting() && own != scene {
            return Err(DepthMapCastersError::CountBits { scene, pipelines: own });
        }
        if !pipelines.is_counting() && bits.start < scene {
            return Err(DepthMapCastersError::Counted { bit: bits.start, count_bits: scene });
        }
        Ok(())
    }
}

impl DrawnCaster {
    /// Its frame for a camera, if it is drawn.
    fn of_view(&self, view: usize) -> impl Iterator<Item = &DepthMapFrame> {
        self.frames.iter().filter(move |(of, _)| *of == view).map(|(_, frame)| frame)
    }
}
