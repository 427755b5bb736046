//! Parts that the passes of a picture share: the frame's uniform, and a short way to pipelines.

use rimline::wgpu;
use wgpu::{BlendComponent, BlendFactor, BlendOperation, BlendState, BufferBindingType};

use crate::device::Gpu;

pub(crate) const UNIFORM: wgpu::BindingType = buffer_type(BufferBindingType::Uniform, false);
pub(crate) const UNIFORM_AT_OFFSET: wgpu::BindingType = buffer_type(BufferBindingType::Uniform, true);
pub(crate) const READ_ONLY: wgpu::BindingType = buffer_type(BufferBindingType::Storage { read_only: true }, false);

const fn buffer_type(ty: BufferBindingType, has_dynamic_offset: bool) -> wgpu::BindingType {
    wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None }
}

pub(crate) const ADD: BlendState = blend(BlendFactor::One, BlendFactor::One, BlendOperation::Add);
/// Multiplies the colour of the target by the drawn colour.
pub(crate) const MULTIPLY: BlendState = blend(BlendFactor::Dst, BlendFactor::Zero, BlendOperation::Add);
pub(crate) const LARGEST: BlendState = blend(BlendFactor::One, BlendFactor::One, BlendOperation::Max);

const fn blend(src_factor: BlendFactor, dst_factor: BlendFactor, operation: BlendOperation) -> BlendState {
    let color = BlendComponent { src_factor, dst_factor, operation };
    BlendState { color, alpha: color }
}

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

/// WGSL that every pass knows.
pub(crate) const COMMON: &str = include_str!("common.wgsl");

/// Makes pipelines and bind groups; group 0 is always the frame.
pub(crate) struct PipelineFactory<'a> {
    pub(crate) gpu: &'a Gpu,
    /// WGSL that declares the frame and what every pass knows.
    prelude: String,
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
        Self { name, vertex: name, source, groups, topology, format, blend: None, samples: 1, write, depth: None }
    }

    /// The same over the whole target.
    pub(crate) fn over(
        name: &'static str,
        source: &'a str,
        groups: &'a [&'a wgpu::BindGroupLayout],
        format: wgpu::TextureFormat,
    ) -> Self {
        Self { vertex: "cover", ..Self::new(name, source, groups, format) }
    }

    /// Behind a prelude, which declares group 0.
    pub(crate) fn pipeline(
        &self,
        device: &wgpu::Device,
        prelude: &str,
        frame: Option<&wgpu::BindGroupLayout>,
    ) -> wgpu::RenderPipeline {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(self.name),
            source: wgpu::ShaderSource::Wgsl(format!("{}\n{}", prelude, self.source).into()),
        });
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
                targets: &[Some(wgpu::ColorTargetState {
                    format: self.format,
                    blend: self.blend,
                    write_mask: self.write,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

impl<'a> PipelineFactory<'a> {
    /// `frame` is the uniform that `prelude` declares as group 0, binding 0.
    pub(crate) fn new(gpu: &'a Gpu, prelude: &str, frame: &[u8]) -> Self {
        let frame = gpu.filled("frame", frame, wgpu::BufferUsages::UNIFORM);
        let frame_layout = gpu.layout(wgpu::ShaderStages::VERTEX_FRAGMENT, &[UNIFORM]);
        let frame_group = gpu.group(&frame_layout, &[frame.as_entire_binding()]);
        let prelude = format!("{COMMON}\n{prelude}");
        Self { gpu, prelude, frame_layout, frame_group, frame }
    }

    /// Another frame, for what is submitted from now on.
    pub(crate) fn set_frame(&self, frame: &[u8]) {
        self.gpu.queue.write_buffer(&self.frame, 0, frame);
    }

    pub(crate) fn layout(&self, types: &[wgpu::BindingType]) -> wgpu::BindGroupLayout {
        self.gpu.layout(wgpu::ShaderStages::VERTEX_FRAGMENT, types)
    }

    pub(crate) fn group(
        &self,
        layout: &wgpu::BindGroupLayout,
        resources: &[wgpu::BindingResource<'_>],
    ) -> wgpu::BindGroup {
        self.gpu.group(layout, resources)
    }

    /// A storage buffer with these contents.
    pub(crate) fn buffer(&self, label: &str, contents: &[u8]) -> wgpu::Buffer {
        self.gpu.filled(label, contents, wgpu::BufferUsages::STORAGE)
    }

    /// A uniform buffer with these contents.
    pub(crate) fn uniform(&self, label: &str, contents: &[u8]) -> wgpu::Buffer {
        self.gpu.filled(label, contents, wgpu::BufferUsages::UNIFORM)
    }

    /// Takes a pipeline, the frame and the groups that follow it.
    pub(crate) fn bind(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipeline: &wgpu::RenderPipeline,
        groups: &[&wgpu::BindGroup],
    ) {
        pass.set_pipeline(pipeline);
        for (number, group) in (0..).zip([&self.frame_group].iter().chain(groups)) {
            pass.set_bind_group(number, *group, &[]);
        }
    }

    /// Draws vertices with them.
    pub(crate) fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipeline: &wgpu::RenderPipeline,
        groups: &[&wgpu::BindGroup],
        vertices: u32,
    ) {
        self.bind(pass, pipeline, groups);
        pass.draw(0..vertices, 0..1);
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
        self.gpu.device.create_texture(&wgpu::TextureDescriptor { sample_count: samples, ..plain })
    }

    pub(crate) fn pipeline(&self, pass: &Pass<'_>) -> wgpu::RenderPipeline {
        pass.pipeline(&self.gpu.device, &self.prelude, Some(&self.frame_layout))
    }
}

/// Depth is reversed: what is greater is nearer.
pub(crate) fn depth_state(
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

/// A pass onto one colour target and a depth buffer. Clears both, depth to the infinitely far, or goes on with what is there; a
/// stencil is cleared in any case.
pub(crate) fn color_pass<'e>(
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
            let has_stencil = view.texture().format().has_stencil_aspect();
            wgpu::RenderPassDepthStencilAttachment {
                view,
                depth_ops: Some(wgpu::Operations { load, store }),
                stencil_ops: has_stencil.then_some(wgpu::Operations { load: wgpu::LoadOp::Clear(0), store }),
            }
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    })
}
