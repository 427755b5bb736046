//! Compiling shaders before stages are timed. Many drivers compile a shader when it runs first; a triangle makes it run.

use std::path::PathBuf;

use rimline::{Geometry, GeometryOptions, Instance, Light, Model, Origin, ShadowCamera};
use rimline_files::File;

use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::On as _;
use crate::input::{Input, Scene, Shape, resting};
use crate::shadow::casters;
use crate::shadow::casting::CastInputs;
use crate::shadow::posed_model::PosedModel;
use crate::shadow::shadows::VolumePipelines;

const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

fn triangle() -> Option<Model> {
    let geometry = Geometry::new(CORNERS.to_vec(), vec![[0, 1, 2]], GeometryOptions::default()).ok()?;
    Model::new(vec![geometry], vec![Instance::new(0, None)]).ok()
}

/// Runs `work` with a triangle. `is_posed` deforms it on the GPU, as a model is. If no such triangle can be made,
/// nothing fails: then the first run compiles.
pub(crate) fn with_triangle(
    is_posed: bool,
    work: impl FnOnce(&Scene<'_>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let Some((model, pose)) = triangle().zip(resting().ok()) else { return Ok(()) };
    let Ok(mesh) = model.mesh(&pose) else { return Ok(()) };
    let shape = if is_posed { Shape::Posed { model: &model, pose } } else { Shape::World(&CORNERS) };
    work(&Scene { mesh, shape })
}

/// Runs the stages of extraction and shadow volumes with a triangle, and waits for them. Depth maps of the lights have the
/// cameras that they have for the bodies `seen`: one map or six, so that no other stages run than for these.
pub(crate) fn shadow_stages(
    gpu: &Gpu,
    pipelines: &VolumePipelines,
    camera: &ShadowCamera,
    (seen, lights): (&[PosedModel<'_>], &[Light]),
) -> Result<(), Failure> {
    let Some(model) = triangle() else { return Ok(()) };
    let input = Input { file: PathBuf::from("triangle"), content: File::in_world(model, Origin::ZERO) };
    let body = [PosedModel::new(gpu, &input, &[], 0.0, None, true)?];
    let mut shadows = casters::shadows(gpu, pipelines, lights.len()).on(gpu)?;
    shadows.set_bodies(&body)?;
    let mut encoder = gpu.encoder("warm up");
    let inputs = CastInputs { bodies: &body, seen, camera, lights };
    shadows.encode(&mut encoder, inputs, None).on(gpu)?;
    gpu.submit(encoder);
    gpu.wait()
}
