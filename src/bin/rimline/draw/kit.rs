//! What the passes of the picture share: the frame's uniform, and a short way to pipelines.

use rimline::wgpu;

use super::camera::Camera;

/// As in `frame.wgsl`.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Frame {
    eye: [f32; 3],
    near: f32,
    right: [f32; 3],
    scale_x: f32,
    up: [f32; 3],
    scale_y: f32,
    forward: [f32; 3],
    half_line: f32,
    size: [f32; 2],
    extent: f32,
    ground: f32,
    ground_centre: [f32; 2],
    ground_half: f32,
    shadow_height: f32,
}

impl Frame {
    pub(super) fn new(camera: &Camera, size: [u32; 2], bounds: &rimline::mesh::Bounds) -> Self {
        let extent = extent(bounds);
        let [min, max] = [bounds.min, bounds.max];
        let middle = |axis: usize| min[axis] + 0.5 * (max[axis] - min[axis]);
        Self {
            eye: camera.eye.into(),
            near: camera.near,
            right: camera.right.into(),
            scale_x: camera.scale[0],
            up: camera.up.into(),
            scale_y: camera.scale[1],
            forward: camera.forward.into(),
            // 2.75 pixels wide at 960 pixels of height, and never too thin to see.
            half_line: (size[1] as f32 / 700.0).clamp(0.9, 4.0),
            size: size.map(|pixels| pixels as f32),
            extent,
            ground: min[1],
            ground_centre: [middle(0), middle(2)],
            ground_half: 0.5 * (max[0] - min[0]).max(max[2] - min[2]) + 0.3 * extent,
            shadow_height: 0.3 * extent,
        }
    }

    /// The eye is above the ground, so the ground is seen.
    pub(super) fn sees_ground(&self) -> bool {
        self.eye[1] > self.ground
    }
}

/// The largest side of the bounds, or 1 for a single point.
pub(super) fn extent(bounds: &rimline::mesh::Bounds) -> f32 {
    let sides = (0..3).map(|axis| bounds.max[axis] - bounds.min[axis]);
    let largest = sides.fold(0.0, f32::max);
    if largest > 0.0 { largest } else { 1.0 }
}

/// Makes pipelines and bind groups; group 0 is always the frame.
pub(super) struct Kit<'a> {
    pub(super) device: &'a wgpu::Device,
    frame_layout: wgpu::BindGroupLayout,
    pub(super) frame_group: wgpu::BindGroup,
}

/// A pipeline without what they all have alike.
pub(super) struct Pass<'a> {
    pub(super) name: &'static str,
    /// After `frame.wgsl`; entry points are the name with `_vertex` and `_fragment`.
    pub(super) source: &'a str,
    /// Groups 1 and on.
    pub(super) groups: &'a [&'a wgpu::BindGroupLayout],
    pub(super) topology: wgpu::PrimitiveTopology,
    pub(super) format: wgpu::TextureFormat,
    pub(super) blend: Option<wgpu::BlendState>,
    pub(super) samples: u32,
    /// Whether depth is written; `None` without a depth buffer.
    pub(super) depth: Option<bool>,
    pub(super) constants: &'a [(&'a str, f64)],
}

impl<'a> Kit<'a> {
    pub(super) fn new(device: &'a wgpu::Device, queue: &wgpu::Queue, frame: &Frame) -> Self {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: size_of::<Frame>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        queue.write_buffer(&buffer, 0, bytemuck::bytes_of(frame));
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let frame_layout = layout(device, &[uniform]);
        let frame_group = group(device, &frame_layout, &[buffer.as_entire_binding()]);
        Self { device, frame_layout, frame_group }
    }

    pub(super) fn layout(&self, types: &[wgpu::BindingType]) -> wgpu::BindGroupLayout {
        layout(self.device, types)
    }

    pub(super) fn group(
        &self,
        layout: &wgpu::BindGroupLayout,
        resources: &[wgpu::BindingResource<'_>],
    ) -> wgpu::BindGroup {
        group(self.device, layout, resources)
    }

    /// A storage buffer with these contents.
    pub(super) fn buffer(&self, queue: &wgpu::Queue, label: &str, contents: &[u8]) -> wgpu::Buffer {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: (contents.len() as u64).max(16),
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        queue.write_buffer(&buffer, 0, contents);
        buffer
    }

    pub(super) fn target(
        &self,
        label: &str,
        [width, height]: [u32; 2],
        format: wgpu::TextureFormat,
        samples: u32,
        usage: wgpu::TextureUsages,
    ) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: samples,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        })
    }

    pub(super) fn pipeline(&self, pass: &Pass<'_>) -> wgpu::RenderPipeline {
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(pass.name),
            source: wgpu::ShaderSource::Wgsl(format!("{}\n{}", include_str!("frame.wgsl"), pass.source).into()),
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
                entry_point: Some(&format!("{}_vertex", pass.name)),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState { topology: pass.topology, ..Default::default() },
            depth_stencil: pass.depth.map(|write| wgpu::DepthStencilState {
                format: wgpu::TextureFormat::Depth32Float,
                depth_write_enabled: Some(write),
                depth_compare: Some(if write { wgpu::CompareFunction::Greater } else { wgpu::CompareFunction::Always }),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count: pass.samples, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(&format!("{}_fragment", pass.name)),
                compilation_options,
                targets: &[Some(wgpu::ColorTargetState {
                    format: pass.format,
                    blend: pass.blend,
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

fn layout(device: &wgpu::Device, types: &[wgpu::BindingType]) -> wgpu::BindGroupLayout {
    let entries: Vec<_> = (0..)
        .zip(types)
        .map(|(binding, &ty)| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty,
            count: None,
        })
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
