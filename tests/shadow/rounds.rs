//! Parity rounds: the shadow of each polygon by itself, as Bergeron (1986) draws it. A round inverts a bit wherever a
//! side or cap of one polygon lies beyond what is seen; then the bit is added to a count. This takes a number of rounds
//! that is known beforehand, and knows nothing of facing, twists or pieces. It is what the volumes of polygons are
//! compared with.

use glam::Vec4;
use rimline::gpu::read_back_vec;
use rimline::internals::layout::{ShadowLight, ShadowView};
use rimline::internals::shadow;
use rimline::{DepthDirection, Mesh};
use rimline_testkit::device::Gpu;
use rimline_testkit::on_gpu::text;
use rimline_testkit::pipelines::{Drawing, depth};

use crate::render::{Renderer, attachment};
use crate::scene::Frame;

const ROUND: &str = "
@vertex fn given(@location(0) clip: vec4<f32>) -> @invariant @builtin(position) vec4<f32> { return clip; }
@vertex fn everywhere(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
  return vec4<f32>(select(-1.0, 3.0, vertex == 1u), select(-1.0, 3.0, vertex == 2u), 0.0, 1.0);
}
@fragment fn nothing() {}
";

/// The bit of parity. The others count.
const PARITY: u32 = 0x80;

/// A position, or a direction with w = 0, in clip space. A surface has the bits of the depth pass.
fn to_clip(view: &ShadowView, [x, y, z]: [f32; 3], w: f32) -> Vec4 {
    let [column_x, column_y, column_z, column_w] = view.view_projection.map(Vec4::from);
    let [dx, dy, dz] = view.placement.map(|row| row[3] * w);
    let sum = column_x * (x + dx) + column_y * (y + dy) + column_z * (z + dz);
    if w == 0.0 { sum } else { sum + column_w }
}

/// The point at infinity, away from the light.
fn far_end(view: &ShadowView, light: &ShadowLight, position: [f32; 3]) -> Vec4 {
    let [x, y, z, w] = light.light;
    to_clip(view, [w * position[0] - x, w * position[1] - y, w * position[2] - z], 0.0)
}

/// The triangles around a polygon's shadow, in clip space: its surface, its sides, and a fan at infinity.
fn volume(frame: &Frame, mesh: &Mesh, polygon: usize) -> Result<Vec<Vec4>, String> {
    let polygons = mesh.polygons().ok_or("no polygons")?;
    let camera = frame.eye.camera();
    let view = shadow::view(&camera).map_err(text)?;
    let light = shadow::light(&camera, &view, frame.lights[0]);
    let position = |vertex: u32| frame.bodies[0].shape.positions[vertex as usize];
    let surface = mesh.faces()[polygons.triangles(polygon)].iter().flatten();
    let mut corners: Vec<Vec4> = surface.map(|&vertex| to_clip(&view, position(vertex), 1.0)).collect();
    let boundary = polygons.boundary(polygon);
    for &[a, b] in boundary {
        let [near_a, near_b] = [a, b].map(|vertex| to_clip(&view, position(vertex), 1.0));
        let [far_a, far_b] = [a, b].map(|vertex| far_end(&view, &light, position(vertex)));
        corners.extend([near_a, near_b, far_b, near_a, far_b, far_a]);
        if light.light[3] != 0.0 {
            let middle = far_end(&view, &light, position(boundary[0][0]));
            corners.extend([middle, far_a, far_b]);
        }
    }
    Ok(corners)
}

fn pipeline(
    gpu: &Gpu,
    frame: &Frame,
    entry_point: &str,
    [passed, failed]: [wgpu::StencilOperation; 2],
    [read_mask, write_mask]: [u32; 2],
) -> wgpu::RenderPipeline {
    let is_given = entry_point == "given";
    let nearer = match frame.eye.depth {
        DepthDirection::Reversed => wgpu::CompareFunction::GreaterEqual,
        DepthDirection::Standard => wgpu::CompareFunction::LessEqual,
    };
    let compare = if is_given { nearer } else { wgpu::CompareFunction::Always };
    let face = wgpu::StencilFaceState {
        compare: wgpu::CompareFunction::Equal,
        fail_op: wgpu::StencilOperation::Keep,
        depth_fail_op: failed,
        pass_op: passed,
    };
    let attributes = wgpu::vertex_attr_array![0 => Float32x4];
    let layout =
        wgpu::VertexBufferLayout { array_stride: 16, step_mode: wgpu::VertexStepMode::Vertex, attributes: &attributes };
    let stencil = wgpu::StencilState { front: face, back: face, read_mask, write_mask };
    let drawing = Drawing {
        label: "rounds",
        source: ROUND,
        entry_points: [Some(entry_point), None],
        buffers: if is_given { &[Some(layout)] } else { &[] },
        depth_stencil: Some(wgpu::DepthStencilState {
            stencil,
            ..depth(wgpu::TextureFormat::Depth24PlusStencil8, compare, false)
        }),
        ..Drawing::default()
    };
    drawing.pipeline(&gpu.device)
}

/// The stencil of a frame with one caster of polygons and one light, by a round for each polygon: fewer than 128.
pub(crate) fn parity_rounds(renderer: &Renderer<'_>, frame: &Frame, mesh: &Mesh) -> Result<Vec<u8>, String> {
    use wgpu::StencilOperation::{IncrementWrap, Invert, Keep, Zero};
    let gpu = renderer.gpu;
    let polygons = mesh.polygons().ok_or("no polygons")?;
    let mut vertices = Vec::new();
    let mut runs = Vec::new();
    for polygon in 0..polygons.len() {
        let first = vertices.len() as u32;
        vertices.extend(volume(frame, mesh, polygon)?.iter().map(Vec4::to_array));
        runs.push(first..vertices.len() as u32);
    }
    // Every edge is walked both ways.
    if vertices.is_empty() {
        return Ok(vec![0; (frame.size * frame.size) as usize]);
    }
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("rounds"),
        size: (vertices.len() * 16) as u64,
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&vertices));
    let invert = pipeline(gpu, frame, "given", [Keep, Invert], [0, PARITY]);
    let add = pipeline(gpu, frame, "everywhere", [IncrementWrap, Keep], [PARITY, !PARITY & 0xff]);
    let clear = pipeline(gpu, frame, "everywhere", [Zero, Keep], [0, PARITY]);
    let target = renderer.target(frame.size, 1, renderer.format);
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    renderer.depth(&mut encoder, frame, &view);
    let mut pass = encoder.begin_render_pass(&attachment(&view, wgpu::LoadOp::Load));
    pass.set_vertex_buffer(0, buffer.slice(..));
    for run in runs {
        for (pipeline, reference, run) in [(&invert, 0, run), (&add, PARITY, 0..3), (&clear, 0, 0..3)] {
            pass.set_pipeline(pipeline);
            pass.set_stencil_reference(reference);
            pass.draw(run, 0..1);
        }
    }
    drop(pass);
    let row = frame.size.next_multiple_of(256);
    let copy = renderer.copy_stencil(&mut encoder, &target, row);
    gpu.queue.submit([encoder.finish()]);
    let all: Vec<u8> = read_back_vec(&gpu.device, &gpu.queue, &copy).map_err(text)?;
    Ok(all.chunks(row as usize).flat_map(|line| line[..frame.size as usize].to_vec()).collect())
}
