//! One stage by itself: its shader with a test's own buffers.

use rimline::internals::stages::Stage;

use crate::device::Gpu;

/// A compute pipeline of a test's, its bind group 0 as the shader has it.
pub struct Dispatch(wgpu::ComputePipeline);

impl Dispatch {
    pub fn new(gpu: &Gpu, source: &str, entry_point: &str) -> Self {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(entry_point),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        Self(gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry_point),
            layout: None,
            module: &module,
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        }))
    }

    pub fn stage(gpu: &Gpu, stage: &Stage) -> Self {
        Self::new(gpu, &stage.wgsl(), stage.name)
    }

    /// Runs with a group of buffers bound from 0 on.
    pub fn run(&self, gpu: &Gpu, buffers: &[&wgpu::Buffer], workgroups: u32) -> Result<(), String> {
        self.run_over(gpu, buffers, [workgroups, 1])
    }

    /// The same, for workgroups along x and y.
    pub fn run_over(&self, gpu: &Gpu, buffers: &[&wgpu::Buffer], workgroups: [u32; 2]) -> Result<(), String> {
        let bound: Vec<_> = (0..).zip(buffers.iter().copied()).collect();
        self.run_groups(gpu, &[&bound], workgroups)
    }

    /// Runs with the groups' buffers bound where each says.
    pub fn run_bound(&self, gpu: &Gpu, groups: &[&[(u32, &wgpu::Buffer)]], workgroups: u32) -> Result<(), String> {
        self.run_groups(gpu, groups, [workgroups, 1])
    }

    fn run_groups(&self, gpu: &Gpu, groups: &[&[(u32, &wgpu::Buffer)]], workgroups: [u32; 2]) -> Result<(), String> {
        let bind = |(group, buffers): (u32, &&[(u32, &wgpu::Buffer)])| {
            let entries: Vec<_> = buffers
                .iter()
                .map(|(binding, buffer)| wgpu::BindGroupEntry {
                    binding: *binding,
                    resource: buffer.as_entire_binding(),
                })
                .collect();
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &self.0.get_bind_group_layout(group),
                entries: &entries,
            })
        };
        let groups: Vec<_> = (0..).zip(groups).map(bind).collect();
        gpu.submit(|encoder| {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.0);
            for (number, group) in (0..).zip(&groups) {
                pass.set_bind_group(number, group, &[]);
            }
            pass.dispatch_workgroups(workgroups[0], workgroups[1], 1);
            Ok(())
        })
    }
}

/// A layout of storage buffers for computing: where they are bound, and whether they are only read.
pub fn storage_layout(gpu: &Gpu, buffers: &[(u32, bool)]) -> wgpu::BindGroupLayout {
    let entry = |&(binding, read_only): &(u32, bool)| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let entries = &*buffers.iter().map(entry).collect::<Vec<_>>();
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("test"), entries })
}

pub fn uniform<T: bytemuck::Pod>(gpu: &Gpu, contents: &T) -> wgpu::Buffer {
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("test"),
        size: size_of::<T>() as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    gpu.queue.write_buffer(&buffer, 0, bytemuck::bytes_of(contents));
    buffer
}
