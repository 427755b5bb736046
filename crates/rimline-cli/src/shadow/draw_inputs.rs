//! The bodies and overlays of a picture, for its passes.

use rimline::wgpu;
use rimline_picture::{Subject, Surface};

use super::casters::Casters;
use super::overlay::Overlay;
use super::shadows::VolumePipelines;
use crate::gpu_error::GpuError;

/// Bodies as they were encoded, with their shadows and what is drawn over them.
#[derive(Clone, Copy)]
pub(crate) struct DrawInputs<'a> {
    pub(crate) casters: &'a Casters<'a>,
    /// The pipelines of the shadow volumes, and the overlay over the light. `None`: not known yet.
    pub(super) drawn: Option<(&'a VolumePipelines, Option<&'a Overlay>)>,
    /// Samples of all lights together.
    pub(crate) samples: usize,
    pub(crate) has_ground: bool,
    /// Only one pixel is drawn, so that the device compiles the shaders.
    pub(crate) is_trial: bool,
}

impl Subject for DrawInputs<'_> {
    type Error = GpuError;

    fn lights(&self) -> usize {
        self.samples
    }

    fn has_ground(&self) -> bool {
        self.has_ground
    }

    fn surfaces(&self) -> &[Surface] {
        &self.casters.surfaces
    }

    fn draw_volumes(&self, pass: &mut wgpu::RenderPass<'_>, light: usize) -> Result<(), GpuError> {
        self.drawn.map_or(Ok(()), |(pipelines, _)| self.casters.shadows.draw(pass, pipelines, light))
    }

    fn has_overlays(&self) -> bool {
        self.drawn.is_some_and(|(_, overlay)| overlay.is_some())
    }

    fn draw_overlays(&self, pass: &mut wgpu::RenderPass<'_>) -> Result<(), GpuError> {
        self.drawn
            .and_then(|(_, overlay)| overlay)
            .map_or(Ok(()), |overlay| overlay.draw(pass, self.casters, self.samples))
    }

    fn begin<'e>(&self, mut pass: wgpu::RenderPass<'e>) -> wgpu::RenderPass<'e> {
        if self.is_trial {
            pass.set_scissor_rect(0, 0, 1, 1);
        }
        pass
    }
}
