//! Refusals by typed errors: lights, positions and polygons, what does not fit a device, what an extraction has not.

use rimline::gpu::{
    Deformer, DeformerOptions, DeviceError, Extraction, Extractor, ExtractorError, ExtractorOptions, ListOptions,
    MAX_BOUNDARY_EDGES, PositionBuffer, results_bind_group_layout,
};
use rimline::internals::Method;
use rimline::mesh::Weld;
use rimline::{Light, LightError, Mesh, MeshError, Predicate};
use rimline_testkit::shapes::{self, Shape};

use rimline_testkit::cases::case;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::models::random_model;
use rimline_testkit::on_gpu::{extract, interleaved, limited, repeated_torus, text};
use rimline_testkit::polygons::{PolygonSet, quad_box};
use rimline_testkit::random::Random;
use rimline_testkit::refusals::{Expected, is, refusal, refused, shows};
use rimline_testkit::same;

pub(crate) const TESTS: &[Test] = &[
    ("what_does_not_fit_is_a_typed_error", too_large),
    ("a_memory_limit_refuses_before_anything_is_allocated", memory_limit),
    ("readers_are_refused_what_is_not_there", readers),
    ("wrong_lights_and_meshes_are_typed_errors", lights),
    ("wrong_position_buffers_are_typed_errors", positions),
    ("buffers_that_are_destroyed_between_encodes_are_typed_errors", destroyed),
    ("polygons_need_exact_masks_and_boundaries_of_some_size", polygons),
];

const LIGHT: [Light; 1] = [Light::point([3.0, 2.0, 1.0])];

/// Positions one after another.
fn packed(buffer: &wgpu::Buffer) -> PositionBuffer<'_> {
    PositionBuffer { buffer, offset: 0, stride: 12 }
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
        let mesh = shape.mesh().map_err(text)?;
        Ok(refusal(
            what,
            Extractor::new(&limited(binding, buffer, workgroups)?.pipelines, &mesh, options),
            shows(parts),
        ))
    };
    let (small, smaller, smallest) = ((16 << 10, 1 << 20, 64), (4 << 10, 1 << 20, 64), (1 << 10, 1 << 20, 64));
    let faces = &["BufferTooLarge { label: \"faces\"", "144000", "131072"];
    let masks = &["GatheredTooLarge", "\"facing masks\"", "19200", "16384"];
    refused([
        row("faces", (16 << 10, 128 << 10, 64), torus(100, 60), options, faces)?,
        row("facing masks", smaller, torus(60, 40), options, masks)?,
        row("lists", smaller, torus(20, 20), listed, &["BindingTooLarge", "\"edge lists\"", "128000", "4096"])?,
        row("less than a workgroup", smallest, shapes::cube(), options, &["BindingTooLarge"])?,
        row("block offsets", small, loose, ordered, &["BindingTooLarge { what: \"block offsets\""])?,
        row("chunks", (16 << 10, 128 << 10, 1), torus(60, 40), many, &["BufferTooLarge { label: \"chunks\""])?,
    ])?;
    let gpu = limited(4 << 10, 1 << 20, 64)?;
    let shape = repeated_torus(40, 20, 0);
    let mut extractor = Extractor::new(&gpu.pipelines, &shape.mesh().map_err(text)?, options).map_err(text)?;
    let buffer = gpu.storage(&interleaved(&shape.positions, 0, 48));
    let bound = PositionBuffer { buffer: &buffer, offset: 0, stride: 48 };
    let encoded = gpu.submit(|encoder| Ok(extractor.encode(encoder, bound, &LIGHT)))?;
    let model = random_model(&mut Random::new(73), 500);
    let deformer = Deformer::new(&limited(1 << 10, 1 << 20, 64)?.pipelines, &model, DeformerOptions::default());
    // The include takes one binding; the extraction itself goes on, in windows.
    let gpu = limited(16 << 10, 1 << 20, 64)?;
    let layout = results_bind_group_layout(&gpu.device, wgpu::ShaderStages::COMPUTE);
    let shape = repeated_torus(60, 40, 0);
    let mesh = shape.mesh().map_err(text)?;
    let mut extractor = Extractor::new(&gpu.pipelines, &mesh, ExtractorOptions::default()).map_err(text)?;
    let buffer = gpu.storage(&shape.positions);
    let extraction = gpu.submit(|encoder| extractor.encode(encoder, packed(&buffer), &LIGHT).map_err(text))?;
    extract(&gpu, &shape.positions, &mesh, &LIGHT, ExtractorOptions { masks: true, ..Default::default() })?;
    refused([
        refusal("positions", encoded, shows(&["Device(GatheredTooLarge { what: \"positions\""])),
        refusal("deform", deformer, shows(&["Device(BindingTooLarge"])),
        refusal("the include", extraction.bind_group(&layout, 0), shows(&["Device(BindingTooLarge"])),
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
    let Err(ExtractorError::Device(DeviceError::MemoryLimit { bytes, limit: 0, largest })) = made(0) else {
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
    if after > before { Ok(()) } else { Err("negative control: buffers that were made are not counted".to_owned()) }
}

/// Readers of an extraction: what it does not have, and results that a later encode overwrote.
fn readers() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (_, positions, mesh) = case("torus", shapes::torus(24, 16, 1.0, 0.4));
    let anew = Mesh::from_faces(positions.len(), mesh.faces().to_vec()).map_err(text)?;
    let buffer = gpu.storage(&positions);
    let layout = results_bind_group_layout(&gpu.device, wgpu::ShaderStages::COMPUTE);
    let encode = |extractor: &mut Extractor, lights: &[Light]| {
        gpu.submit(|encoder| extractor.encode(encoder, packed(&buffer), lights).map_err(text))
    };
    let lists = |capacity| Some(ListOptions { capacity: Some(capacity), ..ListOptions::default() });
    let made = |method, lists| {
        let options = ExtractorOptions { method, lists, ..Default::default() };
        Extractor::new(&gpu.pipelines, &mesh, options).map_err(text)
    };
    let (mut listed, mut unlisted) = (made(Method::FaceMask, lists(400))?, made(Method::FaceMask, None)?);
    let mut per_edge = made(Method::PerEdge, lists(4))?;
    let first = encode(&mut listed, &LIGHT)?;
    let (without, by_edge) = (encode(&mut unlisted, &LIGHT)?, encode(&mut per_edge, &LIGHT)?);
    let group = |extraction: &Extraction, batch| extraction.bind_group(&layout, batch);
    let edges = |extraction: &Extraction, mesh: &Mesh, light| extraction.read_edges(&gpu.queue, mesh, light);
    let past = || is(ExtractorError::NoSuchLight { light: 1, lights: 1 });
    refused([
        refusal("a bind group", group(&first, 0), Expected::Taken),
        refusal("a batch", group(&first, 1), is(ExtractorError::NoSuchBatch { batch: 1, batches: 1 })),
        refusal("draws", first.draw_arguments(0), Expected::Taken),
        refusal("draws past the lights", first.draw_arguments(1), past()),
        refusal("edges of a clone", edges(&first, &mesh.clone(), 0), Expected::Taken),
        refusal("edges past the lights", edges(&first, &mesh, 1), past()),
        refusal("edges of another mesh", edges(&first, &anew, 0), is(ExtractorError::OtherMesh)),
        refusal("draws without lists", without.draw_arguments(0), is(ExtractorError::NoLists)),
        refusal("the include without lists", group(&without, 0), is(ExtractorError::NoInclude)),
        refusal("the include per edge", group(&by_edge, 0), is(ExtractorError::NoInclude)),
        refusal(
            "edges of a list that overflowed",
            edges(&by_edge, &mesh, 0),
            is(ExtractorError::NoFacing { light: 0 }),
        ),
    ])?;
    let second = encode(&mut listed, &LIGHT)?;
    let is_stale = || is(ExtractorError::Stale);
    refused([
        refusal("an old bind group", group(&first, 0), is_stale()),
        refusal("old draws", first.draw_arguments(0), is_stale()),
        refusal("old results", first.results(), is_stale()),
        refusal("old edges", edges(&first, &mesh, 0), is_stale()),
    ])?;
    // A refused extraction does not change the results.
    if encode(&mut listed, &[Light::homogeneous([0.0; 4])]).is_ok() {
        return Err("no light was extracted".to_owned());
    }
    refused([refusal("the second after a refused one", second.results(), Expected::Taken)])
}

fn lights() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let shape = shapes::cube();
    let mesh = shape.mesh().map_err(text)?;
    let made = |max_lights| {
        Extractor::new(&gpu.pipelines, &mesh, ExtractorOptions { max_lights, ..ExtractorOptions::default() })
    };
    let of_light = |error| is(ExtractorError::Light(error));
    let mut extractor = made(2).map_err(text)?;
    let buffer = gpu.storage(&shape.positions);
    let good = LIGHT[0];
    let not_finite = LightError::NotFinite { index: 0, xyzw: [f32::INFINITY, 0.0, 0.0, 1.0] };
    let nan = |at: usize| Light::homogeneous([0, 1, 2, 3].map(|axis| if axis == at { f32::NAN } else { 1.0 }));
    let range = |index, range| of_light(LightError::Range { index, range });
    gpu.submit(|encoder| {
        let mut encode = |lights: &[Light]| extractor.encode(encoder, packed(&buffer), lights);
        let zero = encode(&[good, Light::homogeneous([0.0, -0.0, 0.0, 0.0])]);
        refused([
            refusal("three lights", encode(&[good; 3]), of_light(LightError::TooMany { count: 3, limit: 2 })),
            refusal("zero", zero, of_light(LightError::Zero { index: 1 })),
            refusal("infinite", encode(&[Light::point([f32::INFINITY, 0.0, 0.0])]), of_light(not_finite)),
            refusal("range 0", encode(&[good, good.with_range(0.0)]), range(1, 0.0)),
            refusal("range -1", encode(&[good.with_range(-1.0)]), range(0, -1.0)),
        ])?;
        let not_finite = || shows(&["Light(NotFinite { index: 0"]);
        refused([0, 1, 2, 3].map(|at| refusal(format!("NaN at {at}"), encode(&[nan(at)]), not_finite())))
    })?;
    let out_of_range = || is(MeshError::IndexOutOfRange { face: 1, corner: 2, index: 3, vertices: 3 });
    let faces = [[0, 1, 2], [0, 1, 3]];
    refused([
        refusal("no room", made(0), of_light(LightError::NoRoom)),
        refusal("1025 lights", made(1025), of_light(LightError::TooMany { count: 1025, limit: 1024 })),
        refusal("no faces", Mesh::new(&shape.positions, &[], Weld::Data), is(MeshError::NoFaces)),
        refusal("index", Mesh::new(&shape.positions[..3], &faces, Weld::Data), out_of_range()),
        refusal("index", Mesh::from_faces(3, faces.to_vec()), out_of_range()),
    ])
}

fn positions() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let shape = shapes::cube();
    let buffer = gpu.storage(&shape.positions);
    let vertices = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("vertices"),
        size: 96,
        usage: wgpu::BufferUsages::VERTEX,
        mapped_at_creation: false,
    });
    let mesh = shape.mesh().map_err(text)?;
    let mut extractor = Extractor::new(&gpu.pipelines, &mesh, ExtractorOptions::default()).map_err(text)?;
    let refused_as = |error| is(ExtractorError::Device(error));
    let layout = |offset, stride| refused_as(DeviceError::PositionLayout { offset, stride });
    let too_short = |offset, stride, needed| {
        refused_as(DeviceError::PositionsTooShort { vertices: 8, offset, stride, needed, bytes: 96 })
    };
    let most = u64::MAX - 3;
    gpu.submit(|encoder| {
        let mut row = |buffer: &wgpu::Buffer, offset, stride, expected| {
            let bound = PositionBuffer { buffer, offset, stride };
            let encoded = extractor.encode(encoder, bound, &LIGHT);
            refusal(format!("offset {offset}, stride {stride}"), encoded, expected)
        };
        refused([
            row(&buffer, 0, 12, Expected::Taken),
            row(&buffer, 1, 12, layout(1, 12)),
            row(&buffer, 2, 12, layout(2, 12)),
            row(&buffer, 0, 13, layout(0, 13)),
            row(&buffer, 0, 8, layout(0, 8)),
            row(&buffer, 0, 0, layout(0, 0)),
            row(&buffer, 4, 12, too_short(4, 12, 100)),
            row(&buffer, 0, 16, too_short(0, 16, 124)),
            row(&buffer, 1 << 40, 12, too_short(1 << 40, 12, 96 + (1 << 40))),
            row(&buffer, 0, most, too_short(0, most, u64::MAX)),
            row(&buffer, most, 12, too_short(most, 12, u64::MAX)),
            row(&vertices, 0, 12, refused_as(DeviceError::NotStorage)),
        ])
    })
}

/// The first encode took the buffer, and may remember it.
fn destroyed() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let shape = shapes::cube();
    let [gone, other] = [(); 2].map(|()| gpu.storage(&shape.positions));
    let mut extractor =
        Extractor::new(&gpu.pipelines, &shape.mesh().map_err(text)?, ExtractorOptions::default()).map_err(text)?;
    let layout = results_bind_group_layout(&gpu.device, wgpu::ShaderStages::COMPUTE);
    let extraction = gpu.submit(|encoder| extractor.encode(encoder, packed(&gone), &LIGHT).map_err(text))?;
    let before = extraction.bind_group(&layout, 0);
    gone.destroy();
    let buffer_refused = || shows(&["Device(BufferRefused"]);
    // The encoder is submitted, so nothing of the destroyed buffer may be in it.
    gpu.submit(|encoder| {
        let mut encode = |buffer: &wgpu::Buffer| extractor.encode(encoder, packed(buffer), &LIGHT);
        refused([
            refusal("its include", before, Expected::Taken),
            refusal("the include of the destroyed buffer", extraction.bind_group(&layout, 0), buffer_refused()),
            refusal("the destroyed buffer", encode(&gone), buffer_refused()),
            refusal("another buffer", encode(&other), Expected::Taken),
            refusal("the destroyed buffer again", encode(&gone), buffer_refused()),
            refusal("the other buffer again", encode(&other), Expected::Taken),
        ])
    })
}
