//! Queries of occluder counts on the GPU: the CPU reference's integers, however it is cut, and what is refused.
//!
//! It tests the stage `depth_arguments`, too.

use rimline::gpu::{
    DeviceError, Extractor, ExtractorError, ExtractorOptions, PositionBuffer, QueryError, QueryPoints, ShadowQuery,
    ShadowQueryOptions,
};
use rimline::internals::cpu::{self, Threads};
use rimline::internals::layout::{FaceCluster, FaceRange, LightBatch, PointChunk};
use rimline::internals::stages::{DEPTH_ARGUMENTS, EXACT_SHADOW_DEPTH};
use rimline::mesh::NO_FACE;
use rimline::{Light, LightError, Mesh};
use rimline_testkit::shapes::{self, Shape};

use rimline_testkit::device::Gpu;
use rimline_testkit::dispatch::{Dispatch, uniform};
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::interleaved;
use rimline_testkit::on_gpu::{limited, text};
use rimline_testkit::random::Random;
use rimline_testkit::refusals::{Expected, is, refusal, refused, shows};
use rimline_testkit::shadow_cases::{ShadowCase, lattice, put_on_faces, shadow_cases};
use rimline_testkit::{is_long, lights, must_fail, same};

pub(crate) const TESTS: &[Test] = &[
    ("shadow_boxes_are_those_of_the_twin", boxes),
    ("shadow_depth_is_that_of_the_twin", twin),
    ("shadow_depth_does_not_depend_on_skipping_or_splitting", splits),
    ("shadow_depth_on_small_limits_and_any_stride", small_limits),
    ("shadow_depth_refuses_with_typed_errors", refusing),
    ("shadow_depth_of_an_extraction", extractions),
    ("exact_shadow_depth_counts_anew_within_its_range", recount),
    ("depth_arguments_keep_the_limit_of_a_device_and_reach_all", arguments),
    ("shadow_depth_finds_faces_of_subnormal_extent", subnormal),
    ("shadow_depth_of_as_many_faces_as_a_dispatch_takes", many_faces),
];

/// Offset and stride of points and positions, and how far the face of a point is from it.
const TIGHT: [u64; 3] = [0, 16, 12];

fn mesh_of(shape: &Shape) -> Result<Mesh, String> {
    Mesh::from_faces(shape.positions.len(), shape.faces.clone()).map_err(text)
}

/// The depths as the GPU finds them. Points name a face, if there are faces for them.
fn found(
    gpu: &Gpu,
    case: &ShadowCase,
    on_face: Option<&[u32]>,
    options: ShadowQueryOptions,
    [offset, stride, face_at]: [u64; 3],
) -> Result<Vec<i32>, String> {
    let mut query = ShadowQuery::new(&gpu.pipelines, &mesh_of(&case.shape)?, options).map_err(text)?;
    let mut words = interleaved(&case.points, offset, stride);
    words.resize((offset + stride * case.points.len() as u64) as usize / 4, f32::NAN);
    for (at, &face) in on_face.unwrap_or_default().iter().enumerate() {
        words[(offset + stride * at as u64 + face_at) as usize / 4] = f32::from_bits(face);
    }
    let buffers = [gpu.storage(&interleaved(&case.shape.positions, offset, stride)), gpu.storage(&words)];
    let [positions, points] = buffers.each_ref().map(|buffer| PositionBuffer { buffer, offset, stride });
    let points = QueryPoints { points, on_face: on_face.map(|_| face_at) };
    gpu.submit(|encoder| {
        query.encode_at(encoder, positions, points, case.points.len() as u32, &case.lights).map_err(text)
    })?;
    let found = query.read_occluder_counts(&gpu.queue).map_err(text)?;
    same("as the buffer", &gpu.read::<i32>(query.occluder_counts(), found.len())?, &found)?;
    Ok(found)
}

fn expected(case: &ShadowCase, on_face: Option<&[u32]>) -> Result<Vec<i32>, String> {
    let mesh = mesh_of(&case.shape)?;
    cpu::shadow_depth_on_faces(&case.shape.positions, &mesh, &case.points, on_face, &case.lights, Threads::all())
        .map_err(text)
}

fn room(case: &ShadowCase) -> ShadowQueryOptions {
    ShadowQueryOptions {
        max_points: case.points.len() as u32,
        max_lights: case.lights.len(),
        ..ShadowQueryOptions::default()
    }
}

/// All cases in a long run; else a few, since a software GPU takes a second for each one's pipelines.
fn chosen(mut cases: Vec<ShadowCase>) -> Vec<ShadowCase> {
    const FEW: [&str; 8] =
        ["grazing", "moebius", "soup by 1e-40", "moved by 1e6", "far lights", "lattice", "any magnitude", "not finite"];
    let mut seen = Vec::new();
    cases.retain(|case| {
        let is_new = !seen.contains(&case.name);
        seen.push(case.name.clone());
        is_long() || is_new && FEW.iter().any(|few| case.name.starts_with(few))
    });
    cases
}

/// Points that name no face, then the same points with theirs.
fn twin() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let first = 101;
    println!("seeds from {first}");
    let (rounds, counts) = if is_long() { (2, [100, 33]) } else { (1, [60, 8]) };
    let mut changed = 0;
    for seed in first..first + rounds {
        let mut random = Random::new(seed);
        let mut cases = chosen(shadow_cases(&mut random, counts[0], counts[1]));
        // Many ties.
        cases.push(lattice(&mut random, [20, 500, 33]).0);
        for mut case in cases {
            let name = format!("{}, seed {seed}", case.name);
            let on_face = put_on_faces(&mut random, &case.shape.positions, &case.shape.faces, &mut case.points);
            let (plain, right) = (expected(&case, None)?, expected(&case, Some(&on_face))?);
            let mut depths = found(gpu, &case, None, room(&case), TIGHT)?;
            same(&name, &depths, &plain)?;
            let last = depths.len() - 1;
            depths[last] -= 1;
            must_fail("one less", &same(&name, &depths, &plain))?;
            // A number that the mesh lacks is none.
            let faces = case.shape.faces.len() as u32;
            let lacking = |(at, face): (u32, u32)| if face == NO_FACE && at % 2 == 0 { faces + at } else { face };
            let given: Vec<u32> = (0..).zip(on_face.iter().copied()).map(lacking).collect();
            same(&format!("{name}, on faces"), &found(gpu, &case, Some(&given), room(&case), TIGHT)?, &right)?;
            changed += usize::from(right != plain);
        }
    }
    println!("{changed} cases where faces matter");
    if changed > 3 { Ok(()) } else { Err(format!("only {changed} cases where faces matter")) }
}

/// A mesh of several groups, points and 40 lights, ordinary and not; faces in order and shuffled.
fn larger() -> [ShadowCase; 2] {
    let mut random = Random::new(141);
    let shape = shapes::torus(70, 50, 1.0, 0.4);
    let points: Vec<_> = (0..300).map(|_| random.direction().map(|c| c * random.between(0.0, 2.0))).collect();
    let lights = lights(&mut random, 40);
    let case = ShadowCase { name: "torus".to_owned(), shape, points, lights };
    let mut shuffled = ShadowCase { name: "shuffled".to_owned(), shape: case.shape.shuffled(3), ..case.clone() };
    shuffled.points[17][1] = f32::INFINITY;
    shuffled.shape.positions[1000][0] = f32::NAN;
    // So far away that nothing of it can be decided in f32: its clusters' boxes do not count.
    shuffled.shape.positions[2000] = [1e15, 0.0, 1e15];
    [case, shuffled]
}

fn splits() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for case in larger() {
        let right = expected(&case, None)?;
        for (skip, work) in [(true, 1 << 28), (false, 1)] {
            let options =
                ShadowQueryOptions { skip_by_boxes: skip, work_per_dispatch: work, max_points: 333, ..room(&case) };
            let what = format!("{}, skip {skip}, {work} a dispatch", case.name);
            same(&what, &found(gpu, &case, None, options, TIGHT)?, &right)?;
        }
    }
    // Two encodes in one encoder, fewer points and lights than there is room for; none of a query before is left.
    let case = &larger()[0];
    let few = ShadowCase { points: case.points[..7].to_vec(), lights: case.lights[3..5].to_vec(), ..case.clone() };
    let mut query = ShadowQuery::new(&gpu.pipelines, &mesh_of(&case.shape)?, room(case)).map_err(text)?;
    let buffers = [&case.shape.positions, &case.points].map(|points| gpu.storage(points));
    let [positions, points] = [0, 1].map(|at| PositionBuffer { buffer: &buffers[at], offset: 0, stride: 12 });
    gpu.submit(|encoder| {
        query.encode_at(encoder, positions, points, 300, &case.lights).map_err(text)?;
        query.encode_at(encoder, positions, points, 7, &few.lights).map_err(text)
    })?;
    same("few", &query.read_occluder_counts(&gpu.queue).map_err(text)?, &expected(&few, None)?)?;
    for lights in [&few.lights[..], &[]] {
        gpu.submit(|encoder| query.encode_at(encoder, positions, points, 0, lights).map_err(text))?;
        same("none", &query.read_occluder_counts(&gpu.queue).map_err(text)?, &Vec::new())?;
    }
    same("none is written", &gpu.read::<i32>(query.occluder_counts(), 14)?, &expected(&few, None)?)
}

fn small_limits() -> Result<(), String> {
    let [_, mut case] = larger();
    let plain = expected(&case, None)?;
    let found_on = |binding, workgroups, case: &ShadowCase, on_face, packing| {
        let small = limited(binding, 2 << 20, workgroups)?;
        found(&small, case, on_face, room(case), packing)
    };
    same("48 KiB", &found_on(48 << 10, 64, &case, None, [4, 12, 0])?, &plain)?;
    let on_face = put_on_faces(&mut Random::new(181), &case.shape.positions, &case.shape.faces, &mut case.points);
    let right = expected(&case, Some(&on_face))?;
    must_fail("no face named", &same("torus", &expected(&case, None)?, &right))?;
    for (binding, workgroups, packing) in [(64 << 10, 32, [260, 20, 16]), (128 << 10, 33, [1000, 48, 40])] {
        let depths = found_on(binding, workgroups, &case, Some(&on_face), packing)?;
        same(&format!("{binding} bytes, {workgroups} workgroups"), &depths, &right)?;
    }
    // A dispatch whose 2,048 pairs are all counted anew, more than 32 × 32: every line crosses an edge of each face.
    let corners = |height: f32| [[0.0, height, -100.0], [0.0, height, 100.0], [100.0, height, 0.0]];
    let edges = ShadowCase {
        name: "edges".to_owned(),
        shape: Shape {
            positions: (1..9_u8).flat_map(|height| corners(height.into())).collect(),
            faces: (0..8).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect(),
        },
        points: (0..64_u8).map(|at| [0.0, 0.0, f32::from(at) / 8.0]).collect(),
        lights: (0..32_u8).map(|at| Light::directional([0.0, 1.0, f32::from(at) / 64.0])).collect(),
    };
    same("edges on the CPU", &expected(&edges, None)?, &[8; 2048])?;
    same("edges", &found_on(64 << 10, 32, &edges, None, TIGHT)?, &[8; 2048])
}

fn boxes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(151);
    for case in chosen(shadow_cases(&mut random, 1, 1)).into_iter().skip(3).chain(larger()) {
        let positions = &case.shape.positions;
        let mut query = ShadowQuery::new(&gpu.pipelines, &mesh_of(&case.shape)?, room(&case)).map_err(text)?;
        let buffers = [positions, &case.points].map(|points| gpu.storage(points));
        let [bound, points] = [0, 1].map(|at| PositionBuffer { buffer: &buffers[at], offset: 0, stride: 12 });
        gpu.submit(|encoder| query.encode_at(encoder, bound, points, 1, &case.lights).map_err(text))?;
        let right = cpu::shadow_boxes(positions, &mesh_of(&case.shape)?, Threads::all());
        let mut clusters: Vec<FaceCluster> = gpu.read(query.clusters(), right.len())?;
        same(&case.name, &clusters, &right)?;
        clusters[0].low[1] ^= 1;
        must_fail("another box", &same(&case.name, &clusters, &right))?;
    }
    Ok(())
}

fn refusing() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mesh = mesh_of(&shapes::torus(70, 50, 1.0, 0.4))?;
    let options = ShadowQueryOptions { max_points: 10, max_lights: 2, ..ShadowQueryOptions::default() };
    let new = |gpu: &Gpu, options| ShadowQuery::new(&gpu.pipelines, &mesh, options);
    let with = |change: fn(&mut ShadowQueryOptions)| {
        let mut options = options;
        change(&mut options);
        new(gpu, options)
    };
    let (small, larger) = (limited(8 << 10, 1 << 20, 64)?, limited(16 << 10, 1 << 20, 64)?);
    let many = ShadowQueryOptions { max_lights: 32, max_points: 1000, ..options };
    let of_light = |error| is(QueryError::Light(error));
    let too_many = |count, limit| of_light(LightError::TooMany { count, limit });
    refused([
        refusal("no lights", with(|options| options.max_lights = 0), of_light(LightError::NoRoom)),
        refusal("lights", with(|options| options.max_lights = 1025), too_many(1025, 1024)),
        refusal(
            "depths",
            with(|options| options.max_points = u32::MAX),
            shows(&["BufferTooLarge { label: \"depths\""]),
        ),
        refusal("memory", with(|options| options.memory_limit = Some(1000)), shows(&["MemoryLimit", "limit: 1000"])),
        refusal("small bindings", new(&small, options), shows(&["BindingTooLarge { what: \"a group of faces\""])),
        refusal("many lights", new(&larger, many), shows(&["BindingTooLarge { what: \"64 points\""])),
    ])?;

    let mut query = new(gpu, options).map_err(text)?;
    let vertices = gpu.storage(&vec![[0.0_f32; 3]; 3500]);
    let points = gpu.storage(&[[0.0_f32; 3]; 10]);
    let sized = |size, usage| {
        gpu.device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
    };
    let plain = sized(1 << 16, wgpu::BufferUsages::COPY_DST);
    // Ten points of 16 bytes, the last without its face, and the same with half a word behind them.
    let (with_faces, uneven) = (gpu.storage(&[0_u32; 39]), sized(158, wgpu::BufferUsages::STORAGE));
    let at = |buffer, offset, stride| PositionBuffer { buffer, offset, stride };
    let on_faces = |stride, face| QueryPoints { points: at(&with_faces, 0, stride), on_face: Some(face) };
    let (vertices, good, plain) = (at(&vertices, 0, 12), at(&points, 0, 12), at(&plain, 0, 12));
    let (short, narrow, far) = (at(&points, 4, 12), at(&points, 0, 10), at(&points, 4, u64::MAX - 3));
    let (light, negative) = (Light::point([1.0, 2.0, 3.0]), Light::homogeneous([1.0, 1.0, 1.0, -1.0]));
    gpu.submit(|encoder| {
        for (stride, offset) in [(12, 12), (16, 0), (16, 8), (16, 14), (16, 16), (20, 13), (20, 20), (20, u64::MAX - 3)]
        {
            let made = query.encode_at(encoder, vertices, on_faces(stride, offset), 1, &[light]);
            refused([refusal("an offset", made, is(QueryError::FaceOffset { offset, stride }))])?;
        }
        let ten = query.encode_at(encoder, vertices, on_faces(16, 12), 10, &[light]);
        let nine = query.encode_at(encoder, vertices, on_faces(16, 12), 9, &[light]);
        let faceless = query.encode_at(encoder, vertices, at(&with_faces, 0, 16), 10, &[light]);
        let uneven = query.encode_at(encoder, vertices, at(&uneven, 0, 16), 10, &[light]);
        let mut encode =
            |positions, points, count, lights: &[Light]| query.encode_at(encoder, positions, points, count, lights);
        let negative_w = LightError::NegativeWeight { index: 0, w: -1.0 };
        let many = QueryError::TooManyPoints { count: 11, limit: 10 };
        let stride = QueryError::Points(DeviceError::PositionLayout { offset: 0, stride: 10 });
        refused([
            refusal("many lights", encode(vertices, good, 1, &[light; 3]), too_many(3, 2)),
            refusal("a negative w", encode(vertices, good, 1, &[negative]), of_light(negative_w)),
            refusal("many points", encode(vertices, good, 11, &[light]), is(many)),
            refusal("short positions", encode(good, good, 1, &[light]), shows(&["Device(PositionsTooShort"])),
            refusal(
                "short",
                encode(vertices, short, 10, &[light]),
                shows(&["Points(PositionsTooShort { vertices: 10"]),
            ),
            refusal("a bad stride", encode(vertices, narrow, 1, &[light]), is(stride)),
            refusal(
                "a far stride",
                encode(vertices, far, 1, &[light]),
                shows(&["BindingTooLarge { what: \"64 points\""]),
            ),
            refusal(
                "no storage",
                encode(vertices, plain, 1, &[light]),
                is(QueryError::Points(DeviceError::NotStorage)),
            ),
            refusal("nine faces", ten, shows(&["Points(PositionsTooShort", "needed: 160", "bytes: 156"])),
            refusal("nine points", nine, Expected::Taken),
            refusal("ten points that name no face", faceless, Expected::Taken),
            refusal("ten points before half a word", uneven, Expected::Taken),
            // Without a fault nothing is refused, and no lights are none.
            refusal("good", encode(vertices, good, 10, &[light; 2]), Expected::Taken),
            refusal("no light", encode(vertices, good, 10, &[]), Expected::Taken),
        ])
    })
}

/// A query of an extraction finds what a query of its positions and lights does; one of another mesh, or one whose
/// extractor went on, is refused.
fn extractions() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let shape = shapes::torus(30, 20, 1.0, 0.4);
    let (mesh, other) = (mesh_of(&shape)?, mesh_of(&shape)?);
    let options = ShadowQueryOptions { max_points: 50, max_lights: 2, ..ShadowQueryOptions::default() };
    let new = |mesh| ShadowQuery::new(&gpu.pipelines, mesh, options).map_err(text);
    let (mut query, mut of_other) = (new(&mesh)?, new(&other)?);
    let mut of_clone = new(&mesh.clone())?;
    let lights = [Light::point([2.5, 1.5, 3.0]), Light::directional([0.3, 1.0, 0.2])];
    let buffer = gpu.storage(&interleaved(&shape.positions, 256, 20));
    let bound = PositionBuffer { buffer: &buffer, offset: 256, stride: 20 };
    let points: Vec<[f32; 3]> = shape.positions.iter().take(50).map(|p| p.map(|c| 0.9 * c - 0.05)).collect();
    let stored = gpu.storage(&points);
    let at = PositionBuffer { buffer: &stored, offset: 0, stride: 12 };
    let mut extractor = Extractor::new(&gpu.pipelines, &mesh, ExtractorOptions { max_lights: 2, ..Default::default() })
        .map_err(text)?;
    let extraction = gpu.submit(|encoder| extractor.encode(encoder, bound, &lights).map_err(text))?;
    let read = |query: &ShadowQuery| gpu.read::<i32>(query.occluder_counts(), 100);
    gpu.submit(|encoder| query.encode_at(encoder, bound, at, 50, &lights).map_err(text))?;
    let expected = read(&query)?;
    must_fail("depths of nothing", &same("depths", &expected, &[0; 100]))?;
    for query in [&mut query, &mut of_clone] {
        gpu.submit(|encoder| {
            encoder.clear_buffer(query.occluder_counts(), 0, None);
            query.encode(encoder, &extraction, at, 50).map_err(text)
        })?;
        same("depths of an extraction", &read(query)?, &expected)?;
    }
    gpu.submit(|encoder| {
        let of_other = of_other.encode(encoder, &extraction, at, 50);
        extractor.encode(encoder, bound, &lights[..1]).map_err(text)?;
        let of_before = query.encode(encoder, &extraction, at, 50);
        refused([
            refusal("another mesh", of_other, is(QueryError::OtherMesh)),
            refusal("an extraction of before", of_before, is(QueryError::Extraction(ExtractorError::Stale))),
        ])
    })
}

/// A pair that is counted anew, in a dispatch that goes over some of the faces: those of clusters past the range, in
/// the same group or another, are another dispatch's.
fn recount() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let stage = Dispatch::new(gpu, &EXACT_SHADOW_DEPTH.wgsl(), "exact_shadow_depth_recount");
    // Squares above each other, all of them between.
    let count = 2048;
    let positions: Vec<[f32; 3]> = (0..count)
        .flat_map(|at| {
            let height = 1.0 + at as f32 / 64.0;
            [[-4.0, height, -4.0], [4.0, height, -4.0], [0.0, height, 6.0]]
        })
        .collect();
    let faces: Vec<[u32; 3]> = (0..count).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
    let mesh = Mesh::from_faces(positions.len(), faces).map_err(text)?;
    let light = Light::point([0.1, 100.0, 0.2]);
    let clusters = gpu.storage(&cpu::shadow_boxes(&positions, &mesh, Threads::all()));
    let (positions, points) = (gpu.storage(&positions), gpu.storage(&[[0.0_f32, -1.0, 0.0]]));
    let word = uniform(gpu, &LightBatch::new(&[light], 0, 3));
    let chunk = uniform(gpu, &PointChunk { count: 1, offset: 0, stride: 3, lights: 1, first_light: 0, on_face: 0 });
    for (first, end) in [(0, 40), (32, 64), (0, 64), (32, 33), (0, 1)] {
        let range = uniform(gpu, &FaceRange { first, end, is_first: u32::from(first == 0), before: first });
        let depths = gpu.storage(&[0_i32]);
        // One pair is listed: that of the first point and light.
        let pairs = gpu.storage(&[1_u32, 1, 0, 0, 0, 0, 0]);
        let mut buffers = vec![(0, &word), (1, &chunk), (6, &range), (7, &clusters), (8, &points), (9, &depths)];
        buffers.push((10, &pairs));
        buffers.extend((2..6).map(|window| (window, &positions)));
        stage.run_bound(gpu, &[&buffers], 4)?;
        let found: Vec<i32> = gpu.read(&depths, 1)?;
        same(&format!("clusters {first} to {end}"), &found, &[32 * (end - first) as i32])?;
    }
    Ok(())
}

/// A workgroup for each listed pair and each of three groups, in rows and layers where the device allows few. Its limit
/// may be the largest number of 32 bits, as some drivers say it.
fn arguments() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let range = uniform(gpu, &FaceRange { first: 32, end: 127, is_first: 0, before: 0 });
    for (most, listed, right) in [
        (u32::MAX, 0, [0, 0, 0]),
        (u32::MAX, 1, [3, 1, 1]),
        (65535, 21_845, [65535, 1, 1]),
        (65535, 21_846, [65535, 2, 1]),
        (32, 341, [32, 32, 1]),
        (32, 342, [32, 32, 2]),
    ] {
        let source = DEPTH_ARGUMENTS.wgsl().replace(" = 65535u;", &format!(" = {most}u;"));
        let (dispatch, pairs) = (gpu.storage(&[9_u32; 3]), gpu.storage(&[listed, 7_u32, 0, 0, 0, 0, 0]));
        let stage = Dispatch::new(gpu, &source, "depth_arguments");
        stage.run_bound(gpu, &[&[(2, &dispatch), (6, &range), (10, &pairs)]], 1)?;
        let what = format!("{listed} pairs, {most} workgroups");
        same(&what, &gpu.read::<u32>(&dispatch, 3)?, &right)?;
        same(&what, &gpu.read::<u32>(&pairs, 2)?, &[0, listed])?;
    }
    Ok(())
}

/// Faces that fill the dispatches of a query of few pairs: all of them between, in all lanes, and a soup through which
/// each pair goes elsewhere. llvmpipe ends an invocation's loops after 65,535 turns without a word.
fn many_faces() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(161);
    let count = 40_000;
    let stack = |at: u32| {
        let height = 1.0 + at as f32 / 4096.0;
        [[-4.0, height, -4.0], [4.0, height, -4.0], [0.0, height, 6.0]]
    };
    let soup = (0..count).map(|_| [0; 3].map(|_| random.direction().map(|c| 1.5 * c))).collect::<Vec<_>>();
    for (name, corners) in [("a stack", (0..count).map(stack).collect()), ("a soup", soup)] {
        let case = ShadowCase {
            name: name.to_owned(),
            shape: Shape {
                positions: corners.concat(),
                faces: (0..count).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect(),
            },
            points: vec![[0.0, -1.0, 0.0], [0.1, 0.2, 0.3], [0.0, 2.0, 0.0], [0.3, -5.0, 0.1]],
            lights: vec![Light::point([0.1, 100.0, 0.2]), Light::directional([0.01, 1.0, 0.02])],
        };
        let right = expected(&case, None)?;
        if name == "a stack" {
            same("a stack on the CPU", &right[..2], &[count as i32; 2])?;
        }
        same(name, &found(gpu, &case, None, room(&case), TIGHT)?, &right)?;
    }
    Ok(())
}

/// A face on the segment whose height is subnormal, while the segment is long: where it is flushed to zero, the product with
/// the length is not small. Its box must not be left out.
fn subnormal() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut crossed = 0;
    for exponent in 30..40 {
        let long = 2.0_f32.powi(exponent);
        let step = f32::MIN_POSITIVE;
        let (low, high) = (0.375 * step, 0.625 * step);
        for turn in 0..3 {
            let turned = |[x, y, z]: [f32; 3]| {
                let mut turned = [x, y, z];
                turned.rotate_right(turn);
                turned
            };
            // Halfway between the point, at height 0, and the light, at height `step`.
            let corners = [[-1.0, low, 0.5 * long], [1.0, low, 0.5 * long], [0.0, high, 0.5 * long]];
            let case = ShadowCase {
                name: format!("2^{exponent}, turned {turn}"),
                shape: Shape { positions: corners.map(turned).to_vec(), faces: vec![[0, 1, 2]] },
                points: vec![turned([0.0, 0.0, long])],
                lights: vec![Light::point(turned([0.0, step, 0.0]))],
            };
            let right = expected(&case, None)?;
            crossed += right[0];
            same(&case.name, &found(gpu, &case, None, room(&case), TIGHT)?, &right)?;
        }
    }
    if crossed < 30 { Err(format!("only {crossed} of 30 faces are between")) } else { Ok(()) }
}
