//! Compiling shaders before stages are timed. Many drivers compile a shader when it runs first; a triangle makes it run.

use rimline::gpu::{Extractor, ShadowPipelines, ShadowVolumes};
use rimline::{
    Displacement, Geometry, GeometryOptions, Instance, InstancePose, Light, Mesh, Model, Pose, ShadowCamera, wgpu,
};

use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::GpuError;
use crate::input::{Scene, Shape};
use crate::positions::Positions;
use crate::shadow::caster::{extractor_options, shadow_options};

const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// Runs `work` with a triangle. `is_posed` deforms it on the GPU, as a model is. What the triangle cannot have is no
/// failure: then the first run compiles.
pub(crate) fn with_triangle(
    is_posed: bool,
    work: impl FnOnce(&Scene<'_>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let identity = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let made = || -> Option<(Model, Pose)> {
        let geometry = Geometry::new(CORNERS.to_vec(), vec![[0, 1, 2]], GeometryOptions::default()).ok()?;
        let model = Model::new(vec![geometry], vec![Instance::new(0, None)]).ok()?;
        Some((model, Pose::new(vec![InstancePose::new(vec![identity], Vec::new()).ok()?])))
    };
    let Some((model, pose)) = made() else { return Ok(()) };
    let Ok(mesh) = model.mesh(&pose) else { return Ok(()) };
    let shape = if is_posed { Shape::Posed { model: &model, pose } } else { Shape::World(&CORNERS) };
    work(&Scene { mesh, shape })
}

/// Runs the stages of extraction and shadow volumes with a triangle, and waits for them.
pub(crate) fn shadow_stages(
    gpu: &Gpu,
    pipelines: &ShadowPipelines,
    camera: &ShadowCamera,
    lights: &[Light],
) -> Result<(), Failure> {
    with_triangle(false, |scene| {
        let record = |mesh: &Mesh| -> Result<(), GpuError> {
            let positions = Positions::new(gpu, &scene.shape, None::<&Displacement>)?;
            let mut extractor = Extractor::new(&gpu.pipelines, mesh, extractor_options(lights.len()))?;
            let mut volumes = ShadowVolumes::new(pipelines, &extractor, shadow_options())?;
            let label = Some("warm up");
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label });
            let extraction = extractor.encode(&mut encoder, positions.buffer(), lights, None)?;
            volumes.encode(&mut encoder, &extraction, camera, None)?;
            gpu.queue.submit([encoder.finish()]);
            Ok(())
        };
        record(&scene.mesh).map_err(|error| error.on(gpu))?;
        gpu.wait()
    })
}
