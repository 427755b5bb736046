//! Counts the fragments of shadow volumes.
//!
//! An occlusion query counts the samples that pass the depth test. Against a depth buffer without any surface all do, but
//! for those at infinity. WebGPU promises only whether there are any, so the count is first tried on a drawing that is
//! known.

use wgpu::{BufferUsages, LoadOp};

use super::{DEPTH, STENCIL, Target};
use crate::Error;
use crate::gpu::Gpu;
use crate::pipelines::{self, Drawing};

const WHOLE: &str = "
@vertex fn whole(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(select(-1.0, 3.0, vertex == 1u), select(-1.0, 3.0, vertex == 2u), 0.5, 1.0);
}
@fragment fn nothing() {}
";

pub struct FragmentCounter {
    depth: wgpu::TextureView,
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    lights: usize,
}

impl FragmentCounter {
    /// A counter for pictures of so many pixels across and down. `None` where the device's queries do not count.
    pub fn new(gpu: &Gpu, size: u32, lights: usize) -> Result<Option<Self>, Error> {
        let counter = Self {
            depth: gpu.texture([size; 2], DEPTH),
            queries: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("fragments"),
                ty: wgpu::QueryType::Occlusion,
                count: lights as u32,
            }),
            resolved: gpu.empty(BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC, 8 * lights as u64),
            lights,
        };
        let pipeline = Drawing {
            label: "fragments",
            source: WHOLE,
            entry_points: [Some("whole"), Some("nothing")],
            depth_stencil: Some(pipelines::depth(DEPTH, wgpu::CompareFunction::Greater, false)),
            ..Drawing::default()
        };
        let pipeline = pipeline.pipeline(&gpu.device);
        // Neighbouring lights draw different numbers of instances.
        let times = |light: usize| 1 + light as u64 % 3;
        let found = counter.count(gpu, |pass, light| {
            pass.set_pipeline(&pipeline);
            pass.draw(0..3, 0..times(light) as u32);
            Ok(())
        })?;
        let expected = u64::from(size).pow(2) * (0..lights).map(times).sum::<u64>();
        Ok((found == expected).then_some(counter))
    }

    pub fn count(
        &self,
        gpu: &Gpu,
        mut draw: impl FnMut(&mut wgpu::RenderPass<'_>, usize) -> Result<(), Error>,
    ) -> Result<u64, Error> {
        let mut encoder = gpu.encoder();
        for light in 0..self.lights {
            // Depth is reversed: 0 is farthest.
            let target = Target::counting(&self.depth, LoadOp::Clear(0.0));
            let mut pass = target.begin_timed(&mut encoder, STENCIL, None, Some(&self.queries));
            pass.begin_occlusion_query(light as u32);
            draw(&mut pass, light)?;
            pass.end_occlusion_query();
        }
        encoder.resolve_query_set(&self.queries, 0..self.lights as u32, &self.resolved, 0);
        gpu.queue.submit([encoder.finish()]);
        gpu.wait()?;
        Ok(gpu.read::<u64>(&self.resolved)?.iter().take(self.lights).sum())
    }
}
