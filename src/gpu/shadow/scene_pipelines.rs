//! Render pipelines that count the shadow volumes of scenes.

use super::format::{ShadowFormat, ShadowFormatError};
use super::pipelines::ShadowPipelines;
use crate::gpu::common::pipelines::Pipelines;
use crate::shadow::Counting;

/// The render pipelines that draw the volumes of a [`Scene`](crate::gpu::Scene), for one counting method and one
/// [`ShadowFormat`]. Scenes share them.
#[derive(Debug)]
pub struct ScenePipelines(pub(crate) ShadowPipelines);

impl ScenePipelines {
    /// Makes the pipelines. `pipelines` is the caller's device, or the [`Pipelines`] that the scenes share. `counting` is
    /// that of the scenes; see [`SceneOptions`](crate::gpu::SceneOptions).
    ///
    /// # Errors
    /// [`ShadowFormatError`] if the device lacks what shadow volumes need, or cannot draw into the attachments.
    pub fn new(
        pipelines: impl Into<Pipelines>,
        format: &ShadowFormat,
        counting: Counting,
    ) -> Result<Self, ShadowFormatError> {
        ShadowPipelines::make(pipelines.into(), format, counting, true).map(Self)
    }

    /// The counting method of these pipelines.
    pub fn counting(&self) -> Counting {
        self.0.counting()
    }
}
