//! Pipelines of a single WGSL module, with the fields that differ between them.

/// Triangles whose corners lie in binding 1, three floats each, for the depth of surfaces. Binding 0 has the columns of
/// a camera's matrix, and the origin that it takes positions from.
pub const SURFACE: &str = "
struct Camera { columns: mat4x4<f32>, origin: vec4<f32> }
@group(0) @binding(0) var<storage, read> camera: Camera;
@group(0) @binding(1) var<storage, read> corners: array<f32>;
@vertex fn surface(@builtin(vertex_index) at: u32) -> @builtin(position) vec4<f32> {
  let place = vec3<f32>(corners[3u * at], corners[3u * at + 1u], corners[3u * at + 2u]);
  return camera.columns * vec4<f32>(place - camera.origin.xyz, 1.0);
}
@fragment fn nothing() {}
";

/// A render pipeline.
#[derive(Clone, Debug)]
pub struct Drawing<'a> {
    pub label: &'a str,
    pub source: &'a str,
    /// Entry points of the vertex and the fragment shader. `None`: the only one.
    pub entry_points: [Option<&'a str>; 2],
    pub buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    pub depth_stencil: Option<wgpu::DepthStencilState>,
    pub samples: u32,
    pub targets: &'a [Option<wgpu::ColorTargetState>],
}

/// Triangles without vertex buffers, depth, or targets.
impl Default for Drawing<'_> {
    fn default() -> Self {
        Self {
            label: "drawing",
            source: "",
            entry_points: [None; 2],
            buffers: &[],
            depth_stencil: None,
            samples: 1,
            targets: &[],
        }
    }
}

impl Drawing<'_> {
    /// Its layout follows from the shaders.
    pub fn pipeline(&self, device: &wgpu::Device) -> wgpu::RenderPipeline {
        let label = Some(self.label);
        let source = wgpu::ShaderSource::Wgsl(self.source.into());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
        let [vertex, fragment] = self.entry_points;
        let compilation_options = wgpu::PipelineCompilationOptions::default;
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label,
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: vertex,
                compilation_options: compilation_options(),
                buffers: self.buffers,
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: self.depth_stencil.clone(),
            multisample: wgpu::MultisampleState { count: self.samples, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: fragment,
                compilation_options: compilation_options(),
                targets: self.targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// Depth that is compared, and written or not, without a stencil.
pub fn depth(format: wgpu::TextureFormat, compare: wgpu::CompareFunction, is_written: bool) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format,
        depth_write_enabled: Some(is_written),
        depth_compare: Some(compare),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    }
}

/// A compute pipeline over the texels of a texture, with one sample or several: binding 0 of group 0.
/// Binding 1 is a storage buffer that is written.
#[derive(Debug)]
pub struct TexelKernel {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
}

impl TexelKernel {
    pub fn new(
        device: &wgpu::Device,
        (label, source): (&str, &str),
        sample_type: wgpu::TextureSampleType,
        multisampled: bool,
    ) -> Self {
        let label = Some(label);
        let source = wgpu::ShaderSource::Wgsl(source.into());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
        let view_dimension = wgpu::TextureViewDimension::D2;
        let texture = wgpu::BindingType::Texture { sample_type, view_dimension, multisampled };
        let storage = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: false },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let visibility = wgpu::ShaderStages::COMPUTE;
        let entries = [(0, texture), (1, storage)];
        let entries = entries.map(|(binding, ty)| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None });
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: Some(&device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label,
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            })),
            module: &module,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        Self { pipeline, layout }
    }

    /// The bind group of a run: all that it reads and writes.
    pub fn group(&self, device: &wgpu::Device, texture: &wgpu::TextureView, words: &wgpu::Buffer) -> wgpu::BindGroup {
        let entries = [wgpu::BindingResource::TextureView(texture), words.as_entire_binding()];
        let entries = (0..).zip(entries).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource });
        let entries = entries.collect::<Vec<_>>();
        device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &self.layout, entries: &entries })
    }

    pub fn run(&self, encoder: &mut wgpu::CommandEncoder, group: &wgpu::BindGroup, [x, y]: [u32; 2]) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.dispatch_workgroups(x, y, 1);
    }
}
