//! Silhouettes read back from the GPU, against those of the CPU.

use rimline::cpu::{self, Threads};
use rimline::gpu::{Extractor, ExtractorError, ExtractorOptions, ListOptions, PositionBuffer};
use rimline::internals::Method;
use rimline::mesh::{Silhouette, Weld};
use rimline::{Light, Predicate};
use rimline_testkit::cases::{Case, case, topologies};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::polygons::quad_torus;
use rimline_testkit::random::Random;
use rimline_testkit::{lights, must_fail, same, shapes};

pub(crate) const TESTS: &[Test] =
    &[("edges_that_are_read_are_those_of_the_cpu", read), ("edges_are_not_read_of_what_is_not_there", refused)];

const LIGHTS: usize = 40;

fn same_silhouettes(what: &str, found: &Silhouette, expected: &Silhouette) -> Result<(), String> {
    same(what, found.edges(), expected.edges())
}

fn read() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(93);
    let bumpy = quad_torus(&mut random, 12, 8, 0.3);
    let polygons = bumpy.mesh(Weld::Position).map_err(text)?;
    let cases: Vec<Case> =
        topologies().into_iter().chain([("bumpy polygons".to_owned(), bumpy.positions, polygons)]).collect();
    let (mut listed, mut overflowed, mut twisted) = (0, 0, 0);
    for (name, positions, mesh) in &cases {
        let lights = lights(&mut random, LIGHTS);
        let twin = cpu::extract(positions, mesh, &lights, Predicate::Exact, Threads::ONE).map_err(text)?;
        twisted += twin.twisted.iter().filter(|&&lights| lights != 0).count();
        let buffer = gpu.storage(positions);
        for (capacity, ordered) in [(None, false), (Some(u32::MAX), true), (Some(20), false), (Some(20), true)] {
            let lists = Some(ListOptions { capacity, ordered, ..ListOptions::default() });
            check(gpu, (name, &buffer), mesh, &lights, lists, &twin, [&mut listed, &mut overflowed])?;
        }
        check(gpu, (name, &buffer), mesh, &lights, None, &twin, [&mut listed, &mut overflowed])?;
    }
    let counts = format!("{listed} listed, {overflowed} overflowed, {twisted} twisted");
    if listed < 200 || overflowed < 200 || twisted == 0 { Err(format!("too few: {counts}")) } else { Ok(()) }
}

fn check(
    gpu: &Gpu,
    (name, buffer): (&str, &rimline::wgpu::Buffer),
    mesh: &rimline::Mesh,
    lights: &[Light],
    lists: Option<ListOptions>,
    twin: &cpu::Extraction,
    [listed, overflowed]: [&mut usize; 2],
) -> Result<(), String> {
    let options = ExtractorOptions { max_lights: LIGHTS, lists, ..Default::default() };
    let mut extractor = Extractor::new(&gpu.pipelines, mesh, options).map_err(text)?;
    let position_buffer = PositionBuffer { buffer, offset: 0, stride: 12 };
    let extraction = gpu.submit(|encoder| extractor.encode(encoder, position_buffer, lights).map_err(text))?;
    let capacity = extraction.results().map_err(text)?.capacity as usize;
    for light in 0..LIGHTS {
        let what = format!("{name}, {lists:?}, light {light}");
        let expected = twin.silhouette(mesh, light);
        let found = extraction.read_edges(&gpu.queue, mesh, light).map_err(text)?;
        same_silhouettes(&what, &found, &expected)?;
        let fits = expected.edges().len() <= capacity;
        *if fits { &mut *listed } else { &mut *overflowed } += 1;
        if light % 13 == 0 {
            let later = extraction.read_edges_async(&gpu.queue, mesh, light);
            let found = gpu.finish(later)?.map_err(text)?;
            same_silhouettes(&format!("{what}, async"), &found, &expected)?;
            let other = twin.silhouette(mesh, light + 1);
            if other != expected {
                must_fail("another light", &same_silhouettes(&what, &found, &other))?;
            }
        }
    }
    Ok(())
}

fn refused() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (_, positions, mesh) = case("torus", shapes::torus(24, 16, 1.0, 0.4));
    let buffer = gpu.storage(&positions);
    let position_buffer = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    let light = Light::point([3.0, 2.0, 1.0]);
    let list = |capacity| Some(ListOptions { capacity: Some(capacity), ..ListOptions::default() });
    let options = ExtractorOptions { method: Method::PerEdge, lists: list(4), ..Default::default() };
    let mut extractor = Extractor::new(&gpu.pipelines, &mesh, options).map_err(text)?;
    let mut encode = || gpu.submit(|encoder| extractor.encode(encoder, position_buffer, &[light]).map_err(text));
    let first = encode()?;
    let anew = rimline::Mesh::from_faces(positions.len(), mesh.faces().to_vec()).map_err(text)?;
    let clone = mesh.clone();
    let refused = |extraction: &rimline::gpu::Extraction, mesh: &rimline::Mesh, light| {
        extraction.read_edges(&gpu.queue, mesh, light).map(|silhouette| silhouette.edges().len())
    };
    same(
        "refusals",
        &[refused(&first, &anew, 0), refused(&first, &mesh, 1), refused(&first, &clone, 0)],
        &[
            Err(ExtractorError::OtherMesh),
            Err(ExtractorError::NoSuchLight { light: 1, lights: 1 }),
            Err(ExtractorError::NoFacing { light: 0 }),
        ],
    )?;
    let _second = encode()?;
    same("an old one", &[refused(&first, &mesh, 0)], &[Err(ExtractorError::Stale)])
}
