//! The GPU's contestants.

use std::time::Instant;

use rimline::gpu::{DeviceError, Extractor, PositionBuffer, StageTimer};
use rimline::reference::Method;
use rimline::reference::cpu;
use rimline::reference::layout::ExtractionStatistics;
use rimline::{Predicate, wgpu};

use super::bench_mesh::Case;
use super::measure::{Contender, Sample, Summary};
use super::method::{checked, timed};
use crate::device::Gpu;
use crate::extract::on_gpu::read_planes;
use crate::failure::Failure;
use crate::gpu_error::GpuError;

/// A case's positions on the GPU.
pub(super) struct Uploaded<'a> {
    gpu: &'a Gpu,
    case: &'a Case<'a>,
    positions: wgpu::Buffer,
}

impl<'a> Uploaded<'a> {
    pub(super) fn new(gpu: &'a Gpu, case: &'a Case<'a>) -> Self {
        let bytes: &[u8] = bytemuck::cast_slice(case.positions);
        let positions = scratch(gpu, bytes.len() as u64);
        gpu.queue.write_buffer(&positions, 0, bytes);
        Self { gpu, case, positions }
    }

    fn buffer(&self) -> PositionBuffer<'_> {
        PositionBuffer { buffer: &self.positions, offset: 0, stride: 12 }
    }

    /// Runs a method again and again.
    pub(super) fn contender(&self, method: Method, predicate: Predicate) -> Result<Contender<'_>, Failure> {
        let Self { gpu, case, .. } = self;
        let options = timed(method, predicate, case.lights.len());
        let fail = |error: GpuError| error.on(gpu);
        let mut extractor = Extractor::new(&gpu.pipelines, case.mesh, options).map_err(|error| fail(error.into()))?;
        gpu.check()?;
        let mut timer = StageTimer::new(&gpu.device, &gpu.queue);
        Ok(Box::new(move || {
            let begin = Instant::now();
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            if let Some(timer) = &mut timer {
                timer.clear();
            }
            extractor
                .encode(&mut encoder, self.buffer(), case.lights, timer.as_mut())
                .map_err(|error| fail(error.into()))?;
            if let Some(timer) = &timer {
                timer.resolve(&mut encoder);
            }
            gpu.queue.submit([encoder.finish()]);
            gpu.wait()?;
            let wall_ms = begin.elapsed().as_secs_f64() * 1e3;
            let Some(timer) = &timer else {
                return Ok(Sample { wall_ms, ..Sample::default() });
            };
            let read = || Ok((timer.read(&gpu.device, &gpu.queue)?, timer.read_span(&gpu.device, &gpu.queue)?));
            match read() {
                Ok((stages, gpu_ms)) => Ok(Sample { wall_ms, gpu_ms: Some(gpu_ms), stages }),
                // Timestamps that mean nothing: the clock's time is left.
                Err(
                    DeviceError::TimestampPeriod { .. }
                    | DeviceError::ClockStill { .. }
                    | DeviceError::ClockBackwards { .. },
                ) => Ok(Sample { wall_ms, ..Sample::default() }),
                Err(error) => Err(fail(error.into())),
            }
        }))
    }

    /// A method's bits; facing masks only where it has them.
    pub(super) fn extraction(&self, method: Method, predicate: Predicate) -> Result<cpu::Extraction, Failure> {
        let Self { gpu, case, .. } = self;
        let options = checked(method, predicate, case.lights.len());
        let read = || -> Result<cpu::Extraction, GpuError> {
            let mut extractor = Extractor::new(&gpu.pipelines, case.mesh, options)?;
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            extractor.encode(&mut encoder, self.buffer(), case.lights, None)?;
            gpu.queue.submit([encoder.finish()]);
            let results = extractor.results();
            let facing = match method {
                Method::FaceMask => read_planes(gpu, results.facing, case.mesh.faces().len())?,
                Method::PerEdge => Vec::new(),
            };
            let masks = read_planes(gpu, results.masks, case.mesh.edges().len())?;
            let statistics: Vec<ExtractionStatistics> =
                rimline::gpu::read_back_vec(&gpu.device, &gpu.queue, results.statistics)?;
            let facing_statistics = statistics.first().map(|statistics| cpu::FacingStatistics {
                non_finite_faces: statistics.non_finite_faces,
                undecided_pairs: statistics.undecided_pairs,
                exact_zeros: statistics.exact_zeros,
            });
            Ok(cpu::Extraction {
                facing,
                masks,
                statistics: facing_statistics.unwrap_or_default(),
                ..Default::default()
            })
        };
        let found = read().map_err(|error| error.on(gpu))?;
        gpu.check()?;
        Ok(found)
    }
}

/// GB/s of a copy from buffer to buffer, bytes read and written both counted.
pub(super) fn copy_bandwidth(gpu: &Gpu, rounds: usize) -> Result<f64, Failure> {
    const BYTES: u64 = 64 << 20;
    let (from, to) = (scratch(gpu, BYTES), scratch(gpu, BYTES));
    let mut times = Vec::new();
    for _ in 0..=rounds {
        let begin = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        // Several, so that handing over the commands weighs little.
        for _ in 0..8 {
            encoder.copy_buffer_to_buffer(&from, 0, &to, 0, BYTES);
        }
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        times.push(begin.elapsed().as_secs_f64());
    }
    let median = Summary::of(times.drain(1..)).map_or(f64::NAN, |summary| summary.median);
    Ok(8.0 * 2.0 * BYTES as f64 / median / 1e9)
}

fn scratch(gpu: &Gpu, size: u64) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("bench"),
        size,
        usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}
