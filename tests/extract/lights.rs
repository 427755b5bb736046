//! Numbers of lights, several encodes, refused lights and meshes, lights in mesh space.

use rimline::gpu::{Extractor, ExtractorError, ExtractorOptions, ListOptions, PositionBuffer};
use rimline::internals::cpu::{self, Threads};
use rimline::internals::layout::EdgeMasks;
use rimline::mesh::Weld;
use rimline::{Light, LightError, Mesh, MeshError, Predicate};
use rimline_testkit::shapes;

use rimline_testkit::cases::{Case, case};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{Found, extract, read, text};
use rimline_testkit::oracle::listed;
use rimline_testkit::random::Random;
use rimline_testkit::refusals::{is, refusal, refused, shows};
use rimline_testkit::{lights, must_fail, same};

pub(crate) const TESTS: &[Test] = &[
    ("fewer_lights_than_room_leave_the_other_draws_empty", fewer),
    ("encodes_in_one_encoder_see_their_own_lights", several_encodes),
    ("a_thousand_lights_have_their_lists", thousand),
    ("wrong_lights_and_meshes_are_typed_errors", refusals),
];

fn torus() -> Case {
    case("torus", shapes::torus(24, 16, 1.0, 0.4))
}

fn options(max_lights: usize, masks: bool, ordered: bool) -> ExtractorOptions {
    ExtractorOptions {
        max_lights,
        masks,
        lists: Some(ListOptions { capacity: Some(u32::MAX), ordered, ..ListOptions::default() }),
        ..Default::default()
    }
}

/// Lists and counts of `found` against an extraction for exactly these lights; order aside where there is none.
fn same_lists(what: &str, found: &Found, alone: &Found, count: usize) -> Result<(), String> {
    let sorted = |lists: &[Vec<u32>]| {
        let mut lists = lists[..count].to_vec();
        for list in &mut lists {
            list.sort_by_key(|entry| entry & !cpu::WINDING);
        }
        lists
    };
    same(&format!("{what}, counts"), &found.counts[..count], &alone.counts[..count])?;
    same(&format!("{what}, draws"), &found.draws[..count], &alone.draws[..count])?;
    same(&format!("{what}, lists"), &sorted(&found.lists), &sorted(&alone.lists))
}

fn fewer() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(41);
    let (_, positions, mesh) = torus();
    let buffer = gpu.storage(&positions);
    let bound = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    for ordered in [false, true] {
        let mut extractor = Extractor::new(&gpu.pipelines, &mesh, options(100, true, ordered)).map_err(text)?;
        // First all of them, so that something could be left over.
        for count in [100, 1, 31, 32, 33, 64, 99] {
            let lights = lights(&mut random, count);
            gpu.submit(|encoder| extractor.encode(encoder, bound, &lights).map_err(text))?;
            let found = read(gpu, &extractor, &mesh, 100)?;
            let what = format!("{count} of 100 lights, ordered {ordered}");
            let alone = extract(gpu, &positions, &mesh, &lights, options(count, true, ordered))?;
            same_lists(&what, &found, &alone, count)?;
            same(&format!("{what}, masks"), &found.masks[..alone.masks.len()], &alone.masks)?;
            same(&format!("{what}, facing"), &found.facing[..alone.facing.len()], &alone.facing)?;
            for (light, draw) in found.draws.iter().enumerate().skip(count) {
                if draw.instance_count != 0 || found.counts[light] != 0 || draw.vertex_count != 4 {
                    return Err(format!("{what}: light {light} draws {draw:?}"));
                }
            }
        }
    }
    Ok(())
}

/// Results are copied out between encodes; a later encode must not reach back.
fn several_encodes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(42);
    let (_, positions, mesh) = torus();
    let moved: Vec<_> = positions.iter().map(|[x, y, z]| [x * 0.5, y + 0.3, *z]).collect();
    let [first_buffer, second_buffer] = [gpu.storage(&positions), gpu.storage(&moved)];
    for ordered in [false, true] {
        let mut extractor = Extractor::new(&gpu.pipelines, &mesh, options(40, true, ordered)).map_err(text)?;
        let runs = [(&first_buffer, &positions, 40), (&second_buffer, &moved, 7), (&first_buffer, &positions, 33)];
        let runs = runs.map(|(buffer, positions, count)| (buffer, positions, lights(&mut random, count)));
        let zeros = vec![0_u8; mesh.edges().len() * size_of::<EdgeMasks>()];
        let copies: Vec<_> = runs.iter().map(|_| [gpu.storage(&zeros), gpu.storage(&[0_u32; 40])]).collect();
        gpu.submit(|encoder| {
            for ((buffer, _, lights), [masks, counts]) in runs.iter().zip(&copies) {
                let positions = PositionBuffer { buffer, offset: 0, stride: 12 };
                extractor.encode(encoder, positions, lights).map_err(text)?;
                let results = extractor.results();
                encoder.copy_buffer_to_buffer(&results.masks[0], 0, masks, 0, masks.size());
                encoder.copy_buffer_to_buffer(results.counts, 0, counts, 0, counts.size());
            }
            Ok(())
        })?;
        for (number, ((_, positions, lights), [masks, counts])) in runs.iter().zip(&copies).enumerate() {
            let alone = extract(gpu, positions, &mesh, lights, options(lights.len(), true, ordered))?;
            let masks: Vec<EdgeMasks> = gpu.read(masks, mesh.edges().len())?;
            same(&format!("encode {number}, masks"), &masks, &alone.masks[..masks.len()])?;
            let counts: Vec<u32> = gpu.read(counts, lights.len())?;
            same(&format!("encode {number}, counts"), &counts, &alone.counts)?;
        }
    }
    Ok(())
}

fn thousand() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (_, positions, mesh) = case("blob", shapes::blob(2, 0.4, 3));
    let lights = lights(&mut Random::new(43), 1024);
    for ordered in [false, true] {
        let mut found = extract(gpu, &positions, &mesh, &lights, options(1024, true, ordered))?;
        let facing = cpu::facing(&positions, mesh.faces(), &lights, Predicate::Exact, Threads::all());
        same("facing", &found.facing, &facing)?;
        let masks = cpu::edges(mesh.edges(), &facing, mesh.faces().len(), 1024, Threads::all());
        same("masks", &found.masks, &masks)?;
        for light in 0..1024 {
            let plane = &masks[light / 32 * mesh.edges().len()..][..mesh.edges().len()];
            let expected = listed(plane, light as u32 % 32);
            found.lists[light].sort_by_key(|entry| entry & !cpu::WINDING);
            same(&format!("light {light}, list"), &found.lists[light], &expected)?;
            let draws = [found.draws[light].instance_count, found.counts[light]];
            same(&format!("light {light}, draw"), &draws, &[expected.len() as u32; 2])?;
        }
        found.lists[77].pop();
        must_fail("a lost entry", &same("lists", &found.lists[77], &found.lists[78]))?;
    }
    Ok(())
}

fn refusals() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (_, positions, mesh) = torus();
    let made = |max_lights| Extractor::new(&gpu.pipelines, &mesh, options(max_lights, false, false));
    let of_light = |error| is(ExtractorError::Light(error));
    let mut extractor = made(2).map_err(text)?;
    let buffer = gpu.storage(&positions);
    let bound = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
    let (good, infinite) = (Light::point([1.0, 2.0, 3.0]), [f32::INFINITY, 0.0, 0.0]);
    let not_finite = LightError::NotFinite { index: 0, xyzw: [f32::INFINITY, 0.0, 0.0, 1.0] };
    let nan = |at: usize| Light::homogeneous([0, 1, 2, 3].map(|axis| if axis == at { f32::NAN } else { 1.0 }));
    gpu.submit(|encoder| {
        let mut encode = |lights: &[Light]| extractor.encode(encoder, bound, lights);
        refused([
            refusal("three lights", encode(&[good; 3]), of_light(LightError::TooMany { count: 3, limit: 2 })),
            refusal(
                "zero",
                encode(&[good, Light::homogeneous([0.0, -0.0, 0.0, 0.0])]),
                of_light(LightError::Zero { index: 1 }),
            ),
            refusal("infinite", encode(&[Light::point(infinite)]), of_light(not_finite)),
            refusal(
                "range 0",
                encode(&[good, good.with_range(0.0)]),
                of_light(LightError::Range { index: 1, range: 0.0 }),
            ),
            refusal(
                "range -1",
                encode(&[good.with_range(-1.0)]),
                of_light(LightError::Range { index: 0, range: -1.0 }),
            ),
        ])?;
        let not_finite = || shows(&["Light(NotFinite { index: 0"]);
        refused([0, 1, 2, 3].map(|at| refusal(format!("NaN at {at}"), encode(&[nan(at)]), not_finite())))
    })?;
    let out_of_range = || is(MeshError::IndexOutOfRange { face: 1, corner: 2, index: 3, vertices: 3 });
    let faces = [[0, 1, 2], [0, 1, 3]];
    refused([
        refusal("no room", made(0), of_light(LightError::NoRoom)),
        refusal("1025 lights", made(1025), of_light(LightError::TooMany { count: 1025, limit: 1024 })),
        refusal("no faces", Mesh::new(&positions, &[], Weld::Data), is(MeshError::NoFaces)),
        refusal("index", Mesh::new(&positions[..3], &faces, Weld::Data), out_of_range()),
        refusal("index", Mesh::from_faces(3, faces.to_vec()), out_of_range()),
    ])
}
