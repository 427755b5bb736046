//! Casters whose faces lie over each other more often than the stencil counts: they are drawn in batches of few layers,
//! each of which darkens what it covers before the next is counted.

mod deepest;

use std::sync::OnceLock;

use rimline::gpu::{
    Caster, FrameInputs, LightHandle, Pipelines, Scene, SceneFrame, SceneOptions, ShadowError, ShadowFormat,
    ShadowPipelines, StencilCounts,
};
use rimline::{Counting, Light, ShadowCamera, wgpu};
use rimline_picture::{COMMON, PipelineDescriptor, depth_state};

use super::casting::{CastInputs, PosedModel, set_lights};
use crate::device::{Gpu, GpuError, On as _};
use crate::failure::Failure;

/// The most that the stencil counts to; 256 looks like 0.
const MOST: u32 = 255;

pub(super) struct Layers {
    /// At most so many faces lie over each other, if the stencil counts them.
    pub(super) most: Option<u32>,
    /// More may lie over each other, so they are drawn in batches.
    batches: Vec<Batch>,
}

struct Batch {
    scene: Scene,
    lights: Vec<LightHandle>,
    frame: Option<SceneFrame>,
}

impl Layers {
    /// Counts what lies over each other for these lights, and makes batches for up to `max_lights` at a time where the
    /// stencil would not do. They are to be encoded before they are drawn. `None` if no reasonable number of batches
    /// would do.
    pub(super) fn new(
        gpu: &Gpu,
        bodies: &[PosedModel<'_>],
        counting: Counting,
        max_lights: usize,
        lights: &[Light],
    ) -> Result<Option<Self>, Failure> {
        let mut positions: Vec<[f32; 3]> = Vec::new();
        let mut faces: Vec<[u32; 3]> = Vec::new();
        for body in bodies {
            let first = positions.len() as u32;
            positions.extend(&body.world);
            faces.extend(body.faces.iter().map(|face| face.map(|v| first + v)));
        }
        let found: Vec<u32> = lights.iter().map(|&light| deepest::deepest(light, &positions, &faces, MOST)).collect();
        let deep = lights.iter().zip(&found).filter(|(_, found)| **found > MOST);
        let deep: Vec<Light> = deep.map(|(&light, _)| light).collect();
        if deep.is_empty() {
            return Ok(Some(Self { most: found.into_iter().max(), batches: Vec::new() }));
        }
        // The others are counted in the same batches.
        let Some(found) = deepest::batches(&deep, &positions, &faces, MOST_OF_BATCH) else { return Ok(None) };
        let batch = |faces: &Vec<u32>| Batch::new(gpu, bodies, counting, max_lights, faces);
        Ok(Some(Self { most: None, batches: found.iter().map(batch).collect::<Result<_, _>>()? }))
    }

    pub(super) fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        CastInputs { camera, lights, .. }: &CastInputs<'_>,
    ) -> Result<(), GpuError> {
        self.batches.iter_mut().try_for_each(|batch| batch.encode(encoder, camera, lights))
    }

    /// Draws the batches of a light, if there are any. Returns whether there are.
    pub(super) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipelines: &BatchPipelines,
        light: usize,
    ) -> Result<bool, GpuError> {
        if self.batches.is_empty() {
            return Ok(false);
        }
        let (counting, resolve) = pipelines.get()?;
        for (number, batch) in self.batches.iter().enumerate() {
            if number > 0 {
                // Where a count is not 0, sets the dark bit, and the count to 0.
                pass.set_pipeline(resolve);
                pass.set_stencil_reference(MOST_OF_BATCH + 1);
                pass.draw(0..3, 0..1);
                pass.set_stencil_reference(0);
            }
            let frame = batch.frame.as_ref().ok_or(ShadowError::NotEncoded)?;
            let handle = *batch.lights.get(light).ok_or(ShadowError::NotEncoded)?;
            frame.draw(pass, counting, 0, handle)?;
        }
        Ok(true)
    }
}

impl Batch {
    /// Faces of all bodies, by their numbers: a caster for each body.
    fn new(
        gpu: &Gpu,
        bodies: &[PosedModel<'_>],
        counting: Counting,
        max_lights: usize,
        faces: &[u32],
    ) -> Result<Self, Failure> {
        let stencil = StencilCounts { count_bits: COUNT_BITS, ..StencilCounts::default() };
        let options = SceneOptions { max_lights, counting, stencil, ..SceneOptions::default() };
        let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).on(gpu)?;
        let mut faces = faces.to_vec();
        faces.sort_unstable();
        let (mut first, mut rest) = (0, faces.as_slice());
        for body in bodies {
            let end = first + body.faces.len() as u32;
            let (of_body, others) = rest.split_at(rest.partition_point(|&face| face < end));
            let corners = of_body.iter().map(|&face| body.faces[(face - first) as usize]).collect();
            (first, rest) = (end, others);
            let Some(mesh) = body.part(corners)? else { continue };
            let mesh = scene.add_mesh(&mesh, &body.world).on(gpu)?;
            scene.insert(Caster::in_buffer(mesh, body.positions.buffer())).on(gpu)?;
        }
        Ok(Self { scene, lights: Vec::new(), frame: None })
    }

    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        camera: &ShadowCamera,
        lights: &[Light],
    ) -> Result<(), GpuError> {
        set_lights(&mut self.scene, &mut self.lights, lights)?;
        self.frame = Some(self.scene.encode(encoder, FrameInputs::new(&[(*camera).into()]))?);
        Ok(())
    }
}

const COUNT_BITS: u32 = 7;
const MOST_OF_BATCH: u32 = (1 << COUNT_BITS) - 1;

/// Pipelines of batches: they count volumes, and turn counts into the dark bit, which says that an earlier batch casts a
/// shadow. Made when they are first needed, since most pictures need none.
pub(crate) struct BatchPipelines {
    pipelines: Pipelines,
    format: ShadowFormat,
    counting: Counting,
    made: OnceLock<Box<(ShadowPipelines, wgpu::RenderPipeline)>>,
}

impl BatchPipelines {
    pub(crate) fn new(pipelines: &Pipelines, format: &ShadowFormat, counting: Counting) -> Self {
        let format = ShadowFormat { count_bits: COUNT_BITS, ..format.clone() };
        Self { pipelines: pipelines.clone(), format, counting, made: OnceLock::new() }
    }

    fn get(&self) -> Result<&(ShadowPipelines, wgpu::RenderPipeline), GpuError> {
        if let Some(made) = self.made.get() {
            return Ok(made);
        }
        let counting = ShadowPipelines::new(&self.pipelines, &self.format, self.counting)?;
        let made = Box::new((counting, resolve(self.pipelines.device(), &self.format)));
        Ok(self.made.get_or_init(|| made))
    }
}

fn resolve(device: &wgpu::Device, format: &ShadowFormat) -> wgpu::RenderPipeline {
    // The reference is the dark bit, which `read_mask` leaves out, so the comparison is of the count with 0.
    let face = wgpu::StencilFaceState {
        compare: wgpu::CompareFunction::NotEqual,
        pass_op: wgpu::StencilOperation::Replace,
        ..wgpu::StencilFaceState::IGNORE
    };
    let mut depth = depth_state(format.depth_stencil, false, wgpu::CompareFunction::Always, face);
    depth.stencil.read_mask = MOST_OF_BATCH;
    let descriptor = PipelineDescriptor {
        samples: format.samples,
        depth: Some(depth),
        ..PipelineDescriptor::over("resolve", "@fragment fn resolve_fragment() {}", &[], None)
    };
    descriptor.pipeline(device, COMMON, None)
}
