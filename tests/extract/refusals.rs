//! Input that does not fit a device gives a typed error, before anything is allocated.

use rimline::gpu::{
    DeformError, Deformer, DeformerOptions, ExtractionEncodeError, ExtractionIncludeError, Extractor, ExtractorError,
    ExtractorOptions, ListOptions, MAX_OUTLINE_EDGES, MemoryError, PositionBuffer, PositionError,
    results_bind_group_layout,
};
use rimline::mesh::Weld;
use rimline::reference::Method;
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
use rimline_testkit::same;

pub(crate) const TESTS: &[Test] = &[
    ("what_does_not_fit_is_a_typed_error", too_large),
    ("positions_and_models_that_do_not_fit_are_typed_errors", positions_and_models_too_large),
    ("a_memory_limit_refuses_before_anything_is_allocated", memory_limit),
    ("the_include_refuses_what_takes_several_bindings", include_refuses),
    ("polygons_need_exact_masks_and_outlines_of_some_size", polygons),
];

/// The memory error of an extractor that must not come to be.
fn refusal(gpu: &Gpu, mesh: &Mesh, options: ExtractorOptions) -> Result<MemoryError, String> {
    match Extractor::new(&gpu.pipelines, mesh, options) {
        Err(ExtractorError::Memory(error)) => Ok(error),
        other => Err(format!("expected a memory error, got {:?}", other.err())),
    }
}

fn expect(what: &str, error: &MemoryError, fits: fn(&MemoryError) -> bool) -> Result<(), String> {
    if fits(error) { Ok(()) } else { Err(format!("{what}: {error:?}")) }
}

fn mesh_of(shape: &Shape) -> Result<Mesh, String> {
    shape.mesh().map_err(text)
}

fn polygons() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mesh = quad_box(1).mesh(Weld::Position).map_err(text)?;
    let refused = |mesh: &Mesh, options| Extractor::new(&gpu.pipelines, mesh, options).err();
    let exact = ExtractorOptions::default();
    for options in [
        ExtractorOptions { predicate: Predicate::Fast, ..exact },
        ExtractorOptions { method: Method::PerEdge, ..exact },
    ] {
        let refused = refused(&mesh, options);
        if refused != Some(ExtractorError::Polygons) {
            return Err(format!("expected a refusal, got {refused:?}"));
        }
    }
    let mut ring = PolygonSet::default();
    let corners = MAX_OUTLINE_EDGES + 1;
    let corner = |at: usize| (at as f32 / corners as f32 * std::f32::consts::TAU).sin_cos();
    ring.push_points(&[(0..4).map(|at| [at as f32, (at * at) as f32, 0.0]).collect()]);
    ring.push_points(&[(0..corners).map(|at| [corner(at).0, corner(at).1, 0.0]).collect()]);
    let refused = refused(&ring.mesh(Weld::Position).map_err(text)?, exact);
    if refused != Some(ExtractorError::OutlineTooLarge { polygon: 1, edges: corners }) {
        return Err(format!("expected a refusal, got {refused:?}"));
    }
    let triangles = Mesh::from_faces(24, mesh.faces().to_vec()).map_err(text)?;
    Extractor::new(&gpu.pipelines, &triangles, ExtractorOptions::default()).map_err(text)?;
    Ok(())
}

fn too_large() -> Result<(), String> {
    let options = ExtractorOptions { lists: None, ..Default::default() };
    let small = limited(16 << 10, 128 << 10, 64)?;
    let error = refusal(&small, &mesh_of(&repeated_torus(100, 60, 0))?, options)?;
    expect("12,000 faces of 12 bytes", &error, |error| {
        matches!(error, MemoryError::Buffer { label: "faces", bytes: 144_000, limit: 131_072 })
    })?;

    let small = limited(4 << 10, 1 << 20, 64)?;
    let error = refusal(&small, &mesh_of(&repeated_torus(60, 40, 0))?, options)?;
    expect("4,800 facing masks", &error, |error| {
        matches!(error, MemoryError::Gathered { what: "facing masks", bytes: 19_200, limit: 16_384 })
    })?;
    let lists = ExtractorOptions {
        max_lights: 32,
        lists: Some(ListOptions { capacity: Some(1000), ..Default::default() }),
        ..Default::default()
    };
    let error = refusal(&small, &mesh_of(&repeated_torus(20, 20, 0))?, lists)?;
    expect("lists", &error, |error| {
        matches!(error, MemoryError::Binding { what: "edge lists", bytes: 128_000, limit: 4096 })
    })?;
    let error = refusal(&limited(1 << 10, 1 << 20, 64)?, &mesh_of(&shapes::cube())?, options)?;
    expect("less than a workgroup", &error, |error| matches!(error, MemoryError::Binding { .. }))?;
    // Every face by itself: three records a face, and blocks of them past what compaction's places can be bound with.
    let mut loose = Shape::default();
    for face in 0..14_000 {
        loose.positions.extend([[0.0; 3]; 3]);
        loose.faces.push([3 * face, 3 * face + 1, 3 * face + 2]);
    }
    let ordered = ExtractorOptions {
        lists: Some(ListOptions { capacity: Some(1), ordered: true, ..Default::default() }),
        ..Default::default()
    };
    let error = refusal(&limited(16 << 10, 1 << 20, 64)?, &mesh_of(&loose)?, ordered)?;
    expect("places", &error, |error| matches!(error, MemoryError::Binding { what: "places", .. }))?;
    let many = ExtractorOptions { max_lights: 1024, ..options };
    let error = refusal(&limited(16 << 10, 128 << 10, 1)?, &mesh_of(&repeated_torus(60, 40, 0))?, many)?;
    expect("chunks", &error, |error| matches!(error, MemoryError::Buffer { label: "chunks", .. }))?;
    Ok(())
}

fn positions_and_models_too_large() -> Result<(), String> {
    let options = ExtractorOptions { lists: None, ..Default::default() };
    let small = limited(4 << 10, 1 << 20, 64)?;
    let shape = repeated_torus(40, 20, 0);
    let mesh = mesh_of(&shape)?;
    let mut extractor = Extractor::new(&small.pipelines, &mesh, options).map_err(text)?;
    let buffer = small.storage(&interleaved(&shape.positions, 0, 48));
    let bound = PositionBuffer { buffer: &buffer, offset: 0, stride: 48 };
    small.submit(|encoder| {
        let error = extractor.encode(encoder, bound, &[Light::directional([1.0, 0.0, 0.0])], None);
        match error {
            Err(ExtractionEncodeError::Positions(PositionError::Memory(MemoryError::Gathered {
                what: "positions",
                ..
            }))) => Ok(()),
            other => Err(format!("positions: {:?}", other.err())),
        }
    })?;
    let model = random_model(&mut Random::new(73), 500);
    match Deformer::new(&limited(1 << 10, 1 << 20, 64)?.pipelines, &model, DeformerOptions::default()) {
        Err(DeformError::Memory(MemoryError::Binding { .. })) => Ok(()),
        other => Err(format!("deform: {:?}", other.err())),
    }
}

fn memory_limit() -> Result<(), String> {
    // A device of its own, where nobody else makes buffers meanwhile.
    let gpu = limited(128 << 20, 256 << 20, 65_535)?;
    let mesh = repeated_torus(60, 40, 0).mesh().map_err(text)?;
    let model = random_model(&mut Random::new(74), 500);
    let before = gpu.live_buffers()?;
    let with = |memory_limit| ExtractorOptions { max_lights: 40, masks: true, memory_limit, ..Default::default() };
    let MemoryError::Total { bytes, limit, largest } = refusal(&gpu, &mesh, with(Some(1000)))? else {
        return Err("not refused for the total".to_owned());
    };
    println!("{bytes} bytes wanted, most by {largest:?}");
    let one_less = refusal(&gpu, &mesh, with(Some(bytes - 1)))?;
    let expected = MemoryError::Total { bytes, limit: bytes - 1, largest };
    same("one byte less", &[one_less], &[expected])?;
    let limited = DeformerOptions { memory_limit: Some(1000), ..Default::default() };
    if !matches!(Deformer::new(&gpu.pipelines, &model, limited), Err(DeformError::Memory(MemoryError::Total { .. }))) {
        return Err("deform not refused".to_owned());
    }
    same("limit", &[limit], &[1000])?;
    same("live buffers", &[gpu.live_buffers()?], &[before])?;
    let extractor = Extractor::new(&gpu.pipelines, &mesh, with(Some(bytes))).map_err(text)?;
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
    let extraction = gpu.submit(|encoder| extractor.encode(encoder, bound, &light, None).map_err(text))?;
    match extraction.bind_group(&layout, 0) {
        Err(ExtractionIncludeError::Memory(MemoryError::Binding { .. })) => Ok(()),
        other => Err(format!("{:?}", other.err())),
    }?;
    // The extraction itself goes on, in windows.
    let options = ExtractorOptions { masks: true, ..Default::default() };
    extract(&gpu, &shape.positions, &mesh, &[Light::point([3.0, 2.0, 1.0])], options).map(drop)
}
