//! Draws the depth of everything: casters and the ground.

use rimline::{Matrix3x4, wgpu};
use wgpu::{BufferUsages, LoadOp, VertexFormat, VertexStepMode};

use super::super::casters::measure::DEPTH;
use super::setting::{Casters, Setting};
use crate::device::Gpu;

/// Layout of `Camera` in `depth.wgsl`.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Camera {
    view_projection: [[f32; 4]; 4],
    origin: [f32; 4],
}

/// Half the width of the ground, in units of the scene.
const GROUND: f32 = 1e5;
const UNPLACED: Matrix3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

pub(super) struct Receivers {
    pipeline: wgpu::RenderPipeline,
    camera: wgpu::BindGroup,
    bodies: Vec<Body>,
}

/// Faces that are drawn some times.
struct Body {
    positions: wgpu::Buffer,
    faces: wgpu::Buffer,
    corners: u32,
    /// A matrix for each time.
    matrices: wgpu::Buffer,
    times: u32,
    /// Vertices from each time's first to the next one's.
    stride: u32,
}

impl Receivers {
    /// `deformed` are the positions of figures that walk.
    pub(super) fn new(gpu: &Gpu, setting: &Setting, deformed: Option<&wgpu::Buffer>) -> Self {
        let device = &gpu.device;
        let filled = |contents: &[u8], usage| {
            let buffer = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("receivers"),
                size: contents.len().max(16) as u64,
                usage: usage | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            gpu.queue.write_buffer(&buffer, 0, contents);
            buffer
        };
        let body = |positions: wgpu::Buffer, faces: &[[u32; 3]], matrices: &[Matrix3x4], stride: u32| Body {
            positions,
            faces: filled(bytemuck::cast_slice(faces), BufferUsages::INDEX),
            corners: 3 * faces.len() as u32,
            matrices: filled(bytemuck::cast_slice(matrices), BufferUsages::VERTEX),
            times: matrices.len() as u32,
            stride,
        };
        let vertices = |positions: &[[f32; 3]]| filled(bytemuck::cast_slice(positions), BufferUsages::VERTEX);
        let mut bodies = Vec::new();
        match (&setting.casters, deformed) {
            (Casters::Rigid { shapes, placed }, _) => {
                for (number, shape) in shapes.iter().enumerate() {
                    let matrices = placed.iter().filter(|(of, _)| *of == number).map(|(_, matrix)| *matrix);
                    let matrices: Vec<_> = matrices.collect();
                    bodies.push(body(vertices(&shape.positions), &shape.faces, &matrices, 0));
                }
            }
            (Casters::Walking(walk), Some(deformed)) => {
                if let Some(geometry) = walk.model.geometries().first() {
                    let matrices = vec![UNPLACED; walk.model.instances().len()];
                    let stride = geometry.positions().len() as u32;
                    bodies.push(body(deformed.clone(), geometry.faces(), &matrices, stride));
                }
            }
            (Casters::Walking(_), None) => {}
        }
        if let Some(height) = setting.ground {
            let corners = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
            let corners = corners.map(|[x, z]: [f32; 2]| [GROUND * x, height, GROUND * z]);
            bodies.push(body(vertices(&corners), &[[0, 1, 2], [0, 2, 3]], &[UNPLACED], 0));
        }
        let [x, y, z] = setting.camera.origin;
        let camera = Camera { view_projection: setting.camera.view_projection, origin: [x, y, z, 0.0] };
        let pipeline = pipeline(device);
        let camera = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("receivers"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: filled(bytemuck::bytes_of(&camera), BufferUsages::STORAGE).as_entire_binding(),
            }],
        });
        Self { pipeline, camera, bodies }
    }

    /// A pass that leaves the depths of the nearest surfaces.
    pub(super) fn draw(&self, encoder: &mut wgpu::CommandEncoder, depth: &wgpu::TextureView) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("receivers"),
            color_attachments: &[],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: depth,
                // Depth is reversed: 0 is farthest.
                depth_ops: Some(wgpu::Operations { load: LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
                stencil_ops: Some(wgpu::Operations { load: LoadOp::Clear(0), store: wgpu::StoreOp::Store }),
            }),
            timestamp_writes: None,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.camera, &[]);
        for Body { positions, faces, corners, matrices, times, stride } in &self.bodies {
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

fn pipeline(device: &wgpu::Device) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("receivers"),
        source: wgpu::ShaderSource::Wgsl(include_str!("depth.wgsl").into()),
    });
    let attribute = |shader_location: u32, offset, format| wgpu::VertexAttribute { format, offset, shader_location };
    let rows: [_; 3] = std::array::from_fn(|row| attribute(1 + row as u32, 16 * row as u64, VertexFormat::Float32x4));
    let position = [attribute(0, 0, VertexFormat::Float32x3)];
    let buffers = [
        Some(wgpu::VertexBufferLayout { array_stride: 12, step_mode: VertexStepMode::Vertex, attributes: &position }),
        Some(wgpu::VertexBufferLayout { array_stride: 48, step_mode: VertexStepMode::Instance, attributes: &rows }),
    ];
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("receivers"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("surface"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &buffers,
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: None,
        multiview_mask: None,
        cache: None,
    })
}
