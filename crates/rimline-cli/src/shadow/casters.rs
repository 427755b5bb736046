//! The bodies on the GPU: they throw shadows, receive them and are drawn.

use glam::Vec3;
use rimline::gpu::{Extraction, StageTimer};
use rimline::wgpu;

use super::casting::{CastInputs, put};
use super::covered::CoveredFaces;
use super::depth_shadows::DepthShadows;
use super::extracted::Extracted;
use super::posed_model::PosedModel;
use super::receiver::Receiver;
use super::render_resources::RenderResources;
use super::scene_shadows::SceneShadows;
use super::shadows::{Shadows, VolumePipelines};
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::{GpuError, On as _};
use crate::render::check_model;

/// Resources that draw all bodies and make them cast shadows.
pub(crate) struct Casters<'a> {
    pub(super) resources: &'a RenderResources<'a>,
    pub(crate) shadows: Box<dyn Shadows + 'a>,
    /// A receiver for each body, once it was bound.
    pub(super) receivers: Vec<Receiver>,
    /// Where volumes are shown, the silhouettes of each body by itself: of all its faces, or without covered faces of those
    /// that cast for a light. Each with that light and the number of its body.
    shown: Option<Vec<(Option<usize>, usize, Extracted)>>,
    max_lights: usize,
}

/// Casters whose shadows are drawn with these pipelines.
pub(crate) fn shadows<'a>(
    gpu: &'a Gpu,
    pipelines: &VolumePipelines,
    max_lights: usize,
) -> Result<Box<dyn Shadows + 'a>, GpuError> {
    Ok(match pipelines {
        VolumePipelines::Scene(pipelines, _) => Box::new(SceneShadows::new(gpu, pipelines.counting(), max_lights)?),
        VolumePipelines::Depth(maps, from) => Box::new(DepthShadows::new(gpu, maps, from, max_lights)),
    })
}

impl<'a> Casters<'a> {
    pub(crate) fn new(
        resources: &'a RenderResources<'a>,
        pipelines: &VolumePipelines,
        max_lights: usize,
        shows_volumes: bool,
    ) -> Result<Self, GpuError> {
        let shadows = shadows(resources.factory.gpu, pipelines, max_lights)?;
        let shown = (shows_volumes && !matches!(pipelines, VolumePipelines::Depth(..))).then(Vec::new);
        Ok(Self { resources, shadows, receivers: Vec::new(), shown, max_lights })
    }

    pub(super) fn gpu(&self) -> &'a Gpu {
        self.resources.factory.gpu
    }

    /// Takes the bodies with the faces that they have now.
    pub(crate) fn place(&mut self, bodies: &[PosedModel<'_>]) -> Result<(), Failure> {
        let gpu = self.gpu();
        for body in bodies {
            check_model(gpu, body.faces.len(), body.world.len()).on(gpu)?;
        }
        self.shadows.place(bodies)?;
        let Some(shown) = &mut self.shown else { return Ok(()) };
        for (number, body) in bodies.iter().enumerate() {
            if !shown.get(number).is_some_and(|(.., old)| old.is_of(body)) {
                put(shown, number, (None, number, Extracted::new(gpu, &body.mesh()?, body, self.max_lights)?));
            }
        }
        Ok(())
    }

    /// Leaves out covered faces, for bodies that are placed and stay where they are.
    pub(super) fn leave_out(&mut self, bodies: &[PosedModel<'_>], covered: &CoveredFaces) -> Result<(), Failure> {
        let gpu = self.gpu();
        self.shadows.leave_out(covered).on(gpu)?;
        let Some(shown) = &mut self.shown else { return Ok(()) };
        shown.clear();
        for (number, body) in bodies.iter().enumerate() {
            for light in 0..covered.found.len() {
                if let Some(mesh) = covered.casting(number, body, light)? {
                    shown.push((Some(light), number, Extracted::new(gpu, &mesh, body, self.max_lights)?));
                }
            }
        }
        Ok(())
    }

    pub(super) fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: CastInputs<'_>,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        self.shadows.encode(encoder, inputs, timer)?;
        for (_, number, shown) in self.shown.iter_mut().flatten() {
            if let Some(body) = inputs.bodies.get(*number) {
                shown.encode(encoder, body, inputs.lights, None)?;
            }
        }
        Ok(())
    }

    /// Makes the bodies ready to be drawn in their current pose, and seen from the eye. Encoded commands must have been
    /// submitted.
    pub(super) fn bind(&mut self, bodies: &[PosedModel<'_>], eye: Vec3) -> Result<(), GpuError> {
        let masks = self.shadows.facing(bodies)?;
        let receiver = |(number, (body, masks))| Receiver::new(self.resources, body, number, masks, eye);
        self.receivers = bodies.iter().zip(&masks).enumerate().map(receiver).collect();
        Ok(())
    }

    /// The silhouettes whose volumes are shown for a light.
    pub(super) fn shown(&self, light: usize) -> impl Iterator<Item = &Extraction> {
        let of_light = self.shown.iter().flatten().filter(move |(of, ..)| of.is_none_or(|of| of == light));
        of_light.filter_map(|(.., shown)| shown.extraction.as_ref())
    }
}

pub(crate) struct DrawInputs<'a> {
    pub(crate) casters: &'a Casters<'a>,
    /// Samples of all lights together.
    pub(crate) samples: usize,
    pub(crate) has_ground: bool,
    /// Only one pixel is drawn, so that the device compiles the shaders.
    pub(crate) is_trial: bool,
}

impl DrawInputs<'_> {
    pub(super) fn begin<'e>(&self, mut pass: wgpu::RenderPass<'e>) -> wgpu::RenderPass<'e> {
        if self.is_trial {
            pass.set_scissor_rect(0, 0, 1, 1);
        }
        pass
    }
}
