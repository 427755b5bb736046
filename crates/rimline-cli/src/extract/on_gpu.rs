//! The stages on a GPU, and their results read back for the file.

use std::borrow::Cow;
use std::time::Instant;

use rimline::gpu::{Extractor, ExtractorOptions, StageTimer};
use rimline::internals::Method;
use rimline::internals::cpu::FacingStatistics;
use rimline::internals::layout::ExtractionStatistics;
use rimline::{Predicate, wgpu};

use super::{Found, Job, rows_of_polygons};
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::{GpuError, On as _};
use crate::input::{Scene, Shape};
use crate::posed_input::Positions;
use crate::report::Times;
use crate::warm_up::with_triangle;

impl<'s> Job<'_, 's> {
    /// `is_warm` compiles the shaders before the stages run and are timed, once it is known that the model fits.
    pub(super) fn on_gpu(&self, gpu: &Gpu, times: &mut Times, is_warm: bool) -> Result<Found<'s>, Failure> {
        let Gpu { device, queue, .. } = gpu;
        let (placed, mut extractors) = times.measure("prepare", || self.prepare(gpu)).on(gpu)?;
        gpu.check()?;
        if is_warm {
            let warm_up = |scene: &Scene<'_>| {
                let job = Job { scene, ..*self };
                job.on_gpu(gpu, &mut Times::default(), false).map(drop)
            };
            let is_posed = matches!(self.scene.shape, Shape::Posed { .. });
            times.measure("compile", || with_triangle(is_posed, warm_up))?;
        }

        let mut timer = StageTimer::new(device, queue);
        let mut encoder = gpu.encoder("extract");
        placed.encode(&mut encoder, &self.scene.shape, self.time_s, timer.as_mut()).on(gpu)?;
        for extractor in &mut extractors {
            extractor.encode_timed(&mut encoder, placed.buffer(), self.lights, timer.as_mut()).on(gpu)?;
        }
        if let Some(timer) = &timer {
            timer.resolve(&mut encoder);
        }
        let commands = encoder.finish();
        let begin = Instant::now();
        queue.submit([commands]);
        gpu.wait()?;
        times.add_stages(gpu, timer.as_ref(), begin.elapsed().as_secs_f64() * 1e3).on(gpu)?;
        let found = times.measure("read", || self.read(gpu, &placed, &extractors)).on(gpu)?;
        gpu.check()?;
        Ok(found)
    }

    fn prepare(&self, gpu: &Gpu) -> Result<(Positions, Vec<Extractor>), GpuError> {
        let placed = Positions::new(gpu, &self.scene.shape, self.displacement)?;
        // The per-edge method has no face bits, so the file gets the exact ones, from a face pass of their own.
        let methods = match self.method {
            Method::FaceMask => vec![(Method::FaceMask, self.predicate, true)],
            Method::PerEdge => {
                vec![(Method::FaceMask, Predicate::Exact, false), (Method::PerEdge, self.predicate, true)]
            }
        };
        let mut extractors = Vec::new();
        for (method, predicate, masks) in methods {
            let (max_lights, lists) = (self.lights.len(), None);
            let options =
                ExtractorOptions { max_lights, method, predicate, masks, lists, ..ExtractorOptions::default() };
            extractors.push(Extractor::new(&gpu.pipelines, &self.scene.mesh, options)?);
        }
        Ok((placed, extractors))
    }

    fn read(&self, gpu: &Gpu, placed: &Positions, extractors: &[Extractor]) -> Result<Found<'s>, GpuError> {
        let positions = match &self.scene.shape {
            Shape::World(positions) => Cow::Borrowed(*positions),
            Shape::Posed { .. } => Cow::Owned(placed.read(gpu, self.scene.mesh.vertex_count() as usize)?),
        };
        let mesh = &self.scene.mesh;
        let (first, last) = (&extractors[0], &extractors[extractors.len() - 1]);
        let ExtractionStatistics { non_finite_faces, undecided_pairs, exact_zeros, .. } =
            gpu.read_first(first.results().statistics)?;
        let triangles = mesh.faces().len();
        let (facing, twisted) = match mesh.polygons() {
            None => (read_planes(gpu, first.results().facing, triangles)?, Vec::new()),
            Some(polygons) => {
                let planes: Vec<u32> = read_planes(gpu, first.results().facing, 2 * triangles)?;
                let rows = |planes: &[u32]| rows_of_polygons(polygons, planes, 2 * triangles, self.lights.len());
                (rows(&planes), rows(planes.get(triangles..).unwrap_or_default()))
            }
        };
        Ok(Found {
            positions,
            facing,
            twisted,
            masks: read_planes(gpu, last.results().masks, mesh.edges().len())?,
            statistics: FacingStatistics { non_finite_faces, undecided_pairs, exact_zeros },
        })
    }
}

fn read_planes<T: bytemuck::Pod>(gpu: &Gpu, buffers: &[wgpu::Buffer], items: usize) -> Result<Vec<T>, GpuError> {
    let mut all = Vec::new();
    for buffer in buffers {
        // A buffer may be longer than what it holds.
        let mut plane: Vec<T> = gpu.read(buffer)?;
        plane.truncate(items);
        if all.is_empty() {
            all = plane;
        } else {
            all.append(&mut plane);
        }
    }
    Ok(all)
}
