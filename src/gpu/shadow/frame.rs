//! The result of one encode of shadow volumes: what can be drawn.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::buffers::Buffers;
use super::draws::LightDraws;
use super::errors::ShadowDrawError;
use super::pipelines::{Convention, Layouts, ShadowPipelines};
use crate::Light;
use crate::gpu::common::requirements::check_same;
use crate::gpu::common::uniforms::UniformTable;
use crate::gpu::extract::extraction::{self, Extraction};
use crate::layout::{SeenLight, ShadowDraw, ShadowDraws};

/// The bind groups of the draws.
#[derive(Debug)]
pub(super) struct DrawGroups {
    /// Casters, camera and lights.
    pub(super) frame: wgpu::BindGroup,
    /// Edges and the lists of sides, one for each batch of lights.
    pub(super) sides: Vec<wgpu::BindGroup>,
    /// Faces and their lists, one for each batch of lights.
    pub(super) caps: Vec<wgpu::BindGroup>,
}

/// State that volumes and their frames share.
#[derive(Debug)]
pub(super) struct Shared {
    /// The state of the extractor.
    pub(super) source: Arc<extraction::Shared>,
    pub(super) buffers: Buffers,
    pub(super) layouts: Layouts,
    pub(super) convention: Convention,
    /// Whether volumes may end at the range of their light.
    may_end: bool,
    encodes: AtomicU64,
}

impl Shared {
    pub(super) fn new(
        source: Arc<extraction::Shared>,
        buffers: Buffers,
        pipelines: &ShadowPipelines,
        may_end: bool,
    ) -> Self {
        let (layouts, convention) = (pipelines.layouts.clone(), pipelines.convention);
        Self { source, buffers, layouts, convention, may_end, encodes: AtomicU64::new(0) }
    }
}

/// The shadow volumes of one caster, as one [`ShadowVolumes::encode`](crate::gpu::ShadowVolumes::encode) prepared them:
/// for all lights of an extraction and one camera. A later encode of the volumes or of the extractor overwrites what it
/// draws. It is then refused.
#[derive(Clone, Debug)]
pub struct ShadowFrame {
    shared: Arc<Shared>,
    groups: Arc<DrawGroups>,
    extraction: Extraction,
    encode: u64,
}

impl ShadowFrame {
    /// Begins a frame. The buffers of the volumes are overwritten from here on.
    pub(super) fn new(shared: Arc<Shared>, groups: Arc<DrawGroups>, extraction: Extraction) -> Self {
        let encode = shared.encodes.fetch_add(1, Ordering::Relaxed) + 1;
        Self { shared, groups, extraction, encode }
    }

    /// The lights, in the order of the numbers that [`Self::draw`] takes.
    pub fn lights(&self) -> &[Light] {
        self.extraction.lights()
    }

    /// Draws the shadow volume of light number `light` into a pass with the attachments of `pipelines`. It counts up
    /// from the current content of the stencil. Other state of the pass does not matter. It changes the pipeline and
    /// bind groups 0 and 1.
    ///
    /// `pipelines` may differ from those that the volumes were made with, for other attachments, if counting method and
    /// depth are the same.
    ///
    /// # Errors
    /// [`ShadowDrawError`] if the pipelines do not match the volumes, the light was not encoded, or a later encode
    /// overwrites what is drawn. Nothing is drawn then.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &ShadowPipelines,
        light: usize,
    ) -> Result<(), ShadowDrawError> {
        self.extraction.check_current()?;
        if self.shared.encodes.load(Ordering::Relaxed) != self.encode {
            return Err(ShadowDrawError::StaleFrame);
        }
        let lights = self.lights().len();
        if light >= lights {
            return Err(ShadowDrawError::NoSuchLight { light, lights });
        }
        let devices = [pipelines.shared().device(), self.shared.source.device()];
        check_same(["the pipelines", "the volumes"], devices)?;
        self.shared.convention.check_drawn_by(pipelines.convention)?;
        let DrawGroups { frame, sides, caps } = &*self.groups;
        let (Some(sides), Some(caps)) = (sides.get(light / 32), caps.get(light / 32)) else { return Ok(()) };
        let draws = LightDraws {
            frame,
            uniform: (light * UniformTable::stride::<ShadowDraw>()) as u32,
            seen: (light * size_of::<SeenLight>()) as u32,
            sides,
            caps,
            draws: &self.shared.buffers.draws,
            first: (light * size_of::<ShadowDraws>()) as u64,
            may_end: self.shared.may_end,
        };
        draws.draw(pass, pipelines);
        Ok(())
    }
}
