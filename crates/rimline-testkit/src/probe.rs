//! Functions of a stage's WGSL, called by a compute shader that writes down what they return.

use crate::device::Gpu;
use crate::dispatch::storage_layout;
use crate::pipelines::group;

/// A module whose entry points are made functions, and a compute shader that evaluates an expression of `input`, a
/// `vec4<f32>`, and of `index`.
pub struct Probe {
    pipeline: wgpu::ComputePipeline,
    layouts: [wgpu::BindGroupLayout; 2],
}

/// Resource bound in group 0.
#[derive(Clone, Copy)]
pub enum Bound<'a> {
    Uniform(&'a wgpu::Buffer),
    Storage(&'a wgpu::Buffer),
    Floats(&'a wgpu::TextureView),
    Integers(&'a wgpu::TextureView),
}

impl<'a> Bound<'a> {
    fn ty(self) -> wgpu::BindingType {
        let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        let texture = |sample_type| wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        match self {
            Self::Uniform(_) => buffer(wgpu::BufferBindingType::Uniform),
            Self::Storage(_) => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
            Self::Floats(_) => texture(wgpu::TextureSampleType::Float { filterable: false }),
            Self::Integers(_) => texture(wgpu::TextureSampleType::Uint),
        }
    }

    fn resource(self) -> wgpu::BindingResource<'a> {
        match self {
            Self::Uniform(buffer) | Self::Storage(buffer) => buffer.as_entire_binding(),
            Self::Floats(view) | Self::Integers(view) => wgpu::BindingResource::TextureView(view),
        }
    }
}

impl Probe {
    /// `result` is a type of four words. `bound` is of the kinds that [`Self::run`] will get.
    pub fn new(gpu: &Gpu, source: &str, (result, expression): (&str, &str), bound: &[(u32, Bound<'_>)]) -> Self {
        let mut source = source.to_owned();
        for (from, to) in [
            ("@vertex\n", ""),
            ("@fragment\n", ""),
            ("discard;", "return;"),
            ("-> @builtin(position) vec4<f32>", "-> vec4<f32>"),
            ("@builtin(position) @invariant ", ""),
            ("@builtin(position) ", ""),
            ("@builtin(vertex_index) ", ""),
            ("@builtin(instance_index) ", ""),
            ("@location(0) @interpolate(linear, sample) ", ""),
        ] {
            source = source.replace(from, to);
        }
        let source = format!(
            "{source}
@group(1) @binding(0) var<storage, read> probe_inputs: array<vec4<f32>>;
@group(1) @binding(1) var<storage, read_write> probe_found: array<{result}>;
@compute @workgroup_size(64)
fn probe(@builtin(global_invocation_id) id: vec3<u32>) {{
  let index = id.x;
  if (index < arrayLength(&probe_found)) {{
    let input = probe_inputs[index];
    probe_found[index] = {expression};
  }}
}}
"
        );
        let label = Some("probe");
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label,
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let entry = |&(binding, bound): &(u32, Bound<'_>)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: bound.ty(),
            count: None,
        };
        let entries = &*bound.iter().map(entry).collect::<Vec<_>>();
        let of_stage = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries });
        let layouts = [of_stage, storage_layout(gpu, &[(0, true), (1, false)])];
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &[Some(&layouts[0]), Some(&layouts[1])],
            immediate_size: 0,
        });
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: Some(&layout),
            module: &module,
            entry_point: Some("probe"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        Self { pipeline, layouts }
    }

    /// Four words for each input. There are at most 65,535 times 64 of them.
    pub fn run(&self, gpu: &Gpu, bound: &[(u32, Bound<'_>)], inputs: &[[f32; 4]]) -> Result<Vec<[u32; 4]>, String> {
        let (given, found) = (gpu.storage(inputs), gpu.storage(&vec![[0_u32; 4]; inputs.len()]));
        let entries = bound.iter();
        let entries = entries.map(|&(binding, bound)| wgpu::BindGroupEntry { binding, resource: bound.resource() });
        let entries = &*entries.collect::<Vec<_>>();
        let of_stage =
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &self.layouts[0], entries });
        let probed = group(&gpu.device, &self.layouts[1], [&given, &found].map(wgpu::Buffer::as_entire_binding));
        gpu.submit(|encoder| {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &of_stage, &[]);
            pass.set_bind_group(1, &probed, &[]);
            pass.dispatch_workgroups((inputs.len() as u32).div_ceil(64), 1, 1);
            Ok(())
        })?;
        gpu.read(&found, inputs.len())
    }
}
