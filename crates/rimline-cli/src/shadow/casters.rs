//! The bodies on the GPU: they throw shadows, receive them and are drawn.

use glam::Vec3;
use rimline::gpu::{Extraction, StageTimer};
use rimline::wgpu;

use super::cast_inputs::{CastInputs, put};
use super::covered::CoveredFaces;
use super::extracted::Extracted;
use super::posed_model::PosedModel;
use super::receiver::Receiver;
use super::shadows::{Shadows, VolumePipelines};
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::GpuError;
use crate::render::check_model;
use crate::render::pipeline_factory::PipelineFactory;

/// Resources that draw all bodies and make them cast shadows.
pub(crate) struct Casters {
    pub(crate) shadows: Shadows,
    /// A receiver for each body, once it was bound.
    pub(super) receivers: Vec<Receiver>,
    /// The silhouettes of each body by itself, where volumes are shown.
    shown: Option<Vec<Extracted>>,
    /// Or, without covered faces, those of the faces that cast: each with its light and the number of its body.
    casting: Option<Vec<(usize, usize, Extracted)>>,
    max_lights: usize,
}

impl Casters {
    pub(crate) fn new(
        gpu: &Gpu,
        pipelines: &VolumePipelines,
        max_lights: usize,
        shows_volumes: bool,
    ) -> Result<Self, GpuError> {
        let shadows = Shadows::new(gpu, pipelines, max_lights)?;
        let shown = (shows_volumes && pipelines.has_mesh_volumes()).then(Vec::new);
        Ok(Self { shadows, receivers: Vec::new(), shown, casting: None, max_lights })
    }

    /// Takes the bodies with the faces that they have now.
    pub(crate) fn place(&mut self, gpu: &Gpu, bodies: &[PosedModel<'_>]) -> Result<(), Failure> {
        for body in bodies {
            check_model(gpu, body.faces.len(), body.world.len()).map_err(|error| error.on(gpu))?;
        }
        self.shadows.place(gpu, bodies)?;
        let Some(shown) = &mut self.shown else { return Ok(()) };
        for (number, body) in bodies.iter().enumerate() {
            if !shown.get(number).is_some_and(|old| old.is_of(body)) {
                put(shown, number, Extracted::new(gpu, body, self.max_lights)?);
            }
        }
        Ok(())
    }

    /// Leaves out covered faces, for bodies that are placed and stay where they are.
    pub(super) fn leave_out(
        &mut self,
        gpu: &Gpu,
        bodies: &[PosedModel<'_>],
        covered: &CoveredFaces,
    ) -> Result<(), Failure> {
        self.shadows.leave_out(covered).map_err(|error| error.on(gpu))?;
        if self.shown.take().is_none() {
            return Ok(());
        }
        let mut casting = Vec::new();
        for (number, body) in bodies.iter().enumerate() {
            for light in 0..covered.found.len() {
                if let Some(mesh) = covered.casting(number, body, light)? {
                    casting.push((light, number, Extracted::of_mesh(gpu, &mesh, body, self.max_lights)?));
                }
            }
        }
        self.casting = Some(casting);
        Ok(())
    }

    /// Records what draws need.
    pub(super) fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        inputs: CastInputs<'_>,
        timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        let CastInputs { bodies, lights, .. } = inputs;
        self.shadows.encode(encoder, inputs, timer)?;
        for (shown, body) in self.shown.iter_mut().flatten().zip(bodies) {
            shown.encode(encoder, body, lights, None)?;
        }
        for (_, number, casting) in self.casting.iter_mut().flatten() {
            if let Some(body) = bodies.get(*number) {
                casting.encode(encoder, body, lights, None)?;
            }
        }
        Ok(())
    }

    /// Makes the bodies ready to be drawn in their current pose, and seen from the eye. Encoded commands must have been
    /// submitted.
    pub(super) fn bind(
        &mut self,
        gpu: &Gpu,
        factory: &PipelineFactory<'_>,
        layout: &wgpu::BindGroupLayout,
        bodies: &[PosedModel<'_>],
        eye: Vec3,
    ) -> Result<(), GpuError> {
        let masks = self.shadows.facing(gpu, bodies)?;
        let receiver = |(number, (body, masks))| Receiver::new(gpu, factory, layout, body, number, masks, eye);
        self.receivers = bodies.iter().zip(&masks).enumerate().map(receiver).collect();
        Ok(())
    }

    /// The silhouettes whose volumes are shown for a light.
    pub(super) fn shown(&self, light: usize) -> impl Iterator<Item = &Extraction> {
        let casting = self.casting.iter().flatten().filter(move |(of, ..)| *of == light).map(|(.., casting)| casting);
        self.shown.iter().flatten().chain(casting).filter_map(|shown| shown.extraction.as_ref())
    }
}
