//! Pipelines of a single WGSL module, with the fields that differ between them; textures and their pixels.

use rimline::gpu::{DeviceError, read_back_vec};

/// Triangles whose corners lie in binding 1, three floats each, for the depth of surfaces. Binding 0 has the columns of
/// a camera's matrix, and the origin that it takes positions from.
pub const SURFACE: &str = "
struct Camera { columns: mat4x4<f32>, origin: vec4<f32> }
@group(0) @binding(0) var<storage, read> camera: Camera;
@group(0) @binding(1) var<storage, read> corners: array<f32>;
@vertex fn surface(@builtin(vertex_index) at: u32) -> @builtin(position) vec4<f32> {
  let position = vec3<f32>(corners[3u * at], corners[3u * at + 1u], corners[3u * at + 2u]);
  return camera.columns * vec4<f32>(position - camera.origin.xyz, 1.0);
}
@fragment fn nothing() {}
";

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

pub const ADDED: wgpu::BlendState = {
    let add = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    wgpu::BlendState { color: add, alpha: add }
};

/// A group of resources, from binding 0 on.
pub fn group<'a>(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: impl IntoIterator<Item = wgpu::BindingResource<'a>>,
) -> wgpu::BindGroup {
    let entries = (0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource });
    let entries = &entries.collect::<Vec<_>>();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries })
}

pub fn texture(device: &wgpu::Device, [width, height]: [u32; 2], format: wgpu::TextureFormat) -> wgpu::TextureView {
    use wgpu::TextureUsages;
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("bench"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// The pixels of a texture, row by row, after what the encoder recorded has run.
pub fn pixels(
    (device, queue): (&wgpu::Device, &wgpu::Queue),
    mut encoder: wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    aspect: wgpu::TextureAspect,
) -> Result<Vec<u8>, DeviceError> {
    let texture = view.texture();
    let bytes = texture.format().block_copy_size(Some(aspect)).unwrap_or(1) * texture.width();
    let row = bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("bench"),
        size: u64::from(row * texture.height()),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    encoder.copy_texture_to_buffer(
        wgpu::TexelCopyTextureInfo { aspect, ..texture.as_image_copy() },
        wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
        texture.size(),
    );
    queue.submit([encoder.finish()]);
    let all: Vec<u8> = read_back_vec(device, queue, &buffer)?;
    Ok(all.chunks(row as usize).flat_map(|line| &line[..bytes as usize]).copied().collect())
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
