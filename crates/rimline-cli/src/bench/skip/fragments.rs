//! Counts the fragments of shadow volumes.
//!
//! An occlusion query counts the samples that pass the depth test. Against a depth buffer without any surface all do, but
//! for those at infinity. WebGPU promises only whether there are any, so the count is first tried on a drawing that is known.

use rimline::gpu::read_back_vec;
use rimline::wgpu;
use rimline_bench::pipelines::{self, Drawing};
use wgpu::{BufferUsages, LoadOp};

use super::super::casters::measure::{DEPTH, Stopwatch, stencil_pass};
use crate::failure::Failure;
use crate::gpu_error::GpuError;

/// A triangle over the whole picture.
const WHOLE: &str = "
@vertex fn whole(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(select(-1.0, 3.0, vertex == 1u), select(-1.0, 3.0, vertex == 2u), 0.5, 1.0);
}
@fragment fn nothing() {}
";

/// Draws a light, or what has its number.
pub(super) type Draw<'a> = &'a dyn Fn(&mut wgpu::RenderPass<'_>, usize) -> Result<(), GpuError>;

pub(super) struct FragmentCounter {
    depth: wgpu::TextureView,
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    lights: usize,
}

impl FragmentCounter {
    /// A counter for pictures of so many pixels across and down. `None` where the device's queries do not count.
    pub(super) fn new(stopwatch: &Stopwatch<'_>, size: u32, lights: usize) -> Result<Option<Self>, Failure> {
        let gpu = stopwatch.gpu;
        let counter = Self {
            depth: stopwatch.depth(size),
            queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("fragments"),
                ty: wgpu::QueryType::Occlusion,
                count: lights as u32,
            }),
            resolved: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("fragments"),
                size: 8 * lights as u64,
                usage: BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
            lights,
        };
        let pipeline = whole(&gpu.device);
        // Neighbouring lights draw different numbers of instances.
        let times = |light: usize| 1 + light as u64 % 3;
        let draw = |pass: &mut wgpu::RenderPass<'_>, light: usize| {
            pass.set_pipeline(&pipeline);
            pass.draw(0..3, 0..times(light) as u32);
            Ok(())
        };
        let found = counter.count(stopwatch, &draw)?;
        let expected = u64::from(size).pow(2) * (0..lights).map(times).sum::<u64>();
        Ok((found == expected).then_some(counter))
    }

    /// The fragments of all lights together.
    pub(super) fn count(&self, stopwatch: &Stopwatch<'_>, draw: Draw<'_>) -> Result<u64, Failure> {
        let gpu = stopwatch.gpu;
        let mut encoder = stopwatch.encoder();
        for light in 0..self.lights {
            // Depth is reversed: 0 is farthest.
            let mut pass = stencil_pass(&mut encoder, &self.depth, LoadOp::Clear(0.0), None, Some(&self.queries));
            pass.begin_occlusion_query(light as u32);
            draw(&mut pass, light).map_err(|error| error.on(gpu))?;
            pass.end_occlusion_query();
        }
        encoder.resolve_query_set(&self.queries, 0..self.lights as u32, &self.resolved, 0);
        stopwatch.run(encoder.finish())?;
        let counts: Vec<u64> =
            read_back_vec(&gpu.device, &gpu.queue, &self.resolved).map_err(|error| GpuError::from(error).on(gpu))?;
        Ok(counts.iter().sum())
    }
}

fn whole(device: &wgpu::Device) -> wgpu::RenderPipeline {
    let drawing = Drawing {
        label: "fragments",
        source: WHOLE,
        entry_points: [Some("whole"), Some("nothing")],
        depth_stencil: Some(pipelines::depth(DEPTH, wgpu::CompareFunction::Greater, false)),
        ..Drawing::default()
    };
    drawing.pipeline(device)
}
