//! Parts that all passes of a picture share: the uniform of the frame, and short functions that make pipelines, textures
//! and passes.

use wgpu::{BlendComponent, BlendFactor, BlendOperation, BlendState};

use crate::bindings::{UNIFORM, filled, group, layout};

/// Adds the drawn colour to that of the target.
pub(crate) const ADD: BlendState = blend(BlendFactor::One, BlendFactor::One, BlendOperation::Add);
/// Multiplies the colour of the target by the drawn colour.
pub const MULTIPLY: BlendState = blend(BlendFactor::Dst, BlendFactor::Zero, BlendOperation::Add);
/// Takes the larger of the drawn colour and that of the target, channel by channel.
pub const LARGEST: BlendState = blend(BlendFactor::One, BlendFactor::One, BlendOperation::Max);

const fn blend(src_factor: BlendFactor, dst_factor: BlendFactor, operation: BlendOperation) -> BlendState {
    let color = BlendComponent { src_factor, dst_factor, operation };
    BlendState { color, alpha: color }
}

/// A texture of two dimensions, with one layer, one level and one sample.
pub fn plain_texture(
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

/// A view of a whole texture.
pub fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// WGSL that each prelude begins with: functions, without bindings.
pub const COMMON: &str = include_str!("common.wgsl");

/// Makes pipelines whose group 0 is the frame, and what they bind.
#[derive(Debug)]
pub struct PipelineFactory {
    /// The device.
    pub device: wgpu::Device,
    queue: wgpu::Queue,
    /// [`COMMON`], and the WGSL that declares the frame.
    prelude: String,
    frame_layout: wgpu::BindGroupLayout,
    /// Group 0.
    pub frame_group: wgpu::BindGroup,
    frame: wgpu::Buffer,
}

/// The description of a render pipeline. Settings that are not here are the same in all pipelines.
#[derive(Clone)]
pub struct PipelineDescriptor<'a> {
    /// Its label. Its fragment entry point, needed also without a colour target, is this name with `_fragment`.
    pub name: &'static str,
    /// Its vertex entry point is this name with `_vertex`; often the same name.
    pub vertex: &'a str,
    /// Its WGSL, which follows the prelude.
    pub source: &'a str,
    /// The layouts of the groups after the frame's: from group 1 on, or from 0 on without a frame.
    pub groups: &'a [&'a wgpu::BindGroupLayout],
    /// The primitives that vertices make.
    pub topology: wgpu::PrimitiveTopology,
    /// The format of the colour target, if there is one.
    pub format: Option<wgpu::TextureFormat>,
    /// How colours are blended, if they are.
    pub blend: Option<wgpu::BlendState>,
    /// Samples a pixel.
    pub samples: u32,
    /// The channels that are written.
    pub write: wgpu::ColorWrites,
    /// Depth and stencil, if there are any.
    pub depth: Option<wgpu::DepthStencilState>,
}

impl<'a> PipelineDescriptor<'a> {
    /// Draws triangles that replace the colours of a target with one sample a pixel.
    pub fn new(
        name: &'static str,
        source: &'a str,
        groups: &'a [&'a wgpu::BindGroupLayout],
        format: impl Into<Option<wgpu::TextureFormat>>,
    ) -> Self {
        let (topology, write, format) = (wgpu::PrimitiveTopology::TriangleList, wgpu::ColorWrites::ALL, format.into());
        Self { name, vertex: name, source, groups, topology, format, blend: None, samples: 1, write, depth: None }
    }

    /// The same with one triangle that covers the target: draw three vertices.
    pub fn over(
        name: &'static str,
        source: &'a str,
        groups: &'a [&'a wgpu::BindGroupLayout],
        format: impl Into<Option<wgpu::TextureFormat>>,
    ) -> Self {
        Self { vertex: "cover", ..Self::new(name, source, groups, format) }
    }

    /// The pipeline. `prelude` is the WGSL before its own: with [`COMMON`] for [`Self::over`], and with group 0 if
    /// `frame` is its layout.
    pub fn pipeline(
        &self,
        device: &wgpu::Device,
        prelude: &str,
        frame: Option<&wgpu::BindGroupLayout>,
    ) -> wgpu::RenderPipeline {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(self.name),
            source: wgpu::ShaderSource::Wgsl(format!("{}\n{}", prelude, self.source).into()),
        });
        let target = |format| wgpu::ColorTargetState { format, blend: self.blend, write_mask: self.write };
        let groups: Vec<_> = frame.into_iter().chain(self.groups.iter().copied()).map(Some).collect();
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(self.name),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.name),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(&format!("{}_vertex", self.vertex)),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState { topology: self.topology, ..Default::default() },
            depth_stencil: self.depth.clone(),
            multisample: wgpu::MultisampleState { count: self.samples, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(&format!("{}_fragment", self.name)),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: self.format.map(|format| Some(target(format))).as_slice(),
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

impl PipelineFactory {
    /// `frame` is the uniform that `prelude` declares as group 0, binding 0.
    pub fn new((device, queue): (&wgpu::Device, &wgpu::Queue), prelude: &str, frame: &[u8]) -> Self {
        let frame = filled((device, queue), "frame", frame, wgpu::BufferUsages::UNIFORM);
        let frame_layout = layout(device, wgpu::ShaderStages::VERTEX_FRAGMENT, &[UNIFORM]);
        let frame_group = group(device, &frame_layout, &[frame.as_entire_binding()]);
        let prelude = format!("{COMMON}\n{prelude}");
        Self { device: device.clone(), queue: queue.clone(), prelude, frame_layout, frame_group, frame }
    }

    /// Overwrites the frame, for what is submitted from now on.
    pub fn set_frame(&self, frame: &[u8]) {
        self.write(&self.frame, 0, frame);
    }

    /// Overwrites a part of a buffer, for what is submitted from now on.
    pub fn write(&self, buffer: &wgpu::Buffer, offset: u64, contents: &[u8]) {
        self.queue.write_buffer(buffer, offset, contents);
    }

    /// A layout for vertex and fragment shaders.
    pub fn layout(&self, types: &[wgpu::BindingType]) -> wgpu::BindGroupLayout {
        layout(&self.device, wgpu::ShaderStages::VERTEX_FRAGMENT, types)
    }

    /// Binds resources in the order of a layout.
    pub fn group(&self, layout: &wgpu::BindGroupLayout, resources: &[wgpu::BindingResource<'_>]) -> wgpu::BindGroup {
        group(&self.device, layout, resources)
    }

    /// A storage buffer with these contents.
    pub fn buffer(&self, label: &str, contents: &[u8]) -> wgpu::Buffer {
        filled((&self.device, &self.queue), label, contents, wgpu::BufferUsages::STORAGE)
    }

    /// A uniform buffer with these contents.
    pub fn uniform(&self, label: &str, contents: &[u8]) -> wgpu::Buffer {
        filled((&self.device, &self.queue), label, contents, wgpu::BufferUsages::UNIFORM)
    }

    /// Sets a pipeline, the frame and the groups that follow it.
    pub fn bind(&self, pass: &mut wgpu::RenderPass<'_>, pipeline: &wgpu::RenderPipeline, groups: &[&wgpu::BindGroup]) {
        pass.set_pipeline(pipeline);
        for (number, group) in (0..).zip([&self.frame_group].iter().chain(groups)) {
            pass.set_bind_group(number, *group, &[]);
        }
    }

    /// The same, and draws so many vertices once.
    pub fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipeline: &wgpu::RenderPipeline,
        groups: &[&wgpu::BindGroup],
        vertices: u32,
    ) {
        self.bind(pass, pipeline, groups);
        pass.draw(0..vertices, 0..1);
    }

    /// A texture that passes draw into, of one layer and level.
    pub fn target(
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

    /// A pipeline with the prelude and the frame.
    pub fn pipeline(&self, descriptor: &PipelineDescriptor<'_>) -> wgpu::RenderPipeline {
        descriptor.pipeline(&self.device, &self.prelude, Some(&self.frame_layout))
    }
}

/// A state of depth and stencil, with the same stencil for both sides of faces. Depth is reversed: greater depths are nearer.
pub fn depth_state(
    format: wgpu::TextureFormat,
    write: bool,
    compare: wgpu::CompareFunction,
    face: wgpu::StencilFaceState,
) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format,
        depth_write_enabled: Some(write),
        depth_compare: Some(compare),
        stencil: wgpu::StencilState { front: face, back: face, read_mask: 0xff, write_mask: 0xff },
        bias: wgpu::DepthBiasState::default(),
    }
}

/// A pass onto one colour target, and a depth buffer if there is one. With a colour to `clear` to, it also clears depth to 0,
/// the farthest, and the stencil to 0. Without, it keeps all of them.
pub fn color_pass<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    label: &str,
    (view, resolve_target): (&wgpu::TextureView, Option<&wgpu::TextureView>),
    clear: Option<wgpu::Color>,
    depth: Option<&wgpu::TextureView>,
) -> wgpu::RenderPass<'e> {
    let store = wgpu::StoreOp::Store;
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target,
            ops: wgpu::Operations { load: clear.map_or(wgpu::LoadOp::Load, wgpu::LoadOp::Clear), store },
        })],
        depth_stencil_attachment: depth.map(|view| {
            let load = clear.map_or(wgpu::LoadOp::Load, |_| wgpu::LoadOp::Clear(0.0));
            let load_stencil = clear.map_or(wgpu::LoadOp::Load, |_| wgpu::LoadOp::Clear(0));
            let has_stencil = view.texture().format().has_stencil_aspect();
            wgpu::RenderPassDepthStencilAttachment {
                view,
                depth_ops: Some(wgpu::Operations { load, store }),
                stencil_ops: has_stencil.then_some(wgpu::Operations { load: load_stencil, store }),
            }
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    })
}
