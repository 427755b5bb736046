//! The WGSL include in a caller's own shaders: from lists that fit and lists that overflow.

use rimline::gpu::{
    Extraction, Extractor, ExtractorOptions, ListOptions, PositionBuffer, include_wgsl, results_bind_group_layout,
};
use rimline::internals::cpu::{self, Threads};
use rimline::mesh::Weld;
use rimline::{Light, Mesh, Predicate};
use rimline_testkit::polygons::quad_torus;

use rimline_testkit::cases::{Case, topologies};
use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::storage_layout;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{interleaved, text};
use rimline_testkit::oracle::listed;
use rimline_testkit::pipelines::group;
use rimline_testkit::random::Random;
use rimline_testkit::{lights, must_fail, same};

pub(crate) const TESTS: &[Test] =
    &[("the_include_reads_what_the_twin_finds", read), ("lights_that_an_encode_lacks_have_no_edge", lacked)];

pub(crate) const LIGHTS: usize = 40;
const OFFSET: u64 = 260;
const STRIDE: u64 = 20;

/// Eight words for each instance that a light's draw has.
const READER: &str = "
@group(0) @binding(0) var<storage, read> draws: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read_write> found: array<u32>;
override LIGHT: u32 = 0u;

@compute @workgroup_size(64)
fn reader(@builtin(global_invocation_id) id: vec3<u32>) {
  if (id.x >= draws[LIGHT].y) {
    return;
  }
  let edge = rimline_silhouette(LIGHT, id.x);
  let ends = array<vec4<f32>, 2>(rimline_edge_vertex(LIGHT, id.x, 0u), rimline_edge_vertex(LIGHT, id.x, 1u));
  let checksum = bitcast<u32>(ends[0].x) ^ bitcast<u32>(ends[1].y);
  // 2: the ends are those of a silhouette, and the edge is none, or the other way round.
  let valid = select(2u, u32(edge.valid), all(vec2<f32>(ends[0].w, ends[1].w) == vec2<f32>(f32(edge.valid))));
  let words = array<u32, 8>(
    valid, edge.edge, edge.a, edge.b, u32(edge.winding), edge.kind, checksum, rimline_silhouettes(LIGHT));
  for (var at = 0u; at < 8u; at++) {
    found[8u * id.x + at] = words[at];
  }
}
";

/// An extraction whose results are read by a shader of the test's.
pub(crate) struct Scene {
    mesh: Mesh,
    positions: Vec<[f32; 3]>,
    twin: cpu::Extraction,
    extractor: Extractor,
    pub(crate) extraction: Extraction,
}

impl Scene {
    pub(crate) fn new(
        gpu: &Gpu,
        (_, positions, mesh): Case,
        lights: &[Light],
        lists: ListOptions,
    ) -> Result<Self, String> {
        let options = ExtractorOptions { max_lights: LIGHTS, lists: Some(lists), ..Default::default() };
        let mut extractor = Extractor::new(&gpu.pipelines, &mesh, options).map_err(text)?;
        let buffer = gpu.storage(&interleaved(&positions, OFFSET, STRIDE));
        let bound = PositionBuffer { buffer: &buffer, offset: OFFSET, stride: STRIDE };
        let extraction = gpu.submit(|encoder| extractor.encode(encoder, bound, lights).map_err(text))?;
        let twin = cpu::extract(&positions, &mesh, lights, Predicate::Exact, Threads::ONE).map_err(text)?;
        Ok(Self { mesh, positions, twin, extractor, extraction })
    }

    /// Encodes the same positions for other lights.
    fn encode(&mut self, gpu: &Gpu, lights: &[Light]) -> Result<(), String> {
        let Self { extractor, extraction, .. } = self;
        self.extraction =
            gpu.submit(|encoder| extractor.encode(encoder, extraction.positions(), lights).map_err(text))?;
        Ok(())
    }

    /// Entries that the reader must find for a light.
    pub(crate) fn expected(&self, light: usize) -> Vec<[u32; 8]> {
        let edges = self.mesh.edges();
        let list = listed(&self.twin.masks[light / 32 * edges.len()..][..edges.len()], light as u32 % 32);
        let entries = list.iter().map(|entry| {
            let index = entry & !cpu::WINDING;
            let edge = edges.get(index as usize).expect("an edge of the mesh");
            let [a, b] = edge.vertices;
            let winding = entry >> 31;
            let [from, to] = if winding == 1 { [a, b] } else { [b, a] };
            let checksum = self.positions[from as usize][0].to_bits() ^ self.positions[to as usize][1].to_bits();
            [1, index, a, b, winding, edge.kind as u32, checksum, list.len() as u32]
        });
        entries.collect()
    }
}

/// Entries that the reader found for a light in the results of a batch: the valid edges, eight words each, in the order
/// of the edges.
fn read_light(gpu: &Gpu, scene: &Scene, light: usize, batch: usize) -> Result<Vec<[u32; 8]>, String> {
    let results = results_bind_group_layout(&gpu.device, wgpu::ShaderStages::COMPUTE);
    read_by(READER, &results, gpu, scene, light, batch)
}

/// The same by a reader, with the layout of the include's bind group.
fn read_by(
    reader: &str,
    results: &wgpu::BindGroupLayout,
    gpu: &Gpu,
    scene: &Scene,
    light: usize,
    batch: usize,
) -> Result<Vec<[u32; 8]>, String> {
    let device = &gpu.device;
    let source = format!("{reader}{}", include_wgsl(1));
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("reader"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let output_layout = storage_layout(gpu, &[(0, true), (1, false)]);
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("reader"),
        bind_group_layouts: &[Some(&output_layout), Some(results)],
        immediate_size: 0,
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("reader"),
        layout: Some(&layout),
        module: &module,
        entry_point: Some("reader"),
        compilation_options: wgpu::PipelineCompilationOptions {
            constants: &[("LIGHT", light as f64)],
            ..Default::default()
        },
        cache: None,
    });
    let edges = scene.mesh.edges().len();
    let found = gpu.storage(&vec![u32::MAX; 8 * edges]);
    let draws = scene.extractor.results().draw_arguments;
    let group = group(device, &output_layout, [draws, &found].map(wgpu::Buffer::as_entire_binding));
    let results = scene.extraction.bind_group(results, batch).map_err(text)?;
    gpu.submit(|encoder| {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.set_bind_group(1, &results, &[]);
        pass.dispatch_workgroups(edges.div_ceil(64) as u32, 1, 1);
        Ok(())
    })?;
    let mut valid: Vec<[u32; 8]> = gpu.read(&found, edges)?;
    valid.retain(|words| matches!(words[0], 1 | 2));
    valid.sort_unstable_by_key(|words| words[1]);
    Ok(valid)
}

/// From lists that fit and lists that overflow; the last mesh has quadrilaterals of which many are twisted.
fn read() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(81);
    let set = quad_torus(&mut random, 9, 7, 0.35);
    let polygons = ("polygons".to_owned(), set.positions.clone(), set.mesh(Weld::Position).map_err(text)?);
    let mut twisted = 0;
    for case in topologies().into_iter().chain([polygons]) {
        for (capacity, ordered) in [(u32::MAX, false), (20, true), (5, false)] {
            let lists = ListOptions { capacity: Some(capacity), ordered, ..ListOptions::default() };
            let lights = lights(&mut random, LIGHTS);
            let scene = Scene::new(gpu, case.clone(), &lights, lists)?;
            twisted += scene.twin.twisted.iter().map(|mask| mask.count_ones()).sum::<u32>();
            for light in [0, 31, 32, 39] {
                let what = format!("{}, capacity {capacity}, light {light}", case.0);
                let mut found = read_light(gpu, &scene, light, light / 32)?;
                let expected = scene.expected(light);
                same(&what, &found, &expected)?;
                same(&format!("{what}, other batch"), &read_light(gpu, &scene, light, 1 - light / 32)?, &[])?;
                if let Some(first) = found.first_mut() {
                    first[4] ^= 1;
                    must_fail("a flipped winding bit", &same(&what, &found, &expected))?;
                }
            }
        }
    }
    if twisted > 500 { Ok(()) } else { Err(format!("{twisted} twisted pairs")) }
}

/// The extractor has room for more lights than the encode has, and its bind group is cached. The reader asks for all edge
/// records.
fn lacked() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(83);
    let reader = READER
        .replace("draws[LIGHT].y", "rimline_info.edges")
        .replace("rimline_silhouette(LIGHT, id.x)", "rimline_edge(LIGHT, id.x)");
    let results = results_bind_group_layout(&gpu.device, wgpu::ShaderStages::COMPUTE);
    for case in topologies() {
        let what = case.0.clone();
        let lights = lights(&mut random, LIGHTS);
        let mut scene = Scene::new(gpu, case, &lights, ListOptions::default())?;
        // With all lights the reader finds edges: that is the control. Both lights are at infinity, so in no body.
        for (count, light) in [(LIGHTS, 25), (20, 25), (LIGHTS, 37), (33, 37)] {
            scene.encode(gpu, &lights[..count])?;
            let found = read_by(&reader, &results, gpu, &scene, light, light / 32)?;
            if found.is_empty() != (light >= count) {
                return Err(format!("{what}: light {light} of {count} has {} edges", found.len()));
            }
        }
    }
    Ok(())
}
