//! Shadows from depth maps of the lights: those that the command draws itself, `--from-depth`, or one that the caller made,
//! `--depth`.

use std::sync::Arc;

use rimline::gpu::StageTimer;
use rimline::gpu::depth_map::{DepthMapPipelines, MeshDepth};
use rimline::internals::layout::ShadowStatistics;
use rimline::{Counting, DepthDirection, Origin, ShadowCamera, wgpu};

use super::casting::{CastInputs, FacingMasks, put};
use super::extracted::Extracted;
use super::from_depth::{DepthsFound, FromDepth, MAP, MapSource, points};
use super::light_depths::LightMaps;
use super::light_maps::LightCameras;
use super::posed_model::PosedModel;
use super::shadows::{Choice, Found, Shadows, VolumePipelines};
use super::shown_maps::ShownDepths;
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::{GpuError, On as _};
use crate::npz::DepthMapArrays;

pub(crate) struct DepthShadows {
    pipelines: Arc<DepthMapPipelines>,
    from: FromDepth,
    max_lights: usize,
    files: Vec<File>,
    /// Maps of each light, from the first encode on.
    lights: Vec<LightMaps>,
}

/// The triangles of a file.
struct File {
    /// Where the command draws the maps.
    depth: Option<MeshDepth>,
    /// Which of them are turned to the lights.
    surface: Extracted,
}

impl DepthShadows {
    pub(super) fn new(pipelines: &Arc<DepthMapPipelines>, from: &FromDepth, max_lights: usize) -> Self {
        let (files, lights) = (Vec::new(), Vec::new());
        Self { pipelines: Arc::clone(pipelines), from: from.clone(), max_lights, files, lights }
    }
}

impl Shadows for DepthShadows {
    fn place(&mut self, gpu: &Gpu, bodies: &[PosedModel<'_>]) -> Result<(), Failure> {
        for (number, body) in bodies.iter().enumerate() {
            if self.files.get(number).is_some_and(|file| file.surface.is_of(body)) {
                continue;
            }
            let mesh = body.triangles()?.map_or_else(|| body.mesh(), Ok)?;
            let depth = || MeshDepth::new(&gpu.pipelines, &mesh, MAP, DepthDirection::Reversed);
            let depth = matches!(self.from.source, MapSource::Drawn { .. }).then(depth).transpose().on(gpu)?;
            let surface = Extracted::new(gpu, &mesh, body, self.max_lights)?;
            put(&mut self.files, number, File { depth, surface });
        }
        Ok(())
    }

    fn encode(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        CastInputs { gpu, bodies, seen, camera, lights }: CastInputs<'_>,
        mut timer: Option<&mut StageTimer>,
    ) -> Result<(), GpuError> {
        for (file, body) in self.files.iter_mut().zip(bodies) {
            file.surface.encode(encoder, body, lights, timer.as_deref_mut())?;
        }
        let points = points(seen);
        let Self { pipelines, from, files, lights: made, .. } = self;
        for (number, light) in lights.iter().enumerate() {
            let cameras = match &from.source {
                MapSource::Drawn { side } => LightCameras::new(light, &points, *side)?,
                MapSource::Given(map) => map.cameras.clone(),
            };
            if !made.get(number).is_some_and(|maps| maps.fits(&cameras)) {
                let maps = LightMaps::new(gpu, pipelines, from, &cameras).map_err(|error| from.failed(error))?;
                put(made, number, maps);
            }
            let Some(maps) = made.get_mut(number) else { continue };
            if let MapSource::Drawn { .. } = from.source {
                for (view, eye) in maps.views.iter().zip(cameras.all()) {
                    draw_map(encoder, (view, eye), files, bodies, timer.as_deref_mut())?;
                }
            }
            let found = maps.find(gpu, encoder, &cameras, camera, timer.as_deref_mut());
            found.map_err(|error| from.failed(error))?;
        }
        made.truncate(lights.len());
        Ok(())
    }

    fn draw(&self, pass: &mut wgpu::RenderPass<'_>, pipelines: &VolumePipelines, light: usize) -> Result<(), GpuError> {
        let VolumePipelines::Depth(own, _) = pipelines else { return Err(pipelines.refuse(Counting::Auto)) };
        let frame = self.lights.get(light).and_then(|maps| maps.frame.as_ref());
        Ok(frame.map_or(Ok(()), |frame| frame.draw(pass, own))?)
    }

    fn facing(&self, _: &Gpu, bodies: &[PosedModel<'_>]) -> Result<Vec<FacingMasks>, GpuError> {
        Ok(self.files.iter().zip(bodies).map(|(file, body)| file.surface.facing(body)).collect())
    }

    fn found(&self, gpu: &Gpu) -> Result<Vec<Found>, GpuError> {
        let of_file = |file: &File| {
            let (silhouettes, extraction) = file.surface.found(gpu, self.max_lights)?;
            let lights = vec![Choice { casting: "depth map", counting: "parity" }; self.max_lights];
            Ok(Found { lights, silhouettes, extraction, shadow: self.statistics(gpu)?, is_whole: true })
        };
        self.files.iter().map(of_file).collect()
    }

    /// No volume of a mesh, and a count of 0 or 1.
    fn statistics(&self, _: &Gpu) -> Result<ShadowStatistics, GpuError> {
        Ok(ShadowStatistics { count_bound: 1, ..bytemuck::Zeroable::zeroed() })
    }

    fn depths_found(&self, gpu: &Gpu) -> Result<Option<DepthsFound>, GpuError> {
        let lights = self.lights.iter().map(|maps| maps.found(gpu)).collect::<Result<_, _>>()?;
        Ok(Some(DepthsFound { size: self.from.size(), has_walls: self.from.has_walls(), lights }))
    }

    fn shown_maps(&self, light: usize) -> Option<ShownDepths<'_>> {
        self.lights.get(light).and_then(LightMaps::shown)
    }

    fn saved_maps(&self, gpu: &Gpu, light: usize, origin: Origin) -> Result<Option<DepthMapArrays>, GpuError> {
        self.lights.get(light).map(|maps| maps.saved(gpu, origin)).transpose()
    }
}

/// Draws all files as a light sees them.
fn draw_map(
    encoder: &mut wgpu::CommandEncoder,
    (view, eye): (&wgpu::TextureView, &ShadowCamera),
    files: &[File],
    bodies: &[PosedModel<'_>],
    timer: Option<&mut StageTimer>,
) -> Result<(), GpuError> {
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store };
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("depth map"),
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(ops),
            stencil_ops: None,
        }),
        timestamp_writes: timer.and_then(|timer| timer.render_pass("mesh_depth")),
        ..Default::default()
    });
    for (file, body) in files.iter().zip(bodies) {
        if let Some(depth) = &file.depth {
            depth.draw(&mut pass, body.positions.buffer(), eye)?;
        }
    }
    Ok(())
}
