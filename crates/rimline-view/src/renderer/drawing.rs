//! The passes of a picture.

use rimline::gpu::{SceneFrame, ShadowPipelines};
use rimline_picture::{Resources, Subject, Surface};

use super::error::RenderError;
use super::models::Models;
use super::overlays::Overlays;
use super::pipelines::Pipelines;
use crate::state::options::Overlays as ShownOverlays;

/// Models, lights and overlays as they were encoded.
pub(super) struct Drawing<'a> {
    pub(super) resources: &'a Resources,
    pub(super) pipelines: &'a Pipelines,
    pub(super) models: &'a Models,
    pub(super) frame: Option<&'a SceneFrame>,
    /// Draws the shadows, if there are any.
    pub(super) shadows: Option<&'a ShadowPipelines>,
    pub(super) overlays: Option<&'a Overlays>,
    pub(super) shown: ShownOverlays,
    pub(super) has_ground: bool,
    /// For each light that is on the number of its first point that shines, among those of all, and its own.
    pub(super) firsts: Vec<[usize; 2]>,
}

impl<'a> Drawing<'a> {
    /// The surfaces that shadows fall on, without shadows.
    pub(super) fn of_receivers(
        resources: &'a Resources,
        pipelines: &'a Pipelines,
        models: &'a Models,
        has_ground: bool,
    ) -> Self {
        let (frame, shadows, overlays, shown, firsts) = (None, None, None, ShownOverlays::default(), Vec::new());
        Self { resources, pipelines, models, frame, shadows, overlays, shown, has_ground, firsts }
    }
}

impl Subject for Drawing<'_> {
    type Error = RenderError;

    fn lights(&self) -> usize {
        self.models.lights.len()
    }

    fn has_ground(&self) -> bool {
        self.has_ground
    }

    fn surfaces(&self) -> &[Surface] {
        &self.models.surfaces
    }

    fn draw_volumes(&self, pass: &mut wgpu::RenderPass<'_>, light: usize) -> Result<(), RenderError> {
        let (Some(frame), Some(shadows)) = (self.frame, self.shadows) else { return Ok(()) };
        Ok(frame.draw(pass, shadows, 0, self.models.lights[light])?)
    }

    fn has_overlays(&self) -> bool {
        self.shown.caps || self.shown.volumes
    }

    fn draw_overlays(&self, pass: &mut wgpu::RenderPass<'_>) -> Result<(), RenderError> {
        for &[light, number] in &self.firsts {
            if self.shown.caps {
                self.resources.select(pass, light);
                pass.set_pipeline(&self.pipelines.caps);
                self.surfaces().iter().for_each(|surface| surface.draw(pass, light));
            }
            if let Some(overlays) = self.overlays.filter(|_| self.shown.volumes) {
                overlays.draw_volumes(pass, &self.pipelines.volumes, self.resources, [light, number])?;
            }
        }
        Ok(())
    }
}
