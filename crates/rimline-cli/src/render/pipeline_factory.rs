//! Parts that the passes of a picture share: the frame's uniform, and a short way to pipelines.

use rimline::wgpu;

pub(crate) const UNIFORM: wgpu::BindingType = wgpu::BindingType::Buffer {
    ty: wgpu::BufferBindingType::Uniform,
    has_dynamic_offset: false,
    min_binding_size: None,
};

pub(crate) const READ_ONLY: wgpu::BindingType = wgpu::BindingType::Buffer {
    ty: wgpu::BufferBindingType::Storage { read_only: true },
    has_dynamic_offset: false,
    min_binding_size: None,
};

pub(crate) fn read_texture(view_dimension: wgpu::TextureViewDimension, filterable: bool) -> wgpu::BindingType {
    let sample_type = wgpu::TextureSampleType::Float { filterable };
    wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false }
}

/// A texture of one layer, level and sample.
pub(crate) fn plain_texture(
    label: &str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> wgpu::TextureDescriptor<'_> {
    wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    }
}

/// All of a texture.
pub(crate) fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Makes pipelines and bind groups; group 0 is always the frame.
pub(crate) struct PipelineFactory<'a> {
    pub(crate) device: &'a wgpu::Device,
    /// WGSL that declares the frame and what every pass knows.
    prelude: &'static str,
    frame_layout: wgpu::BindGroupLayout,
    pub(crate) frame_group: wgpu::BindGroup,
    frame: wgpu::Buffer,
}

/// A pipeline without what they all have alike.
pub(crate) struct Pass<'a> {
    pub(crate) name: &'static str,
    /// Prefix of the vertex entry point's name; often the pass's own name.
    pub(crate) vertex: &'a str,
    /// After the prelude; entry points are the names with `_vertex` and `_fragment`.
    pub(crate) source: &'a str,
    /// Groups 1 and on.
    pub(crate) groups: &'a [&'a wgpu::BindGroupLayout],
    pub(crate) topology: wgpu::PrimitiveTopology,
    pub(crate) format: wgpu::TextureFormat,
    pub(crate) blend: Option<wgpu::BlendState>,
    pub(crate) samples: u32,
    pub(crate) write: wgpu::ColorWrites,
    pub(crate) depth: Option<wgpu::DepthStencilState>,
    pub(crate) constants: &'a [(&'a str, f64)],
}

impl<'a> Pass<'a> {
    /// Draws triangles of one sample, over what is there.
    pub(crate) fn new(
        name: &'static str,
        source: &'a str,
        groups: &'a [&'a wgpu::BindGroupLayout],
        format: wgpu::TextureFormat,
    ) -> Self {
        let (topology, write) = (wgpu::PrimitiveTopology::TriangleList, wgpu::ColorWrites::ALL);
        let (vertex, constants) = (name, &[][..]);
        Self { name, vertex, source, groups, topology, format, blend: None, samples: 1, write, depth: None, constants }
    }
}

impl<'a> PipelineFactory<'a> {
    /// `frame` is the uniform that `prelude` declares as group 0, binding 0.
    pub(crate) fn new(device: &'a wgpu::Device, queue: &wgpu::Queue, prelude: &'static str, frame: &[u8]) -> Self {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: frame.len() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        queue.write_buffer(&buffer, 0, frame);
        let frame_layout = layout(device, wgpu::ShaderStages::VERTEX_FRAGMENT, &[UNIFORM]);
        let frame_group = group(device, &frame_layout, &[buffer.as_entire_binding()]);
        Self { device, prelude, frame_layout, frame_group, frame: buffer }
    }

    /// Another frame, for what is submitted from now on.
    pub(crate) fn set_frame(&self, queue: &wgpu::Queue, frame: &[u8]) {
        queue.write_buffer(&self.frame, 0, frame);
    }

    pub(crate) fn layout(&self, types: &[wgpu::BindingType]) -> wgpu::BindGroupLayout {
        layout(self.device, wgpu::ShaderStages::VERTEX_FRAGMENT, types)
    }

    /// A layout whose bindings only some stages see.
    pub(crate) fn layout_for(
        &self,
        visibility: wgpu::ShaderStages,
        types: &[wgpu::BindingType],
    ) -> wgpu::BindGroupLayout {
        layout(self.device, visibility, types)
    }

    pub(crate) fn group(
        &self,
        layout: &wgpu::BindGroupLayout,
        resources: &[wgpu::BindingResource<'_>],
    ) -> wgpu::BindGroup {
        group(self.device, layout, resources)
    }

    /// A storage buffer with these contents.
    pub(crate) fn buffer(&self, queue: &wgpu::Queue, label: &str, contents: &[u8]) -> wgpu::Buffer {
        self.filled(queue, label, contents, wgpu::BufferUsages::STORAGE)
    }

    /// A uniform buffer with these contents.
    pub(crate) fn uniform(&self, queue: &wgpu::Queue, label: &str, contents: &[u8]) -> wgpu::Buffer {
        self.filled(queue, label, contents, wgpu::BufferUsages::UNIFORM)
    }

    fn filled(&self, queue: &wgpu::Queue, label: &str, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: (contents.len() as u64).max(16),
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        queue.write_buffer(&buffer, 0, contents);
        buffer
    }

    pub(crate) fn target(
        &self,
        label: &str,
        size: [u32; 2],
        format: wgpu::TextureFormat,
        samples: u32,
        usage: wgpu::TextureUsages,
    ) -> wgpu::Texture {
        let usage = usage | wgpu::TextureUsages::RENDER_ATTACHMENT;
        let plain = plain_texture(label, size, format, usage);
        self.device.create_texture(&wgpu::TextureDescriptor { sample_count: samples, ..plain })
    }

    pub(crate) fn pipeline(&self, pass: &Pass<'_>) -> wgpu::RenderPipeline {
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(pass.name),
            source: wgpu::ShaderSource::Wgsl(format!("{}\n{}", self.prelude, pass.source).into()),
        });
        let mut groups = vec![Some(&self.frame_layout)];
        groups.extend(pass.groups.iter().copied().map(Some));
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(pass.name),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let compilation_options = wgpu::PipelineCompilationOptions { constants: pass.constants, ..Default::default() };
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(pass.name),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(&format!("{}_vertex", pass.vertex)),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState { topology: pass.topology, ..Default::default() },
            depth_stencil: pass.depth.clone(),
            multisample: wgpu::MultisampleState { count: pass.samples, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(&format!("{}_fragment", pass.name)),
                compilation_options,
                targets: &[Some(wgpu::ColorTargetState {
                    format: pass.format,
                    blend: pass.blend,
                    write_mask: pass.write,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

fn layout(device: &wgpu::Device, visibility: wgpu::ShaderStages, types: &[wgpu::BindingType]) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = (0..)
        .zip(types)
        .map(|(binding, &ty)| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None })
        .collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
}

fn group(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: &[wgpu::BindingResource<'_>],
) -> wgpu::BindGroup {
    let entries: Vec<_> = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

/// The nearest is drawn and written, or whatever comes without being written.
pub(crate) fn depth_test(write: bool) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: wgpu::TextureFormat::Depth32Float,
        depth_write_enabled: Some(write),
        depth_compare: Some(if write { wgpu::CompareFunction::Greater } else { wgpu::CompareFunction::Always }),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    }
}

/// A pass onto one colour target, and a depth buffer that is cleared to the infinitely far.
pub(crate) fn color_pass<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    label: &str,
    target: &wgpu::TextureView,
    resolve_target: Option<&wgpu::TextureView>,
    load: wgpu::LoadOp<wgpu::Color>,
    depth: Option<&wgpu::TextureView>,
) -> wgpu::RenderPass<'e> {
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: target,
            depth_slice: None,
            resolve_target,
            ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
        })],
        depth_stencil_attachment: depth.map(|view| wgpu::RenderPassDepthStencilAttachment {
            view,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
            stencil_ops: None,
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    })
}
