//! Parts that every host program has: a device, something to draw into, a way to see it. Nothing here is Rimline's.
#![allow(dead_code, reason = "each example uses its part")]

use rimline::gpu::read_back_vec;
use rimline::wgpu;

/// A device and a picture to draw into, without a window.
pub(crate) struct Canvas {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    /// Width and height.
    pub(crate) size: [u32; 2],
    target: wgpu::Texture,
}

/// Options in which the pipelines of the examples differ.
pub(crate) struct PipelineOptions<'a> {
    pub(crate) layouts: &'a [&'a wgpu::BindGroupLayout],
    pub(crate) wgsl: &'a str,
    /// Vertex, fragment.
    pub(crate) entry_points: [&'a str; 2],
    pub(crate) topology: wgpu::PrimitiveTopology,
    pub(crate) format: wgpu::TextureFormat,
    pub(crate) blend: Option<wgpu::BlendState>,
    pub(crate) depth_stencil: Option<wgpu::DepthStencilState>,
}

impl Canvas {
    /// The picture's format.
    pub(crate) const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

    /// A square one.
    pub(crate) fn new(size: u32) -> Result<Self, Box<dyn std::error::Error>> {
        Self::of_size([size; 2])
    }

    /// `width` is a multiple of 64, so that rows of pixels can be copied.
    pub(crate) fn of_size([width, height]: [u32; 2]) -> Result<Self, Box<dyn std::error::Error>> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()))?;
        let target = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("canvas"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: Self::FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        Ok(Self { device, queue, size: [width, height], target })
    }

    /// A storage buffer with these contents.
    pub(crate) fn storage(&self, contents: &[u8]) -> wgpu::Buffer {
        let buffer = self.buffer(contents.len() as u64);
        self.queue.write_buffer(&buffer, 0, contents);
        buffer
    }

    /// A uniform buffer with these contents.
    pub(crate) fn uniform(&self, contents: &[u8]) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let size = contents.len() as u64;
        let descriptor = wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
        let buffer = self.device.create_buffer(&descriptor);
        self.queue.write_buffer(&buffer, 0, contents);
        buffer
    }

    fn buffer(&self, size: u64) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        self.device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
    }

    /// An attachment of so many layers that shaders may read.
    pub(crate) fn target(&self, [width, height]: [u32; 2], layers: u32, format: wgpu::TextureFormat) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        })
    }

    /// A layout whose bindings every render stage sees.
    pub(crate) fn layout(&self, types: &[wgpu::BindingType]) -> wgpu::BindGroupLayout {
        let visibility = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let entry = |(binding, &ty)| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
        let entries: Vec<_> = (0..).zip(types).map(entry).collect();
        self.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries })
    }

    /// A bind group with these resources.
    pub(crate) fn group(
        &self,
        layout: &wgpu::BindGroupLayout,
        resources: &[wgpu::BindingResource<'_>],
    ) -> wgpu::BindGroup {
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
    }

    /// A pipeline that draws lines with `wgsl`'s entry points `line` and `ink`.
    pub(crate) fn line_pipeline(&self, layout: &wgpu::BindGroupLayout, wgsl: &str) -> wgpu::RenderPipeline {
        self.pipeline(&PipelineOptions {
            layouts: &[layout],
            wgsl,
            entry_points: ["line", "ink"],
            topology: wgpu::PrimitiveTopology::LineList,
            format: Self::FORMAT,
            blend: None,
            depth_stencil: None,
        })
    }

    /// A render pipeline onto one colour target.
    pub(crate) fn pipeline(&self, options: &PipelineOptions<'_>) -> wgpu::RenderPipeline {
        let source = wgpu::ShaderSource::Wgsl(options.wgsl.into());
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
        let layouts: Vec<_> = options.layouts.iter().map(|&layout| Some(layout)).collect();
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &layouts,
            immediate_size: 0,
        });
        let [vertex, fragment] = options.entry_points;
        let PipelineOptions { topology, format, blend, .. } = *options;
        let write_mask = wgpu::ColorWrites::ALL;
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(fragment),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(vertex),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState { topology, ..wgpu::PrimitiveState::default() },
            depth_stencil: options.depth_stencil.clone(),
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(fragment),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(wgpu::ColorTargetState { format, blend, write_mask })],
            }),
            multiview_mask: None,
            cache: None,
        })
    }

    /// Draws with `record` into the cleared picture.
    pub(crate) fn draw<T>(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        record: impl FnOnce(&mut wgpu::RenderPass<'_>) -> T,
    ) -> T {
        let view = self.target.create_view(&wgpu::TextureViewDescriptor::default());
        record(&mut encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("canvas"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::WHITE), store: wgpu::StoreOp::Store },
            })],
            ..wgpu::RenderPassDescriptor::default()
        }))
    }

    /// Submits and writes the picture.
    pub(crate) fn save(&self, encoder: wgpu::CommandEncoder, path: &str) -> Result<(), Box<dyn std::error::Error>> {
        let [width, height] = self.size;
        let pixels = self.pixels(encoder)?;
        let mut image = png::Encoder::new(std::fs::File::create(path)?, width, height);
        image.set_color(png::ColorType::Rgba);
        image.write_header()?.write_image_data(&pixels)?;
        println!("{path}");
        Ok(())
    }

    /// Submits and reads the picture, four bytes a pixel.
    pub(crate) fn pixels(&self, mut encoder: wgpu::CommandEncoder) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
        let [width, height] = self.size;
        let pixels = self.buffer(u64::from(4 * width * height));
        let layout = wgpu::TexelCopyBufferLayout { bytes_per_row: Some(4 * width), ..Default::default() };
        let copy = wgpu::TexelCopyBufferInfo { buffer: &pixels, layout };
        encoder.copy_texture_to_buffer(self.target.as_image_copy(), copy, self.target.size());
        self.queue.submit([encoder.finish()]);
        Ok(read_back_vec(&self.device, &self.queue, &pixels)?)
    }
}
