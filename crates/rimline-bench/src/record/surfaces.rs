//! Draws everything that is seen: casters and what stands around them.

use rimline::gpu::StageTimer;
use rimline::{Matrix3x4, ShadowCamera};
use wgpu::{BufferUsages, LoadOp, TextureFormat, VertexStepMode};

use super::{Casters, IDENTITY, Setting, Target};
use crate::gpu::Gpu;
use crate::pipelines::{ADDED, Drawing, group};
use crate::shapes::Shape;

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
    /// For depths, and for light if there is any.
    pipelines: Vec<(wgpu::RenderPipeline, wgpu::BindGroup)>,
    /// `None`: depths alone are drawn.
    color: Option<wgpu::TextureView>,
    all: Vec<Surface>,
}

impl Surfaces {
    /// Surfaces that are lit, in pictures of this size, or of depths alone.
    pub fn new(gpu: &Gpu, format: TextureFormat, lit: Option<u32>, all: Vec<Surface>) -> Self {
        let frame = gpu.empty(BufferUsages::STORAGE | BufferUsages::COPY_DST, 80);
        let passes = if lit.is_some() { &[Pass::Depth, Pass::Light][..] } else { &[Pass::Depth] };
        let pipelines = passes.iter().map(|&pass| {
            let pipeline = pipeline(gpu, format, pass, lit.is_some());
            let group = group(&gpu.device, &pipeline.get_bind_group_layout(0), [frame.as_entire_binding()]);
            (pipeline, group)
        });
        let pipelines = pipelines.collect();
        Self { frame, pipelines, color: lit.map(|size| gpu.texture([size; 2], COLOR)), all }
    }

    /// The surfaces that the eye sees of a setting. `deformed` are the positions of casters that walk, instances of one
    /// geometry. Drift moves none of them.
    pub fn of(gpu: &Gpu, format: TextureFormat, setting: &Setting, deformed: Option<&wgpu::Buffer>) -> Self {
        let mut surfaces = Vec::new();
        match (&setting.casters, deformed) {
            (Casters::Rigid { shapes, placed }, _) => {
                for (number, shape) in shapes.iter().enumerate() {
                    let matrices = placed.iter().filter(|(of, _)| *of == number).map(|(_, matrix)| *matrix);
                    surfaces.push(Surface::new(gpu, shape, &matrices.collect::<Vec<_>>()));
                }
            }
            (Casters::InBuffers(shapes), _) => {
                surfaces.extend(shapes.iter().map(|shape| Surface::new(gpu, shape, &[IDENTITY])));
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
        let all = Self::new(gpu, format, None, surfaces);
        all.look(gpu, &setting.camera);
        all
    }

    /// The camera of the passes to come, as `Frame` in `surfaces.wgsl` has it.
    pub fn look(&self, gpu: &Gpu, camera: &ShadowCamera) {
        let frame = [&camera.view_projection.concat()[..], &camera.origin, &[0.0]].concat();
        gpu.queue.write_buffer(&self.frame, 0, bytemuck::cast_slice(&frame));
    }

    /// Records a pass, timed as `depth` or `light`. Depth is reversed: 0 is farthest.
    pub fn pass(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        depth: &wgpu::TextureView,
        which: Pass,
        timer: Option<&mut StageTimer>,
    ) {
        let is_first = which == Pass::Depth;
        let black = LoadOp::Clear(wgpu::Color::BLACK);
        let has_stencil = depth.texture().format().has_stencil_aspect();
        let target = Target {
            color: self.color.as_ref().map(|view| (view, if is_first { black } else { LoadOp::Load })),
            depth_stencil: Some(depth),
            depth: Some(if is_first { LoadOp::Clear(0.0) } else { LoadOp::Load }),
            stencil: has_stencil.then_some(if is_first { LoadOp::Clear(0) } else { LoadOp::Load }),
        };
        let Some((pipeline, group)) = self.pipelines.get(usize::from(!is_first)) else { return };
        let mut pass = target.begin_timed(encoder, if is_first { "depth" } else { "light" }, timer, None);
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, group, &[]);
        for Surface { positions, faces, corners, matrices, times, stride } in &self.all {
            pass.set_vertex_buffer(0, positions.slice(..));
            pass.set_vertex_buffer(1, matrices.slice(..));
            pass.set_index_buffer(faces.slice(..), wgpu::IndexFormat::Uint32);
            let draws = if *stride == 0 { 1 } else { *times };
            for draw in 0..draws {
                pass.draw_indexed(0..*corners, (draw * stride) as i32, draw..draw + times / draws);
            }
        }
    }
}

fn pipeline(gpu: &Gpu, format: TextureFormat, pass: Pass, has_color: bool) -> wgpu::RenderPipeline {
    let is_depth = pass == Pass::Depth;
    let rows = wgpu::vertex_attr_array![1 => Float32x4, 2 => Float32x4, 3 => Float32x4];
    let position = wgpu::vertex_attr_array![0 => Float32x3];
    let buffers = [
        Some(wgpu::VertexBufferLayout { array_stride: 12, step_mode: VertexStepMode::Vertex, attributes: &position }),
        Some(wgpu::VertexBufferLayout { array_stride: 48, step_mode: VertexStepMode::Instance, attributes: &rows }),
    ];
    let target = Some(wgpu::ColorTargetState { blend: (!is_depth).then_some(ADDED), ..COLOR.into() });
    // Each lit pixel counts up, so that faces that coincide add their light once.
    let (compare, pass_op) = (wgpu::CompareFunction::Equal, wgpu::StencilOperation::IncrementClamp);
    let counted = wgpu::StencilFaceState { compare, pass_op, ..wgpu::StencilFaceState::IGNORE };
    let face = if is_depth { wgpu::StencilFaceState::IGNORE } else { counted };
    let compare = if is_depth { wgpu::CompareFunction::Greater } else { compare };
    let drawing = Drawing {
        label: "surfaces",
        source: include_str!("surfaces.wgsl"),
        entry_points: [Some("surface"), Some(if has_color { "lit" } else { "nothing" })],
        buffers: &buffers,
        depth_stencil: Some(wgpu::DepthStencilState {
            stencil: wgpu::StencilState { front: face, back: face, read_mask: !0, write_mask: !0 },
            ..crate::pipelines::depth(format, compare, is_depth)
        }),
        targets: if has_color { std::slice::from_ref(&target) } else { &[] },
        ..Drawing::default()
    };
    drawing.pipeline(&gpu.device)
}
