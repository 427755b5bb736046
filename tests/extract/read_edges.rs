//! Silhouettes read back from the GPU, against those of the CPU.

use rimline::Predicate;
use rimline::cpu::{self, Threads};
use rimline::gpu::{Extractor, ExtractorOptions, ListOptions, PositionBuffer};
use rimline::mesh::Weld;
use rimline_testkit::cases::topologies;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::polygons::quad_torus;
use rimline_testkit::random::Random;
use rimline_testkit::{lights, must_fail, same};

pub(crate) const TESTS: &[Test] = &[("edges_that_are_read_are_those_of_the_cpu", read)];

const LIGHTS: usize = 40;

fn read() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(93);
    let bumpy = quad_torus(&mut random, 12, 8, 0.3);
    let polygons = bumpy.mesh(Weld::Position).map_err(text)?;
    let (mut listed, mut overflowed, mut twisted) = (0, 0, 0);
    for (name, positions, mesh) in topologies().into_iter().chain([("polygons".to_owned(), bumpy.positions, polygons)])
    {
        let lights = lights(&mut random, LIGHTS);
        let twin = cpu::extract(&positions, &mesh, &lights, Predicate::Exact, Threads::ONE).map_err(text)?;
        twisted += twin.twisted.iter().filter(|&&lights| lights != 0).count();
        let buffer = gpu.storage(&positions);
        let bound = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
        let list = |capacity, ordered| Some(ListOptions { capacity, ordered, ..ListOptions::default() });
        for lists in [list(None, false), list(Some(u32::MAX), true), list(Some(20), false), list(Some(20), true), None]
        {
            let options = ExtractorOptions { max_lights: LIGHTS, lists, ..Default::default() };
            let mut extractor = Extractor::new(&gpu.pipelines, &mesh, options).map_err(text)?;
            let extraction = gpu.submit(|encoder| extractor.encode(encoder, bound, &lights).map_err(text))?;
            let capacity = extraction.results().map_err(text)?.capacity as usize;
            for light in 0..LIGHTS {
                let what = format!("{name}, {lists:?}, light {light}");
                let expected = twin.silhouette(&mesh, light);
                let found = extraction.read_edges(&gpu.queue, &mesh, light).map_err(text)?;
                same(&what, found.edges(), expected.edges())?;
                *if expected.edges().len() <= capacity { &mut listed } else { &mut overflowed } += 1;
                if light % 13 == 0 {
                    let later = extraction.read_edges_async(&gpu.queue, &mesh, light);
                    let found = gpu.finish(later)?.map_err(text)?;
                    same(&format!("{what}, async"), found.edges(), expected.edges())?;
                    let other = twin.silhouette(&mesh, light + 1);
                    if other != expected {
                        must_fail("another light", &same(&what, found.edges(), other.edges()))?;
                    }
                }
            }
        }
    }
    let counts = format!("{listed} listed, {overflowed} overflowed, {twisted} twisted");
    if listed < 200 || overflowed < 200 || twisted == 0 { Err(format!("too few: {counts}")) } else { Ok(()) }
}
