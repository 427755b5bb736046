//! What one encode of shadow volumes left to draw.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::buffers::Buffers;
use super::draws::DrawGroups;
use super::errors::ShadowDrawError;
use super::pipelines::{Convention, Layouts, ShadowPipelines};
use crate::Light;
use crate::gpu::common::requirements::check_same;
use crate::gpu::extract::extraction::{self, Extraction};

/// What volumes and their frames share.
#[derive(Debug)]
pub(super) struct Shared {
    /// The extractor's.
    pub(super) source: Arc<extraction::Shared>,
    pub(super) buffers: Buffers,
    pub(super) layouts: Layouts,
    pub(super) convention: Convention,
    /// Volumes may end at their lights' ranges.
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

/// The shadow volumes of one caster as one [`ShadowVolumes::encode`](crate::gpu::ShadowVolumes::encode) prepared them, for each light of its
/// extraction and one camera. It is refused once a later encode of the volumes or of the extractor was recorded, which
/// overwrites what it draws from.
#[derive(Clone, Debug)]
pub struct ShadowFrame {
    shared: Arc<Shared>,
    groups: Arc<DrawGroups>,
    extraction: Extraction,
    encode: u64,
}

impl ShadowFrame {
    /// The volumes' buffers are written again from here on.
    pub(super) fn new(shared: Arc<Shared>, groups: Arc<DrawGroups>, extraction: Extraction) -> Self {
        let encode = shared.encodes.fetch_add(1, Ordering::Relaxed) + 1;
        Self { shared, groups, extraction, encode }
    }

    /// The lights, in the order of [`Self::draw`]'s numbers.
    pub fn lights(&self) -> &[Light] {
        self.extraction.lights()
    }

    /// Draws the volume of light `light` into a pass whose attachments are those of `pipelines`. Counts up from whatever the
    /// stencil holds; no other state of the pass matters, and bind groups 0 and 1 and the pipeline are left changed.
    ///
    /// `pipelines` may be others than those that the volumes were made with, for other attachments, as long as they count
    /// alike.
    ///
    /// # Errors
    /// [`ShadowDrawError`] when they do not, for a light that was not encoded, and when a later encode overwrites what is
    /// drawn; nothing is drawn then.
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
        let (ours, theirs) = (self.shared.convention, pipelines.convention);
        if ours.counting != theirs.counting {
            return Err(ShadowDrawError::Counting { volumes: ours.counting, pipelines: theirs.counting });
        }
        if ours.depth != theirs.depth {
            return Err(ShadowDrawError::Depth { volumes: ours.depth, pipelines: theirs.depth });
        }
        if ours.is_unclipped && !theirs.is_unclipped {
            return Err(ShadowDrawError::FarPlane);
        }
        self.groups.draw(pass, pipelines, &self.shared.buffers, light, self.shared.may_end);
        Ok(())
    }
}
