//! Pipelines made from the list of stages.

use crate::stages::Stage;

/// What a binding of a stage holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slot {
    /// A uniform, of which a dispatch picks one by dynamic offset.
    Uniform,
    /// Storage that the stage reads.
    Read,
    /// Storage that the stage writes.
    Write,
}

/// A stage's bind group layout, its bindings numbered from 0 in the order of `slots`.
pub(super) fn layout(device: &wgpu::Device, stage: &Stage, slots: &[Slot]) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = (0..)
        .zip(slots)
        .map(|(binding, slot)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty: match slot {
                    Slot::Uniform => wgpu::BufferBindingType::Uniform,
                    Slot::Read => wgpu::BufferBindingType::Storage { read_only: true },
                    Slot::Write => wgpu::BufferBindingType::Storage { read_only: false },
                },
                has_dynamic_offset: *slot == Slot::Uniform,
                min_binding_size: None,
            },
            count: None,
        })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(stage.name), entries: &entries })
}

/// One pipeline of a stage, with its bind group layout.
#[derive(Debug)]
pub(super) struct Pipeline {
    pub(super) label: &'static str,
    pub(super) compute: wgpu::ComputePipeline,
    pub(super) layout: wgpu::BindGroupLayout,
    /// Words a window of its gathered array, 0 for a single one; see `Split::windows`.
    pub(super) window_words: u32,
}

impl Pipeline {
    /// The pipeline of one entry point. `wgsl` is the stage's module; `further` is a second bind group's layout.
    pub(super) fn new(
        device: &wgpu::Device,
        stage: &Stage,
        wgsl: &str,
        entry_point: &'static str,
        slots: &[Slot],
        further: Option<&wgpu::BindGroupLayout>,
        constants: &[(&str, f64)],
    ) -> Self {
        let window_words =
            constants.iter().find(|(name, _)| *name == "WINDOW_WORDS").map_or(0, |(_, words)| *words as u32);
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(stage.name),
            source: wgpu::ShaderSource::Wgsl(wgsl.into()),
        });
        let layout = layout(device, stage, slots);
        let mut groups = vec![Some(&layout)];
        groups.extend(further.map(Some));
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(entry_point),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let compute = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry_point),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
            cache: None,
        });
        Self { label: entry_point, compute, layout, window_words }
    }

    /// A bind group with `resources` numbered from 0.
    pub(super) fn bind(&self, device: &wgpu::Device, resources: &[wgpu::BindingResource<'_>]) -> wgpu::BindGroup {
        group(device, self.label, &self.layout, resources)
    }
}

/// A bind group with `resources` numbered from 0.
pub(super) fn group(
    device: &wgpu::Device,
    label: &str,
    layout: &wgpu::BindGroupLayout,
    resources: &[wgpu::BindingResource<'_>],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
}
