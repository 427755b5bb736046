//! A caller's own render pass: indirect draws through the WGSL include.

use rimline::gpu::{EdgeTopology, ListOptions, include_wgsl, results_bind_group_layout};

use crate::include::{LIGHTS, Scene};
use rimline_testkit::cases::topologies;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::pipelines::{ADDED, texture};
use rimline_testkit::random::Random;
use rimline_testkit::textures::texels;
use rimline_testkit::{lights, must_fail, same};

pub(crate) const TESTS: &[Test] = &[("an_indirect_draw_covers_every_silhouette_edge_once", drawn)];

/// Each valid edge colours the pixel of its own number, by a quad or a line; additive, so that one drawn twice shows.
const PAINTER: &str = "
const SIDE: u32 = 64u;
override LIGHT: u32 = 0u;

@vertex
fn edge_vertex(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> @builtin(position) vec4<f32> {
  let edge = rimline_silhouette(LIGHT, instance).edge;
  let corner = vec2<f32>(vec2<u32>(rimline_corner(vertex) & 1u, rimline_corner(vertex) >> 1u));
  let is_line = rimline_info.vertices_per_edge == 2u;
  let pixel = vec2<f32>(vec2<u32>(edge % SIDE, edge / SIDE)) + corner + select(0.0, 0.5, is_line);
  let scaled = 2.0 * pixel / f32(SIDE) - vec2<f32>(1.0);
  // A matrix that moves all positions to the pixel.
  let matrix = mat4x4<f32>(vec4<f32>(), vec4<f32>(), vec4<f32>(), vec4<f32>(scaled.x, -scaled.y, 0.5, 1.0));
  return matrix * rimline_edge_vertex(LIGHT, instance, vertex);
}

@fragment
fn paint() -> @location(0) vec4<f32> {
  return vec4<f32>(1.0 / 255.0);
}
";

const SIDE: u32 = 64;

/// The picture that a light's indirect draw makes, a byte an edge.
fn draw(gpu: &Gpu, scene: &Scene, light: usize, topology: EdgeTopology) -> Result<Vec<u8>, String> {
    let device = &gpu.device;
    let results = results_bind_group_layout(device, wgpu::ShaderStages::VERTEX);
    let format = wgpu::TextureFormat::R8Unorm;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("painter"),
        source: wgpu::ShaderSource::Wgsl(format!("{}{PAINTER}", include_wgsl(0)).into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("painter"),
        bind_group_layouts: &[Some(&results)],
        immediate_size: 0,
    });
    let constants = [("LIGHT", light as f64)];
    let compilation_options = wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
    let write_mask = wgpu::ColorWrites::ALL;
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("painter"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: compilation_options.clone(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState { topology: topology.primitive_topology(), ..Default::default() },
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options,
            targets: &[Some(wgpu::ColorTargetState { format, blend: Some(ADDED), write_mask })],
        }),
        multiview_mask: None,
        cache: None,
    });
    let view = texture(device, [SIDE; 2], format);
    let group = scene.extraction.bind_group(&results, light / 32).map_err(text)?;
    gpu.submit(|encoder| {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        scene.extraction.draw(&mut pass, light).map_err(text)
    })?;
    texels(gpu, view.texture(), 0)
}

fn drawn() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(82);
    for case in topologies() {
        let edges = case.2.edges().len();
        if edges > (SIDE * SIDE) as usize {
            return Err(format!("{}: {edges} edges do not fit the picture", case.0));
        }
        let topologies = [EdgeTopology::TriangleStrip, EdgeTopology::TriangleList, EdgeTopology::LineList];
        for (topology, capacity) in topologies.into_iter().flat_map(|topology| [(topology, u32::MAX), (topology, 20)]) {
            let lists = ListOptions { capacity: Some(capacity), ordered: false, topology };
            let lights = lights(&mut random, LIGHTS);
            let scene = Scene::new(gpu, case.clone(), &lights, lists)?;
            for light in [3, 36] {
                let found = draw(gpu, &scene, light, topology)?;
                let mut expected_pixels = vec![0_u8; (SIDE * SIDE) as usize];
                for words in scene.expected(light) {
                    expected_pixels[words[1] as usize] = 1;
                }
                let what = format!("{}, {topology:?}, capacity {capacity}, light {light}", case.0);
                same(&what, &found, &expected_pixels)?;
                expected_pixels[random.below(edges)] ^= 1;
                must_fail("a missing edge", &same(&what, &found, &expected_pixels))?;
            }
        }
    }
    Ok(())
}
