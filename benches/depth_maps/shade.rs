//! The end of a frame: black where the stencil is not 0, or where a lookup in the map finds shadow.

use glam::Mat4;
use rimline::ShadowCamera;

use crate::stage::{Bench, EYE, Target};

const SHADER: &str = "
@group(0) @binding(0) var eye_depth: texture_2d<f32>;
@group(0) @binding(1) var map: texture_2d<f32>;
// From the eye's device coordinates to the light's.
@group(0) @binding(2) var<uniform> to_light: mat4x4<f32>;
@vertex fn everywhere(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(select(-1.0, 3.0, vertex == 1u), select(-1.0, 3.0, vertex == 2u), 0.5, 1.0);
}
@fragment fn black() -> @location(0) vec4<f32> {
  return vec4<f32>(0.0, 0.0, 0.0, 1.0);
}
@fragment fn lookup(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
  let depth = textureLoad(eye_depth, vec2<i32>(at.xy), 0).x;
  let ndc = 2.0 * at.xy / vec2<f32>(textureDimensions(eye_depth)) - 1.0;
  let seen = to_light * vec4<f32>(ndc.x, -ndc.y, depth, 1.0);
  let point = seen.xyz / seen.w;
  let texel = (0.5 + 0.5 * vec2<f32>(point.x, -point.y)) * vec2<f32>(textureDimensions(map));
  if (depth == 0.0 || point.z < textureLoad(map, vec2<i32>(texel), 0).x + 0.001) {
    discard;
  }
  return vec4<f32>(0.0, 0.0, 0.0, 1.0);
}
";

const COLOR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

pub(crate) struct Shade {
    black: wgpu::RenderPipeline,
    lookup: wgpu::RenderPipeline,
    color: wgpu::TextureView,
}

impl Shade {
    pub(crate) fn new(bench: &Bench, side: u32) -> Self {
        let module = bench.gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("shade"),
            source: wgpu::ShaderSource::Wgsl(SHADER.into()),
        });
        let unequal =
            wgpu::StencilFaceState { compare: wgpu::CompareFunction::NotEqual, ..wgpu::StencilFaceState::IGNORE };
        let stencil = wgpu::DepthStencilState {
            format: EYE,
            depth_write_enabled: Some(false),
            depth_compare: Some(wgpu::CompareFunction::Always),
            stencil: wgpu::StencilState { front: unequal, back: unequal, read_mask: 0xff, write_mask: 0 },
            bias: wgpu::DepthBiasState::default(),
        };
        let make = |entry_point, layout, depth_stencil| {
            bench.gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(entry_point),
                layout,
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("everywhere"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(entry_point),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(COLOR.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        let layout = layout(bench);
        let color = bench.gpu.texture(side, COLOR);
        Self {
            black: make("black", None, Some(stencil)),
            lookup: make("lookup", Some(&layout), None),
            color: color.create_view(&wgpu::TextureViewDescriptor::default()),
        }
    }

    fn pass<'a>(
        &self,
        encoder: &'a mut wgpu::CommandEncoder,
        stencil: Option<&wgpu::TextureView>,
    ) -> wgpu::RenderPass<'a> {
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::WHITE), store: wgpu::StoreOp::Store };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.color,
                resolve_target: None,
                ops,
                depth_slice: None,
            })],
            depth_stencil_attachment: stencil.map(|view| wgpu::RenderPassDepthStencilAttachment {
                view,
                depth_ops: None,
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }

    /// Black where the stencil is not 0.
    pub(crate) fn stencil(&self, encoder: &mut wgpu::CommandEncoder, target: &Target) {
        let mut pass = self.pass(encoder, Some(&target.all));
        pass.set_pipeline(&self.black);
        pass.draw(0..3, 0..1);
    }

    /// Black where the map has something nearer to the light.
    pub(crate) fn lookup(&self, encoder: &mut wgpu::CommandEncoder, group: &wgpu::BindGroup) {
        let mut pass = self.pass(encoder, None);
        pass.set_pipeline(&self.lookup);
        pass.set_bind_group(0, group, &[]);
        pass.draw(0..3, 0..1);
    }

    /// Resources that a lookup reads.
    pub(crate) fn group(
        &self,
        bench: &Bench,
        [eye_depth, map]: [&Target; 2],
        [eye, light]: [&ShadowCamera; 2],
    ) -> wgpu::BindGroup {
        let [eye, light] = [eye, light].map(|camera| Mat4::from_cols_array_2d(&camera.view_projection).as_dmat4());
        let matrix = (light * eye.inverse()).as_mat4().to_cols_array();
        let buffer = bench.gpu.buffer(wgpu::BufferUsages::UNIFORM, &matrix);
        let textures = [eye_depth, map].map(|target| wgpu::BindingResource::TextureView(&target.depths));
        let [eye_depth, map] = textures;
        bench.gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("lookup"),
            layout: &self.lookup.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: eye_depth },
                wgpu::BindGroupEntry { binding: 1, resource: map },
                wgpu::BindGroupEntry { binding: 2, resource: buffer.as_entire_binding() },
            ],
        })
    }
}

fn layout(bench: &Bench) -> wgpu::PipelineLayout {
    let device = &bench.gpu.device;
    let float = wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: false },
        view_dimension: wgpu::TextureViewDimension::D2,
        multisampled: false,
    };
    let uniform = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Uniform,
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let visibility = wgpu::ShaderStages::FRAGMENT;
    let entries = [(0, float), (1, float), (2, uniform)];
    let entries = entries.map(|(binding, ty)| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None });
    let group = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries });
    device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("lookup"),
        bind_group_layouts: &[Some(&group)],
        immediate_size: 0,
    })
}
