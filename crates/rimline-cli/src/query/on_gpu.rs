//! The query on a GPU, a slice of the points at a time.

use rimline::gpu::{PositionBuffer, QueryPoints, ShadowQuery, ShadowQueryOptions, read_back_vec};
use rimline::mesh::NO_FACE;
use rimline::{Displacement, wgpu};

use super::asked::Asked;
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
    pub(super) asked: Asked<'a>,
    pub(super) displacement: Option<&'a Displacement>,
    pub(super) time_s: f32,
}

impl Job<'_, '_> {
    /// Compiles the shaders before the stages run and are timed.
    pub(super) fn run_warm(&self, gpu: &Gpu, depths: &mut Vec<i32>, times: &mut Times) -> Result<(), Failure> {
        let is_posed = matches!(self.scene.shape, Shape::Posed { .. });
        let Self { asked, displacement, time_s, .. } = *self;
        times.measure("compile", || {
            with_triangle(is_posed, |scene| {
                let asked = Asked { points: &[[0.0; 3]], on_face: asked.on_face.map(|_| &[NO_FACE][..]), ..asked };
                let job = Job { scene, asked, displacement, time_s };
                job.run(gpu, &mut Vec::new(), &mut Times::default())
            })
        })?;
        self.run(gpu, depths, times)
    }

    pub(super) fn run(&self, gpu: &Gpu, depths: &mut Vec<i32>, times: &mut Times) -> Result<(), Failure> {
        let fail = |error: GpuError| error.on(gpu);
        let slice = self.asked.slice(&self.scene.mesh).min(self.asked.points.len());
        let (placed, mut query, points) = times
            .measure("prepare", || -> Result<_, GpuError> {
                let placed = Positions::new(gpu, &self.scene.shape, self.displacement)?;
                let options = ShadowQueryOptions {
                    max_points: slice as u32,
                    max_lights: self.asked.lights_at_once(),
                    ..ShadowQueryOptions::default()
                };
                let query = ShadowQuery::new(&gpu.pipelines, &self.scene.mesh, options)?;
                let points = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some("points"),
                    size: (slice as u64 * POINT).max(POINT),
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
            self.asked.each_slice(slice.max(1), depths, |asked| {
                let found = count(gpu, &mut query, &placed, &points, asked).map_err(fail)?;
                gpu.check()?;
                Ok(found)
            })
        })
    }
}

/// Bytes of a point and the face that it is on.
const POINT: u64 = 16;

fn count(
    gpu: &Gpu,
    query: &mut ShadowQuery,
    placed: &Positions,
    buffer: &wgpu::Buffer,
    Asked { points, on_face, lights, .. }: Asked<'_>,
) -> Result<Vec<i32>, GpuError> {
    let face = |at: usize| on_face.and_then(|faces| faces.get(at)).copied().unwrap_or(NO_FACE);
    let words = |(at, point): (usize, &[f32; 3])| {
        let [x, y, z] = point.map(f32::to_bits);
        [x, y, z, face(at)]
    };
    let words: Vec<[u32; 4]> = points.iter().enumerate().map(words).collect();
    gpu.queue.write_buffer(buffer, 0, bytemuck::cast_slice(&words));
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("query") });
    let points_at = PositionBuffer { buffer, offset: 0, stride: POINT };
    let bound = QueryPoints { points: points_at, on_face: on_face.map(|_| POINT - 4) };
    query.encode_at(&mut encoder, placed.buffer(), bound, points.len() as u32, lights, None)?;
    gpu.queue.submit([encoder.finish()]);
    let mut found = read_back_vec(&gpu.device, &gpu.queue, query.depths())?;
    found.truncate(points.len() * lights.len());
    Ok(found)
}
