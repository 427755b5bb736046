//! Draws everything that is seen: casters and what stands around them.

use rimline::{Light, Matrix3x4, ShadowCamera};
use wgpu::{BufferUsages, LoadOp, Operations, StoreOp, TextureFormat, VertexFormat, VertexStepMode};

use super::{Casters, DEPTH, IDENTITY, Setting};
use crate::gpu::Gpu;
use crate::shapes::Shape;

/// Layout of `Frame` in `surfaces.wgsl`.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Frame {
    view_projection: [[f32; 4]; 4],
    eye: [f32; 4],
    light: [f32; 4],
}

const COLOR: TextureFormat = TextureFormat::Rgba8Unorm;
/// Half the width of the ground, in units of the scene.
const GROUND: f32 = 1e5;

/// Faces that are drawn some times.
pub struct Surface {
    positions: wgpu::Buffer,
    faces: wgpu::Buffer,
    corners: u32,
    /// A matrix for each time.
    matrices: wgpu::Buffer,
    times: u32,
    /// Vertices from each time's first to the next one's.
    stride: u32,
}

impl Surface {
    pub fn new(gpu: &Gpu, shape: &Shape, matrices: &[Matrix3x4]) -> Self {
        Self::of(gpu, gpu.buffer(BufferUsages::VERTEX, &shape.positions), &shape.faces, matrices, 0)
    }

    fn of(gpu: &Gpu, positions: wgpu::Buffer, faces: &[[u32; 3]], matrices: &[Matrix3x4], stride: u32) -> Self {
        Self {
            positions,
            faces: gpu.buffer(BufferUsages::INDEX, faces),
            corners: 3 * faces.len() as u32,
            matrices: gpu.buffer(BufferUsages::VERTEX, matrices),
            times: matrices.len() as u32,
            stride,
        }
    }
}

/// A pass of [`Surfaces::pass`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Depths, and colours where there are any.
    Depth,
    /// Light where the stencil is 0.
    Light,
}

pub struct Surfaces {
    frame: wgpu::Buffer,
    group: wgpu::BindGroup,
    pipelines: [wgpu::RenderPipeline; 2],
    /// `None`: depths alone are drawn.
    color: Option<wgpu::TextureView>,
    all: Vec<Surface>,
}

impl Surfaces {
    /// Surfaces that are lit, in pictures of this size, or of depths alone.
    pub fn new(gpu: &Gpu, lit: Option<u32>, surfaces: Vec<Surface>) -> Self {
        let device = &gpu.device;
        let frame = gpu.empty(BufferUsages::STORAGE | BufferUsages::COPY_DST, size_of::<Frame>() as u64);
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("surfaces"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only: true },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("surfaces"),
            layout: &layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: frame.as_entire_binding() }],
        });
        let has_color = lit.is_some();
        let pipelines = [Pass::Depth, Pass::Light].map(|pass| pipeline(device, &layout, pass, has_color));
        let color = lit.map(|size| gpu.texture(size, COLOR).create_view(&wgpu::TextureViewDescriptor::default()));
        Self { frame, group, pipelines, color, all: surfaces }
    }

    /// The surfaces that the eye sees of a setting. `deformed` are the positions of casters that walk.
    pub fn of(gpu: &Gpu, setting: &Setting, deformed: Option<&wgpu::Buffer>) -> Self {
        let mut surfaces = Vec::new();
        match (&setting.casters, deformed) {
            (Casters::Rigid { shapes, placed }, _) => {
                for (number, shape) in shapes.iter().enumerate() {
                    let matrices = placed.iter().filter(|(of, _)| *of == number).map(|(_, matrix)| *matrix);
                    surfaces.push(Surface::new(gpu, shape, &matrices.collect::<Vec<_>>()));
                }
            }
            (Casters::Walking { model, .. }, Some(deformed)) => {
                if let Some(geometry) = model.geometries().first() {
                    let matrices = vec![IDENTITY; model.instances().len()];
                    let stride = geometry.positions().len() as u32;
                    surfaces.push(Surface::of(gpu, deformed.clone(), geometry.faces(), &matrices, stride));
                }
            }
            (Casters::Walking { .. }, None) => {}
        }
        if let Some(height) = setting.ground {
            let corners = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
            let positions = corners.map(|[x, z]: [f32; 2]| [GROUND * x, height, GROUND * z]).into();
            let ground = Shape { positions, faces: vec![[0, 1, 2], [0, 2, 3]] };
            surfaces.push(Surface::new(gpu, &ground, &[IDENTITY]));
        }
        let all = Self::new(gpu, None, surfaces);
        all.set(gpu, &setting.camera, None);
        all
    }

    /// The camera and the light of the passes to come.
    pub fn set(&self, gpu: &Gpu, camera: &ShadowCamera, light: Option<Light>) {
        let [x, y, z] = camera.origin;
        let [u, v, w] = light.map_or([0.0; 3], |light| light.xyz);
        let light = [u - x, v - y, w - z, 0.0];
        let frame = Frame { view_projection: camera.view_projection, eye: [x, y, z, 0.0], light };
        gpu.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&frame));
    }

    /// Records a pass. Depth is reversed: 0 is farthest.
    pub fn pass(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        depth: &wgpu::TextureView,
        which: Pass,
        timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        let is_first = which == Pass::Depth;
        let store = StoreOp::Store;
        let color = self.color.as_ref().map(|view| wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: Operations { load: if is_first { LoadOp::Clear(wgpu::Color::BLACK) } else { LoadOp::Load }, store },
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("surfaces"),
            color_attachments: if color.is_some() { std::slice::from_ref(&color) } else { &[] },
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: depth,
                depth_ops: Some(Operations { load: if is_first { LoadOp::Clear(0.0) } else { LoadOp::Load }, store }),
                stencil_ops: Some(Operations { load: if is_first { LoadOp::Clear(0) } else { LoadOp::Load }, store }),
            }),
            timestamp_writes,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        pass.set_pipeline(&self.pipelines[usize::from(!is_first)]);
        pass.set_bind_group(0, &self.group, &[]);
        for Surface { positions, faces, corners, matrices, times, stride } in &self.all {
            pass.set_vertex_buffer(0, positions.slice(..));
            pass.set_vertex_buffer(1, matrices.slice(..));
            pass.set_index_buffer(faces.slice(..), wgpu::IndexFormat::Uint32);
            if *stride == 0 {
                pass.draw_indexed(0..*corners, 0, 0..*times);
            } else {
                for time in 0..*times {
                    pass.draw_indexed(0..*corners, (time * stride) as i32, time..time + 1);
                }
            }
        }
    }
}

fn pipeline(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    pass: Pass,
    has_color: bool,
) -> wgpu::RenderPipeline {
    let source = wgpu::ShaderSource::Wgsl(include_str!("surfaces.wgsl").into());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("surfaces"), source });
    let attribute = |shader_location: u32, offset, format| wgpu::VertexAttribute { format, offset, shader_location };
    let rows: [_; 3] = std::array::from_fn(|row| attribute(1 + row as u32, 16 * row as u64, VertexFormat::Float32x4));
    let position = [attribute(0, 0, VertexFormat::Float32x3)];
    let buffers = [
        Some(wgpu::VertexBufferLayout { array_stride: 12, step_mode: VertexStepMode::Vertex, attributes: &position }),
        Some(wgpu::VertexBufferLayout { array_stride: 48, step_mode: VertexStepMode::Instance, attributes: &rows }),
    ];
    let (entry_point, is_depth) = (if pass == Pass::Depth { "ambient" } else { "lit" }, pass == Pass::Depth);
    let add = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    let target = Some(wgpu::ColorTargetState {
        format: COLOR,
        blend: (!is_depth).then_some(wgpu::BlendState { color: add, alpha: add }),
        write_mask: wgpu::ColorWrites::ALL,
    });
    // Each lit pixel counts up, so that faces that coincide add their light once.
    let face = if is_depth {
        wgpu::StencilFaceState::IGNORE
    } else {
        wgpu::StencilFaceState {
            compare: wgpu::CompareFunction::Equal,
            fail_op: wgpu::StencilOperation::Keep,
            depth_fail_op: wgpu::StencilOperation::Keep,
            pass_op: wgpu::StencilOperation::IncrementClamp,
        }
    };
    let compare = if is_depth { wgpu::CompareFunction::Greater } else { wgpu::CompareFunction::Equal };
    let compilation_options = wgpu::PipelineCompilationOptions::default;
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("surfaces"),
        layout: Some(&device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("surfaces"),
            bind_group_layouts: &[Some(layout)],
            immediate_size: 0,
        })),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("surface"),
            compilation_options: compilation_options(),
            buffers: &buffers,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(is_depth),
            depth_compare: Some(compare),
            stencil: wgpu::StencilState { front: face, back: face, read_mask: !0, write_mask: !0 },
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: has_color.then(|| wgpu::FragmentState {
            module: &module,
            entry_point: Some(entry_point),
            compilation_options: compilation_options(),
            targets: std::slice::from_ref(&target),
        }),
        multiview_mask: None,
        cache: None,
    })
}
