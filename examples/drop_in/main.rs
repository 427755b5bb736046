//! Rimline in a renderer that has its own device, positions and render pass: draws the silhouette of a torus, as an eye
//! sees it, into `drop_in.png`. Run it with `cargo run --release --example drop_in`.

#[path = "../support/mod.rs"]
mod support;

use rimline::gpu::{self, EdgeTopology, Extractor, ExtractorOptions, ListOptions, PositionBuffer};
use rimline::{Light, Mesh, mesh::Weld, wgpu};
use rimline_testkit::shapes;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Yours: a device, and a buffer in any layout that has three floats a vertex; here they are 16 bytes apart.
    let canvas = support::Canvas::new(512)?;
    let device = &canvas.device;
    let shape = shapes::torus(256, 128, 1.0, 0.45);
    let tilt = |&[x, y, z]: &[f32; 3]| [x, 0.6 * y - 0.8 * z, 0.8 * y + 0.6 * z, 1.0];
    let vertices: Vec<[f32; 4]> = shape.positions.iter().map(tilt).collect();
    let vertex_buffer = canvas.storage(bytemuck::cast_slice(&vertices));

    // Once a mesh: topology, extractor, and what your shader reads the results with.
    let positions = PositionBuffer { buffer: &vertex_buffer, offset: 0, stride: 16 };
    let mesh = Mesh::new(&shape.positions, &shape.faces, Weld::Position)?;
    let lists = Some(ListOptions { topology: EdgeTopology::LineList, ..ListOptions::default() });
    let mut extractor = Extractor::new(device, &mesh, ExtractorOptions { lists, ..ExtractorOptions::default() })?;
    let layout = gpu::results_bind_group_layout(device, wgpu::ShaderStages::VERTEX);
    let pipeline = canvas.line_pipeline(&layout, &(gpu::include_wgsl(0) + include_str!("lines.wgsl")));

    // Every frame: extract, then draw what was found, in one encoder; nothing is read back.
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let silhouette = extractor.encode(&mut encoder, positions, &[Light::point([0.0, 0.0, 4.0])])?;
    let results = silhouette.bind_group(&layout, 0)?;
    canvas.draw(&mut encoder, |pass| {
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &results, &[]);
        silhouette.draw(pass, 0)
    })?;
    canvas.save(encoder, "drop_in.png")
}
