//! Whether timestamps of a software device belong to their passes.
//!
//! Mesa's llvmpipe takes the timestamps around a compute pass late, both at once, as soon as the device has drawn
//! anything. A load of a known least time between two timestamps shows it.

use super::memory::{any_error, buffer};

const LABEL: &str = "clock load";
/// Passes of the load. Another program may delay one of two timestamps that are written at once, but hardly each time.
const PASSES: u32 = 6;
/// The least time of the load in milliseconds: a quarter of what 60,000 turns of eight dependent multiplications take
/// at 6 GHz.
pub(crate) const LEAST_MS: f64 = 0.1;

/// Bits that are mixed: no compiler makes fewer steps of these.
const LOAD: &str = "
@group(0) @binding(0) var<storage, read_write> bits: array<u32>;

fn mixed(x: u32) -> u32 {
  return (x ^ (x >> 15u)) * 0x2c1b3c6du;
}

@compute @workgroup_size(1)
fn clock_load() {
  var x = bits[0];
  // Turns: 60000.
  for (var turn = 0u; turn < 60000u; turn++) {
    x = mixed(mixed(mixed(mixed(mixed(mixed(mixed(mixed(x))))))));
  }
  bits[0] = x;
}
";

/// A load between timestamps.
#[derive(Debug)]
pub(super) struct ClockCheck {
    pipeline: wgpu::ComputePipeline,
    group: wgpu::BindGroup,
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

impl ClockCheck {
    /// `None` if the device refuses it.
    pub(super) fn new(device: &wgpu::Device) -> Option<Self> {
        any_error(device, || Self::made(device)).ok()
    }

    fn made(device: &wgpu::Device) -> Self {
        let label = Some(LABEL);
        let source = wgpu::ShaderSource::Wgsl(LOAD.into());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: None,
            module: &module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        let bits = buffer(device, LABEL, 16, wgpu::BufferUsages::STORAGE);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: bits.as_entire_binding() }],
        });
        let (ty, count) = (wgpu::QueryType::Timestamp, 2 * PASSES);
        let set = device.create_query_set(&wgpu::QuerySetDescriptor { label, ty, count });
        let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        let resolved = buffer(device, LABEL, u64::from(count) * 8, usage);
        Self { pipeline, group, set, resolved }
    }

    /// Submits the load. Returns the buffer of its timestamps, for [`load_ticks`].
    pub(super) fn submit(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> &wgpu::Buffer {
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for index in 0..PASSES {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(LABEL),
                timestamp_writes: Some(wgpu::ComputePassTimestampWrites {
                    query_set: &self.set,
                    beginning_of_pass_write_index: Some(2 * index),
                    end_of_pass_write_index: Some(2 * index + 1),
                }),
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.group, &[]);
            pass.dispatch_workgroups(1, 1, 1);
        }
        encoder.resolve_query_set(&self.set, 0..2 * PASSES, &self.resolved, 0);
        queue.submit([encoder.finish()]);
        &self.resolved
    }
}

/// The ticks of the shortest pass of the load.
pub(super) fn load_ticks(ticks: &[u64]) -> u64 {
    ticks.chunks_exact(2).map(|pass| pass[1].saturating_sub(pass[0])).min().unwrap_or(0)
}
