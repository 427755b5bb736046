//! The result of one encode of shadow volumes: what can be drawn.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::buffers::SizedBuffers;
use super::errors::ShadowError;
use super::pipelines::{Convention, ShadowPipelines};
use super::stages::VolumeStages;
use crate::Light;
use crate::gpu::common::requirements::check_same;
use crate::gpu::extract::extraction::{self, Extraction};

/// State that volumes and their frames share.
#[derive(Debug)]
pub(super) struct Shared {
    /// The state of the extractor.
    pub(super) source: Arc<extraction::Shared>,
    pub(super) buffers: SizedBuffers,
    /// The caster, and room for what is chosen for it.
    pub(super) table: wgpu::Buffer,
    pub(super) convention: Convention,
    pub(super) encodes: AtomicU64,
}

/// The shadow volumes of one caster, as one [`ShadowVolumes::encode`](crate::gpu::ShadowVolumes::encode) prepared them:
/// for all lights of an extraction and one camera. A later encode of the volumes or of the extractor overwrites what it
/// draws. It is then refused.
#[derive(Clone, Debug)]
pub struct ShadowFrame {
    shared: Arc<Shared>,
    stages: Arc<VolumeStages>,
    extraction: Extraction,
    encode: u64,
}

impl ShadowFrame {
    /// Begins a frame. The buffers of the volumes are overwritten from here on.
    pub(super) fn new(shared: Arc<Shared>, stages: Arc<VolumeStages>, extraction: Extraction) -> Self {
        let encode = shared.encodes.fetch_add(1, Ordering::Relaxed) + 1;
        Self { shared, stages, extraction, encode }
    }

    /// The lights, in the order of the numbers that [`Self::draw`] takes.
    pub fn lights(&self) -> &[Light] {
        self.extraction.lights()
    }

    /// Draws the shadow volume of light number `light` into a pass with the attachments of `pipelines`. It counts up
    /// from the current content of the stencil, in the bits that counts own
    /// ([`ShadowFormat::count_bits`](crate::gpu::ShadowFormat::count_bits)), and leaves the others as they are. Other state of
    /// the pass does not matter. It changes the pipeline and bind groups 0 and 1.
    ///
    /// `pipelines` may differ from those that the volumes were made with, for other attachments, if counting method,
    /// depth and the bits that count are the same.
    ///
    /// # Errors
    /// [`ShadowError`] if the pipelines do not match the volumes, the light was not encoded, or a later encode
    /// overwrites what is drawn. Nothing is drawn then.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &ShadowPipelines,
        light: usize,
    ) -> Result<(), ShadowError> {
        self.extraction.check_current()?;
        if self.shared.encodes.load(Ordering::Relaxed) != self.encode {
            return Err(ShadowError::StaleVolumes);
        }
        let lights = self.lights().len();
        if light >= lights {
            return Err(ShadowError::NoSuchLight { light, lights });
        }
        let devices = [pipelines.shared().device(), self.shared.source.device()];
        check_same(["the pipelines", "the volumes"], devices)?;
        self.shared.convention.check_drawn_by(pipelines.convention)?;
        self.stages.draws(&self.shared.buffers, 0, 0, light).for_each(|draws| draws.draw(pass, pipelines));
        Ok(())
    }
}
