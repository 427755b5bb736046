//! The query on a GPU, a slice of the points at a time.

use rimline::gpu::{PositionBuffer, ShadowQuery, ShadowQueryOptions, read_back_vec};
use rimline::{Displacement, Light, wgpu};

use super::slice;
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::GpuError;
use crate::input::{Scene, Shape};
use crate::positions::Positions;
use crate::times::Times;
use crate::warm_up::with_triangle;

/// One query.
pub(super) struct Job<'a, 's> {
    pub(super) scene: &'a Scene<'s>,
    pub(super) points: &'a [[f32; 3]],
    pub(super) lights: &'a [Light],
    pub(super) displacement: Option<&'a Displacement>,
    pub(super) time_s: f32,
}

impl Job<'_, '_> {
    /// Compiles the shaders before the stages run and are timed.
    pub(super) fn run_warm(&self, gpu: &Gpu, depths: &mut Vec<i32>, times: &mut Times) -> Result<(), Failure> {
        let is_posed = matches!(self.scene.shape, Shape::Posed { .. });
        let Self { lights, displacement, time_s, .. } = *self;
        times.measure("compile", || {
            with_triangle(is_posed, |scene| {
                let job = Job { scene, points: &[[0.0; 3]], lights, displacement, time_s };
                job.run(gpu, &mut Vec::new(), &mut Times::default())
            })
        })?;
        self.run(gpu, depths, times)
    }

    pub(super) fn run(&self, gpu: &Gpu, depths: &mut Vec<i32>, times: &mut Times) -> Result<(), Failure> {
        let fail = |error: GpuError| error.on(gpu);
        let slice = slice(&self.scene.mesh, self.lights.len()).min(self.points.len());
        let (placed, mut query, points) = times
            .measure("prepare", || -> Result<_, GpuError> {
                let placed = Positions::new(gpu, &self.scene.shape, self.displacement)?;
                let options = ShadowQueryOptions {
                    max_points: slice as u32,
                    max_lights: self.lights.len(),
                    ..ShadowQueryOptions::default()
                };
                let query = ShadowQuery::new(&gpu.pipelines, &self.scene.mesh, options)?;
                let points = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("points"),
                    size: (slice as u64 * 12).max(16),
                    usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
                    mapped_at_creation: false,
                });
                Ok((placed, query, points))
            })
            .map_err(fail)?;
        gpu.check()?;
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("deform") });
        placed.encode(&mut encoder, &self.scene.shape, self.time_s, None).map_err(fail)?;
        gpu.queue.submit([encoder.finish()]);
        times.measure("shadow_depth", || {
            for slice in self.points.chunks(slice.max(1)) {
                let found = self.count(gpu, &mut query, &placed, &points, slice).map_err(fail)?;
                gpu.check()?;
                depths.extend(found);
            }
            Ok(())
        })
    }

    fn count(
        &self,
        gpu: &Gpu,
        query: &mut ShadowQuery,
        placed: &Positions,
        buffer: &wgpu::Buffer,
        points: &[[f32; 3]],
    ) -> Result<Vec<i32>, GpuError> {
        gpu.queue.write_buffer(buffer, 0, bytemuck::cast_slice(points));
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("query") });
        let bound = PositionBuffer { buffer, offset: 0, stride: 12 };
        query.encode_at(&mut encoder, placed.buffer(), bound, points.len() as u32, self.lights, None)?;
        gpu.queue.submit([encoder.finish()]);
        let mut found = read_back_vec(&gpu.device, &gpu.queue, query.depths())?;
        found.truncate(points.len() * self.lights.len());
        Ok(found)
    }
}
