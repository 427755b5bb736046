//! The query on a GPU, a slice of the points at a time.

use rimline::gpu::{PositionBuffer, QueryPoints, ShadowQuery, ShadowQueryOptions};
use rimline::mesh::NO_FACE;
use rimline::{Displacement, wgpu};

use super::Asked;
use crate::device::Gpu;
use crate::failure::Failure;
use crate::gpu_error::{GpuError, On as _};
use crate::input::{Scene, Shape};
use crate::posed_input::Positions;
use crate::report::Times;
use crate::warm_up::with_triangle;

#[derive(Clone, Copy)]
pub(super) struct Job<'a, 's> {
    pub(super) scene: &'a Scene<'s>,
    pub(super) asked: Asked<'a>,
    pub(super) displacement: Option<&'a Displacement>,
    pub(super) time_s: f32,
}

impl Job<'_, '_> {
    /// `is_warm` compiles the shaders before the stages run and are timed.
    pub(super) fn run(
        &self,
        gpu: &Gpu,
        depths: &mut Vec<i32>,
        times: &mut Times,
        is_warm: bool,
    ) -> Result<(), Failure> {
        if is_warm {
            let warm_up = |scene: &Scene<'_>| {
                let on_face = self.asked.on_face.map(|_| &[NO_FACE][..]);
                let asked = Asked { points: &[[0.0; 3]], on_face, ..self.asked };
                Job { scene, asked, ..*self }.run(gpu, &mut Vec::new(), &mut Times::default(), false)
            };
            let is_posed = matches!(self.scene.shape, Shape::Posed { .. });
            times.measure("compile", || with_triangle(is_posed, warm_up))?;
        }
        let slice = self.asked.slice(&self.scene.mesh).min(self.asked.points.len());
        let (placed, mut query) = times.measure("prepare", || self.prepare(gpu, slice)).on(gpu)?;
        let points = gpu.buffer("points", slice as u64 * POINT, wgpu::BufferUsages::STORAGE);
        gpu.check()?;
        let mut encoder = gpu.encoder("deform");
        placed.encode(&mut encoder, &self.scene.shape, self.time_s, None).on(gpu)?;
        gpu.submit(encoder);
        times.measure("shadow_depth", || {
            self.asked.each_slice(slice.max(1), depths, |asked| {
                let found = count(gpu, &mut query, &placed, &points, asked).on(gpu)?;
                gpu.check()?;
                Ok(found)
            })
        })
    }

    fn prepare(&self, gpu: &Gpu, slice: usize) -> Result<(Positions, ShadowQuery), GpuError> {
        let (max_points, max_lights) = (slice as u32, self.asked.lights_at_once());
        let options = ShadowQueryOptions { max_points, max_lights, ..ShadowQueryOptions::default() };
        let placed = Positions::new(gpu, &self.scene.shape, self.displacement)?;
        Ok((placed, ShadowQuery::new(&gpu.pipelines, &self.scene.mesh, options)?))
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
    let mut encoder = gpu.encoder("query");
    let points_at = PositionBuffer { buffer, offset: 0, stride: POINT };
    let bound = QueryPoints { points: points_at, on_face: on_face.map(|_| POINT - 4) };
    query.encode_at(&mut encoder, placed.buffer(), bound, points.len() as u32, lights)?;
    gpu.submit(encoder);
    Ok(query.read_occluder_counts(&gpu.queue)?)
}
