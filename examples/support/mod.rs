//! What a host program has anyway: a device, something to draw into, a way to see it. Nothing here is Rimline's.

use rimline::gpu::read_back_vec;
use rimline::wgpu;

/// A device and a picture to draw into, without a window.
pub struct Canvas {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub size: u32,
    target: wgpu::Texture,
}

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

impl Canvas {
    pub fn new(size: u32) -> Result<Self, Box<dyn std::error::Error>> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))?;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()))?;
        let target = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("canvas"),
            size: wgpu::Extent3d { width: size, height: size, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        Ok(Self { device, queue, size, target })
    }

    /// A storage buffer with these contents.
    pub fn storage(&self, contents: &[u8]) -> wgpu::Buffer {
        let buffer = self.buffer(contents.len() as u64);
        self.queue.write_buffer(&buffer, 0, contents);
        buffer
    }

    fn buffer(&self, size: u64) -> wgpu::Buffer {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        self.device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
    }

    /// A pipeline that draws lines with `wgsl`'s entry points `line` and `ink`.
    pub fn line_pipeline(&self, layout: &wgpu::BindGroupLayout, wgsl: String) -> wgpu::RenderPipeline {
        let source = wgpu::ShaderSource::Wgsl(wgsl.into());
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("lines"), source });
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("lines"),
            bind_group_layouts: &[Some(layout)],
            immediate_size: 0,
        });
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("lines"),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("line"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState {
                topology: wgpu::PrimitiveTopology::LineList,
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("ink"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(FORMAT.into())],
            }),
            multiview_mask: None,
            cache: None,
        })
    }

    /// Draws with `record` into the cleared picture.
    pub fn draw(&self, encoder: &mut wgpu::CommandEncoder, record: impl FnOnce(&mut wgpu::RenderPass<'_>)) {
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
        }));
    }

    /// Submits and writes the picture.
    pub fn save(&self, mut encoder: wgpu::CommandEncoder, path: &str) -> Result<(), Box<dyn std::error::Error>> {
        let pixels = self.buffer(u64::from(4 * self.size * self.size));
        let layout = wgpu::TexelCopyBufferLayout { bytes_per_row: Some(4 * self.size), ..Default::default() };
        let copy = wgpu::TexelCopyBufferInfo { buffer: &pixels, layout };
        encoder.copy_texture_to_buffer(self.target.as_image_copy(), copy, self.target.size());
        self.queue.submit([encoder.finish()]);
        let pixels: Vec<u8> = read_back_vec(&self.device, &self.queue, &pixels)?;
        let mut image = png::Encoder::new(std::fs::File::create(path)?, self.size, self.size);
        image.set_color(png::ColorType::Rgba);
        image.write_header()?.write_image_data(&pixels)?;
        println!("{path}");
        Ok(())
    }
}
