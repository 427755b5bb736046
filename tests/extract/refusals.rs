//! Input that does not fit a device gives a typed error, before anything is allocated.

use rimline::gpu::{
    Deformer, DeformerOptions, DeviceError, Extractor, ExtractorError, ExtractorOptions, ListOptions,
    MAX_BOUNDARY_EDGES, PositionBuffer, results_bind_group_layout,
};
use rimline::internals::Method;
use rimline::mesh::Weld;
use rimline::{Light, Mesh, Predicate};
use rimline_testkit::shapes::{self, Shape};

use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::models::random_model;
use rimline_testkit::on_gpu::extract;
use rimline_testkit::on_gpu::interleaved;
use rimline_testkit::on_gpu::{limited, repeated_torus, text};
use rimline_testkit::polygons::{PolygonSet, quad_box};
use rimline_testkit::random::Random;
use rimline_testkit::refusals::{Expected, is, refusal, refused, shows};
use rimline_testkit::same;

pub(crate) const TESTS: &[Test] = &[
    ("what_does_not_fit_is_a_typed_error", too_large),
    ("positions_and_models_that_do_not_fit_are_typed_errors", positions_and_models_too_large),
    ("a_memory_limit_refuses_before_anything_is_allocated", memory_limit),
    ("the_include_refuses_what_takes_several_bindings", include_refuses),
    ("draws_without_lists_are_refused", no_lists),
    ("overwritten_extractions_are_refused", stale),
    ("polygons_need_exact_masks_and_boundaries_of_some_size", polygons),
];

fn mesh_of(shape: &Shape) -> Result<Mesh, String> {
    shape.mesh().map_err(text)
}

fn polygons() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mesh = quad_box(1).mesh(Weld::Position).map_err(text)?;
    let made = |mesh: &Mesh, options| Extractor::new(&gpu.pipelines, mesh, options);
    let exact = ExtractorOptions::default();
    let mut ring = PolygonSet::default();
    let corners = MAX_BOUNDARY_EDGES + 1;
    let corner = |at: usize| (at as f32 / corners as f32 * std::f32::consts::TAU).sin_cos();
    ring.push_points(&[(0..4).map(|at| [at as f32, (at * at) as f32, 0.0]).collect()]);
    ring.push_points(&[(0..corners).map(|at| [corner(at).0, corner(at).1, 0.0]).collect()]);
    let ring = ring.mesh(Weld::Position).map_err(text)?;
    let large = ExtractorError::BoundaryTooLarge { polygon: 1, edges: corners };
    let (fast, per_edge) = (Predicate::Fast, Method::PerEdge);
    let triangles = Mesh::from_faces(24, mesh.faces().to_vec()).map_err(text)?;
    refused([
        refusal("fast", made(&mesh, ExtractorOptions { predicate: fast, ..exact }), is(ExtractorError::Polygons)),
        refusal("per edge", made(&mesh, ExtractorOptions { method: per_edge, ..exact }), is(ExtractorError::Polygons)),
        refusal("a boundary", made(&ring, exact), is(large)),
        refusal("triangles", made(&triangles, exact), Expected::Taken),
    ])
}

fn too_large() -> Result<(), String> {
    let options = ExtractorOptions { lists: None, ..Default::default() };
    let lists = |capacity, ordered| Some(ListOptions { capacity: Some(capacity), ordered, ..Default::default() });
    let listed = ExtractorOptions { max_lights: 32, lists: lists(1000, false), ..Default::default() };
    let ordered = ExtractorOptions { lists: lists(1, true), ..Default::default() };
    let many = ExtractorOptions { max_lights: 1024, ..options };
    // Every face by itself: three records a face, and blocks of them more blocks than a binding of block offsets holds.
    let mut loose = Shape::default();
    for face in 0..14_000 {
        loose.positions.extend([[0.0; 3]; 3]);
        loose.faces.push([3 * face, 3 * face + 1, 3 * face + 2]);
    }
    let torus = |rings, segments| repeated_torus(rings, segments, 0);
    let row = |what, (binding, buffer, workgroups), shape: Shape, options, parts| -> Result<_, String> {
        let made = Extractor::new(&limited(binding, buffer, workgroups)?.pipelines, &mesh_of(&shape)?, options);
        Ok(refusal(what, made, shows(parts)))
    };
    let (small, smaller, smallest) = ((16 << 10, 1 << 20, 64), (4 << 10, 1 << 20, 64), (1 << 10, 1 << 20, 64));
    refused([
        row(
            "faces",
            (16 << 10, 128 << 10, 64),
            torus(100, 60),
            options,
            &["BufferTooLarge { label: \"faces\"", "144000", "131072"],
        )?,
        row(
            "facing masks",
            smaller,
            torus(60, 40),
            options,
            &["GatheredTooLarge", "\"facing masks\"", "19200", "16384"],
        )?,
        row("lists", smaller, torus(20, 20), listed, &["BindingTooLarge", "\"edge lists\"", "128000", "4096"])?,
        row("less than a workgroup", smallest, shapes::cube(), options, &["BindingTooLarge"])?,
        row("block offsets", small, loose, ordered, &["BindingTooLarge { what: \"block offsets\""])?,
        row("chunks", (16 << 10, 128 << 10, 1), torus(60, 40), many, &["BufferTooLarge { label: \"chunks\""])?,
    ])
}

fn positions_and_models_too_large() -> Result<(), String> {
    let options = ExtractorOptions { lists: None, ..Default::default() };
    let small = limited(4 << 10, 1 << 20, 64)?;
    let shape = repeated_torus(40, 20, 0);
    let mesh = mesh_of(&shape)?;
    let mut extractor = Extractor::new(&small.pipelines, &mesh, options).map_err(text)?;
    let buffer = small.storage(&interleaved(&shape.positions, 0, 48));
    let bound = PositionBuffer { buffer: &buffer, offset: 0, stride: 48 };
    let light = [Light::directional([1.0, 0.0, 0.0])];
    let encoded = small.submit(|encoder| Ok(extractor.encode(encoder, bound, &light)))?;
    let model = random_model(&mut Random::new(73), 500);
    let deformer = Deformer::new(&limited(1 << 10, 1 << 20, 64)?.pipelines, &model, DeformerOptions::default());
    refused([
        refusal("positions", encoded, shows(&["Device(GatheredTooLarge { what: \"positions\""])),
        refusal("deform", deformer, shows(&["Device(BindingTooLarge"])),
    ])
}

fn memory_limit() -> Result<(), String> {
    // A device of its own, where nobody else makes buffers meanwhile.
    let gpu = limited(128 << 20, 256 << 20, 65_535)?;
    let mesh = repeated_torus(60, 40, 0).mesh().map_err(text)?;
    let model = random_model(&mut Random::new(74), 500);
    let before = gpu.live_buffers()?;
    let with = |memory_limit| ExtractorOptions { max_lights: 40, masks: true, memory_limit, ..Default::default() };
    let made = |memory_limit| Extractor::new(&gpu.pipelines, &mesh, with(Some(memory_limit)));
    let Err(ExtractorError::Device(DeviceError::MemoryLimit { bytes, limit: 1000, largest })) = made(1000) else {
        return Err("not refused for the total".to_owned());
    };
    println!("{bytes} bytes wanted, most by {largest:?}");
    let expected = ExtractorError::Device(DeviceError::MemoryLimit { bytes, limit: bytes - 1, largest });
    let limited = DeformerOptions { memory_limit: Some(1000), ..Default::default() };
    let deformer = Deformer::new(&gpu.pipelines, &model, limited);
    refused([
        refusal("one byte less", made(bytes - 1), is(expected)),
        refusal("deform", deformer, shows(&["Device(MemoryLimit"])),
    ])?;
    same("live buffers", &[gpu.live_buffers()?], &[before])?;
    let extractor = made(bytes).map_err(text)?;
    let after = gpu.live_buffers()?;
    drop(extractor);
    if after <= before {
        return Err("negative control: buffers that were made are not counted".to_owned());
    }
    Ok(())
}

fn include_refuses() -> Result<(), String> {
    let gpu = limited(16 << 10, 1 << 20, 64)?;
    let layout = results_bind_group_layout(&gpu.device, wgpu::ShaderStages::COMPUTE);
    let shape = repeated_torus(60, 40, 0);
    let mesh = shape.mesh().map_err(text)?;
    let mut extractor = Extractor::new(&gpu.pipelines, &mesh, ExtractorOptions::default()).map_err(text)?;
    let buffer = gpu.storage(&shape.positions);
    let bound = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    let light = [Light::point([3.0, 2.0, 1.0])];
    let extraction = gpu.submit(|encoder| extractor.encode(encoder, bound, &light).map_err(text))?;
    let group = extraction.bind_group(&layout, 0);
    refused([refusal("the include", group, shows(&["Device(BindingTooLarge"]))])?;
    // The extraction itself goes on, in windows.
    let options = ExtractorOptions { masks: true, ..Default::default() };
    extract(&gpu, &shape.positions, &mesh, &[Light::point([3.0, 2.0, 1.0])], options).map(drop)
}

fn no_lists() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let shape = shapes::cube();
    let mesh = mesh_of(&shape)?;
    let buffer = gpu.storage(&shape.positions);
    let bound = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    let light = [Light::point([3.0, 2.0, 1.0])];
    let arguments = |lists| {
        let options = ExtractorOptions { lists, ..Default::default() };
        let mut extractor = Extractor::new(&gpu.pipelines, &mesh, options).map_err(text)?;
        let extraction = gpu.submit(|encoder| extractor.encode(encoder, bound, &light).map_err(text))?;
        Ok::<_, String>(extraction.draw_arguments(0).map(drop))
    };
    refused([
        refusal("no lists", arguments(None)?, is(ExtractorError::NoLists)),
        refusal("lists", arguments(Some(ListOptions::default()))?, Expected::Taken),
    ])
}

/// Every reader refuses results that a later encode overwrote, and lights that were not extracted.
fn stale() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let shape = shapes::cube();
    let mesh = mesh_of(&shape)?;
    let buffer = gpu.storage(&shape.positions);
    let bound = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    let options = ExtractorOptions { max_lights: 4, ..Default::default() };
    let mut extractor = Extractor::new(&gpu.pipelines, &mesh, options).map_err(text)?;
    let mut encode = |lights: &[Light]| gpu.submit(|encoder| extractor.encode(encoder, bound, lights).map_err(text));
    let lights = [[0.0, 4.0, 1.0], [1.0, 2.0, 0.0], [3.0, 1.0, 0.0]].map(Light::point);
    let (first, second) = (encode(&lights[..2])?, encode(&lights[2..])?);
    let layout = results_bind_group_layout(&gpu.device, wgpu::ShaderStages::VERTEX);
    let is_stale = || is(ExtractorError::Stale);
    let past = is(ExtractorError::NoSuchLight { light: 1, lights: 1 });
    let batch = is(ExtractorError::NoSuchBatch { batch: 1, batches: 1 });
    refused([
        refusal("its bind group", first.bind_group(&layout, 0), is_stale()),
        refusal("its draws", first.draw_arguments(0), is_stale()),
        refusal("its results", first.results(), is_stale()),
        refusal("draws past the lights", second.draw_arguments(1), past),
        refusal("a batch past the lights", second.bind_group(&layout, 1), batch),
        refusal("a good one", second.bind_group(&layout, 0), Expected::Taken),
    ])?;
    // A refused extraction does not change the results.
    if encode(&[Light::homogeneous([0.0; 4])]).is_ok() {
        return Err("no light was extracted".to_owned());
    }
    refused([refusal("the second after a refused one", second.results(), Expected::Taken)])
}
