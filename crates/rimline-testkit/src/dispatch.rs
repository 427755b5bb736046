//! One stage by itself: its shader with a test's own buffers.

use rimline::internals::stages::Stage;

use crate::device::Gpu;

/// A compute pipeline of a test's, its bind groups as the shader has them.
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
        let bound: Vec<_> = (0..).zip(buffers.iter().copied()).collect();
        self.run_bound(gpu, &[&bound], workgroups)
    }

    /// Runs with the groups' buffers bound where each says.
    pub fn run_bound(&self, gpu: &Gpu, groups: &[&[(u32, &wgpu::Buffer)]], workgroups: u32) -> Result<(), String> {
        let groups = groups.iter().map(|group| {
            group.iter().map(|&(binding, buffer)| (binding, buffer.as_entire_binding())).collect::<Vec<_>>()
        });
        gpu.submit(|encoder| {
            self.record(gpu, encoder, groups, [workgroups, 1]);
            Ok(())
        })
    }

    /// Records a run over a texture at binding 0 that writes words at binding 1.
    pub fn record_over(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        texture: &wgpu::TextureView,
        words: &wgpu::Buffer,
        workgroups: [u32; 2],
    ) {
        let group = vec![(0, wgpu::BindingResource::TextureView(texture)), (1, words.as_entire_binding())];
        self.record(gpu, encoder, [group], workgroups);
    }

    fn record<'a>(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        groups: impl IntoIterator<Item = Vec<(u32, wgpu::BindingResource<'a>)>>,
        [x, y]: [u32; 2],
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&self.0);
        for (number, group) in (0..).zip(groups) {
            let entries = group.into_iter().map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource });
            let entries = &*entries.collect::<Vec<_>>();
            let layout = &self.0.get_bind_group_layout(number);
            let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries });
            pass.set_bind_group(number, &group, &[]);
        }
        pass.dispatch_workgroups(x, y, 1);
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
