//! The bodies on the GPU: they throw shadows, receive them and are drawn.

use std::borrow::Cow;

use glam::Vec3;
use rimline::gpu::{Extraction, StageTimer};
use rimline::wgpu;
use rimline_picture::{FacingMasks, OPPOSITE, Surface, SurfaceBuffers, TURNED, corner_normals};

use super::casting::{CastInputs, Extracted, Occlusion, PosedModel, put};
use super::depth_shadows::DepthShadows;
use super::scene_shadows::SceneShadows;
use super::shadows::{RenderResources, Shadows, VolumePipelines};
use crate::coincident::{Coincident, corners};
use crate::device::{Gpu, GpuError, On as _};
use crate::failure::Failure;
use crate::image::check_model;

/// Resources that draw all bodies and make them cast shadows.
pub(crate) struct Casters<'a> {
    pub(super) resources: &'a RenderResources<'a>,
    pub(crate) shadows: Box<dyn Shadows + 'a>,
    /// The surface of each body, once it was bound.
    pub(super) surfaces: Vec<Surface>,
    /// Where volumes are shown, the silhouettes of each body by itself.
    shown: Option<Vec<Shown>>,
    max_lights: usize,
}

/// Silhouettes of a body whose volumes are shown.
struct Shown {
    /// The light for which they are without occluded faces. `None`: they are of all faces, for all lights.
    light: Option<usize>,
    /// The number of the body.
    body: usize,
    extracted: Extracted,
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
        let shadows = shadows(resources.gpu, pipelines, max_lights)?;
        let shown = (shows_volumes && !matches!(pipelines, VolumePipelines::Depth(..))).then(Vec::new);
        Ok(Self { resources, shadows, surfaces: Vec::new(), shown, max_lights })
    }

    pub(super) fn gpu(&self) -> &'a Gpu {
        self.resources.gpu
    }

    /// Takes the bodies with the faces that they have now.
    pub(crate) fn set_bodies(&mut self, bodies: &[PosedModel<'_>]) -> Result<(), Failure> {
        let gpu = self.gpu();
        for body in bodies {
            check_model(gpu, body.faces.len(), body.world.len()).on(gpu)?;
        }
        self.shadows.set_bodies(bodies)?;
        let Some(shown) = &mut self.shown else { return Ok(()) };
        for (number, body) in bodies.iter().enumerate() {
            if !shown.get(number).is_some_and(|old| old.extracted.is_of(body)) {
                let extracted = Extracted::new(gpu, &body.mesh()?, body, self.max_lights)?;
                put(shown, number, Shown { light: None, body: number, extracted });
            }
        }
        Ok(())
    }

    /// Leaves out occluded faces, for bodies that are placed and stay where they are.
    pub(super) fn leave_out(&mut self, bodies: &[PosedModel<'_>], occlusion: &Occlusion) -> Result<(), Failure> {
        let gpu = self.gpu();
        self.shadows.leave_out(occlusion).on(gpu)?;
        let Some(shown) = &mut self.shown else { return Ok(()) };
        shown.clear();
        for (number, body) in bodies.iter().enumerate() {
            for light in 0..occlusion.found.len() {
                if let Some(mesh) = occlusion.casting(bodies, number, light)? {
                    let extracted = Extracted::new(gpu, &mesh, body, self.max_lights)?;
                    shown.push(Shown { light: Some(light), body: number, extracted });
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
        for shown in self.shown.iter_mut().flatten() {
            if let Some(body) = inputs.bodies.get(shown.body) {
                shown.extracted.encode(encoder, body, inputs.lights, None)?;
            }
        }
        Ok(())
    }

    /// Makes the bodies ready to be drawn in their current pose, and seen from the eye. Encoded commands must have been
    /// submitted.
    pub(super) fn bind(&mut self, bodies: &[PosedModel<'_>], eye: Vec3) -> Result<(), GpuError> {
        let masks = self.shadows.facing(bodies)?;
        let surface = |(number, (body, masks))| surface(self.resources, body, number, masks, eye);
        self.surfaces = bodies.iter().zip(&masks).enumerate().map(surface).collect();
        Ok(())
    }

    /// The silhouettes whose volumes are shown for a light.
    pub(super) fn shown(&self, light: usize) -> impl Iterator<Item = &Extraction> {
        let of_light = self.shown.iter().flatten().filter(move |shown| shown.light.is_none_or(|of| of == light));
        of_light.filter_map(|shown| shown.extracted.extraction.as_ref())
    }
}

/// The surface of the body with this number, as it is seen from the eye.
fn surface(
    resources: &RenderResources<'_>,
    body: &PosedModel<'_>,
    number: usize,
    masks: &FacingMasks,
    eye: Vec3,
) -> Surface {
    let stored = |label, contents: &[u8]| resources.shared.factory.buffer(label, contents);
    let faces = stored("drawn faces", bytemuck::cast_slice(&body.faces));
    let Corners { normals, colors, slots } = Corners::of(body, masks, eye);
    let colors = body.colors.is_some().then(|| stored("colors", bytemuck::cast_slice(&colors)));
    let normals = stored("normals", bytemuck::cast_slice(&normals));
    let slots = stored("slots", bytemuck::cast_slice(&slots));
    let positions = body.positions.buffer().buffer;
    let buffers =
        SurfaceBuffers { positions, faces: &faces, normals: &normals, slots: &slots, colors: colors.as_ref() };
    Surface::new(&resources.shared, number, buffers, masks)
}

/// Normals and colours of corners, and where faces' masks are. Faces that are turned away from the eye have those of
/// the faces that they coincide with. All are drawn: shadow volumes end at some of them, and their depths are not the
/// others' to the last bit.
struct Corners<'a> {
    normals: Vec<u32>,
    colors: Cow<'a, [u32]>,
    slots: Cow<'a, [u32]>,
}

impl<'a> Corners<'a> {
    fn of(body: &'a PosedModel<'_>, masks: &'a FacingMasks, eye: Vec3) -> Self {
        let all = || corners(&body.world, &body.faces).enumerate();
        let (mut colors, mut slots) =
            (Cow::Borrowed(body.colors.as_deref().unwrap_or_default().as_flattened()), Cow::Borrowed(&*masks.slots));
        let Some(found) = Coincident::of(corners(&body.world, &body.faces)) else {
            return Self { normals: corner_normals(&body.world, &body.faces), colors, slots };
        };
        let fronts: Vec<Option<usize>> = all().map(|(number, face)| found.seen_instead(number, face, eye)).collect();
        // The second side of a sheet does not smooth the folds of the first.
        let one_sided = body.faces.iter().zip(&fronts);
        let one_sided: Vec<[u32; 3]> =
            one_sided.map(|(&face, front)| if front.is_none() { face } else { [face[0]; 3] }).collect();
        let mut normals = corner_normals(&body.world, &one_sided);
        let run_of = |face: usize| masks.runs.iter().position(|(faces, _)| faces.contains(&(face as u32)));
        for (number, front) in fronts.into_iter().enumerate() {
            let Some(front) = front else { continue };
            let position = |corner: u32| body.world[corner as usize].map(|c| c + 0.0);
            let [corners, other] = [number, front].map(|face| body.faces[face].map(position));
            for (corner, at) in corners.into_iter().enumerate() {
                let same = other.iter().position(|&there| there == at).unwrap_or(corner);
                normals[3 * number + corner] = normals[3 * front + same];
                if !colors.is_empty() {
                    colors.to_mut()[3 * number + corner] = colors[3 * front + same];
                }
            }
            let is_near = run_of(front) == run_of(number);
            let shown = if is_near { masks.slots[front] } else { masks.slots[number] | OPPOSITE };
            slots.to_mut()[number] = shown | TURNED;
        }
        Self { normals, colors, slots }
    }
}
