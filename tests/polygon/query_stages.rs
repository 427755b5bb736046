//! Occluder counts of polygons on the GPU: those of the CPU, however the faces are cut into runs.

use rimline::Light;
use rimline::gpu::{DeviceError, PositionBuffer, QueryError, QueryPoints, ShadowQuery, ShadowQueryOptions};
use rimline::internals::cpu::{self, Threads};
use rimline::mesh::{NO_FACE, Weld};

use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{limited, text};
use rimline_testkit::polygons::{PolygonSet, random_polygon, random_set};
use rimline_testkit::random::Random;
use rimline_testkit::shadow_cases::put_on_faces;
use rimline_testkit::{is_long, must_fail, same};

use crate::depths::DepthCase;

/// One polygon with many corners, whose triangles fill several groups, between others.
fn large_set(random: &mut Random, corners: usize) -> PolygonSet {
    let mut set = random_set(random, 12);
    let ring = |random: &mut Random, height: f32| -> Vec<[f32; 3]> {
        (0..corners)
            .map(|at| {
                let angle = at as f32 / corners as f32 * std::f32::consts::TAU;
                let reach = random.between(1.0, 4.0);
                [reach * angle.cos(), height + random.between(-0.2, 0.2), reach * angle.sin()]
            })
            .collect()
    };
    for height in [0.0, 2.0] {
        let ring = ring(random, height);
        set.push_points(&[ring]);
        set.append(&random_polygon(random, 8).1);
    }
    set
}

pub(crate) const TESTS: &[Test] = &[
    ("depths_equal_their_twin", depths),
    ("depths_of_large_polygons", large),
    ("depths_of_tangled_polygons", tangled),
];

/// The depths of points that are on faces.
fn found(gpu: &Gpu, case: &DepthCase, on_face: &[u32], work_per_dispatch: u64) -> Result<Vec<i32>, String> {
    let DepthCase { set, mesh, points, lights } = case;
    let options = ShadowQueryOptions {
        max_points: points.len() as u32,
        max_lights: lights.len(),
        work_per_dispatch,
        ..ShadowQueryOptions::default()
    };
    let mut query = ShadowQuery::new(&gpu.pipelines, mesh, options).map_err(text)?;
    let words: Vec<_> = points.iter().zip(on_face).map(|(&[x, y, z], &face)| [x, y, z, f32::from_bits(face)]).collect();
    let buffers = [gpu.storage(&set.positions), gpu.storage(&words)];
    let positions = PositionBuffer { buffer: &buffers[0], offset: 0, stride: 12 };
    let asked =
        QueryPoints { points: PositionBuffer { buffer: &buffers[1], offset: 0, stride: 16 }, on_face: Some(12) };
    gpu.submit(|encoder| query.encode_at(encoder, positions, asked, points.len() as u32, lights).map_err(text))?;
    gpu.read(query.occluder_counts(), points.len() * lights.len())
}

fn expected(case: &DepthCase, on_face: &[u32]) -> Result<Vec<i32>, String> {
    let DepthCase { set, mesh, points, lights } = case;
    cpu::shadow_depth_on_faces(&set.positions, mesh, points, Some(on_face), lights, Threads::all()).map_err(text)
}

fn no_faces(case: &DepthCase) -> Vec<u32> {
    vec![NO_FACE; case.points.len()]
}

/// Quadrilaterals and pentagons of whole numbers beside each other, with points below their corners and edges. Many are
/// folded as seen from the light, so that some of their triangles are crossed within and others on an edge.
fn folded(random: &mut Random) -> DepthCase {
    let mut set = PolygonSet::default();
    let mut points = Vec::new();
    for tile in 0..240 {
        let x = 16.0 * tile as f32;
        let sides = if tile < 40 { 4 } else { 5 };
        let corners = (0..sides).map(|_| [x + random.below(5) as f32, random.below(5) as f32, random.below(5) as f32]);
        set.push_points(&[corners.collect()]);
        points.extend((0..25).map(|at| [x + (at / 5) as f32, (at % 5) as f32, -3.0]));
    }
    let mesh = set.mesh(Weld::Position).expect("a mesh");
    DepthCase { set, mesh, points, lights: vec![Light::directional([0.0, 0.0, 1.0])] }
}

/// Points on no faces, then on some.
fn depths() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let first = 232_000;
    println!("seeds from {first}");
    let random =
        (first..first + if is_long() { 300 } else { 12 }).map(|seed| DepthCase::random(&mut Random::new(seed)));
    let (mut sum, mut changed) = (0, 0);
    for (number, mut case) in std::iter::once(folded(&mut Random::new(231))).chain(random).enumerate() {
        let on_face = no_faces(&case);
        let (mut depths, right) = (found(gpu, &case, &on_face, 1 << 28)?, expected(&case, &on_face)?);
        same(&format!("case {number}"), &depths, &right)?;
        sum += right.iter().sum::<i32>();
        let last = depths.len() - 1;
        depths[last] += 1;
        must_fail("one more", &same("one more", &depths, &right))?;
        if !case.mesh.faces().is_empty() {
            let faces = case.mesh.faces();
            let on_face = put_on_faces(&mut Random::new(236), &case.set.positions, faces, &mut case.points);
            let right = expected(&case, &on_face)?;
            same(&format!("case {number}, on faces"), &found(gpu, &case, &on_face, 1 << 28)?, &right)?;
            changed += usize::from(expected(&case, &no_faces(&case))? != right);
        }
    }
    println!("{sum} polygons between, {changed} cases where faces matter");
    if sum > 500 && changed > 2 { Ok(()) } else { Err("too few".to_owned()) }
}

/// Polygons of random corners. Their triangles lie across each other, so a pair may have hundreds of one polygon
/// between, over several groups and dispatches. On whole numbers many of these are undecided, and more than a pair may
/// note. The first case has two batches of lights. The last has many triangles beside polygons, so that a dispatch of few
/// pairs is full.
fn tangled() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(235);
    let mut most = 0;
    for (corners, grid, small, lights) in [(1000, 0, 0, 40), (1500, 9, 0, 3), (400, 5, 3, 3), (600, 0, 35_000, 3)] {
        let mut set = PolygonSet::default();
        let mut point = || match grid {
            0 => random.direction().map(|c| 1.5 * c),
            _ => [0; 3].map(|_| random.below(grid) as f32 - 2.0),
        };
        let mut ring = |count: usize| (0..count).map(|_| point()).collect::<Vec<_>>();
        let ring_of_all = ring(corners);
        set.push_points(&[ring_of_all]);
        for _ in 0..small {
            let triangle = ring(3);
            set.push_points(&[triangle]);
        }
        let second = ring(corners / 2);
        set.push_points(&[second]);
        let points = if grid == 0 { ring(8) } else { (0..8).map(|at| [at as f32 / 2.0 - 2.0, -4.0, 0.5]).collect() };
        let mesh = set.mesh(Weld::Position).map_err(text)?;
        let three =
            [Light::directional([0.0, 1.0, 0.0]), Light::point([0.5, 9.0, 0.5]), Light::point([0.25, 0.5, 0.125])];
        let lights = three.into_iter().cycle().take(lights).collect();
        let case = DepthCase { set, mesh, points, lights };
        let on_face = no_faces(&case);
        let right = expected(&case, &on_face)?;
        most = most.max(right.iter().copied().max().unwrap_or(0));
        for work in [1 << 28, 1] {
            let what = format!("{corners} corners, grid of {grid}, {small} triangles, {work} a dispatch");
            same(&what, &found(gpu, &case, &on_face, work)?, &right)?;
        }
    }
    if most > 1000 { Ok(()) } else { Err(format!("at most {most} between")) }
}

/// Polygons of more triangles than a group, over dispatches and bindings that end within them, and one that no binding
/// holds. Points on no faces, then on some.
fn large() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(233);
    let set = large_set(&mut random, 1600);
    let mut case = DepthCase::new(&mut random, set, 64, 4);
    let none = no_faces(&case);
    let some = put_on_faces(&mut random, &case.set.positions, case.mesh.faces(), &mut case.points);
    must_fail("no face named", &same("large", &expected(&case, &none)?, &expected(&case, &some)?))?;
    // Bindings hold two and three groups of 1,024 faces: the second large polygon does not fit beside the first.
    let bindings = [32 << 10, 48 << 10].map(|binding| Ok::<_, String>((binding, limited(binding, 2 << 20, 64)?)));
    let bindings = bindings.into_iter().collect::<Result<Vec<_>, String>>()?;
    for on_face in [none, some] {
        let right = expected(&case, &on_face)?;
        for work in [1 << 28, 1] {
            same(&format!("{work} a dispatch"), &found(gpu, &case, &on_face, work)?, &right)?;
        }
        for (binding, small) in &bindings {
            same(&format!("{binding} bytes"), &found(small, &case, &on_face, 1 << 28)?, &right)?;
        }
    }
    let small = limited(16 << 10, 2 << 20, 64)?;
    let options = ShadowQueryOptions { max_points: 64, ..ShadowQueryOptions::default() };
    match ShadowQuery::new(&small.pipelines, &case.mesh, options) {
        Err(QueryError::Device(DeviceError::BindingTooLarge { what: "the triangles of a polygon", .. })) => Ok(()),
        other => Err(format!("{:?}", other.err())),
    }
}
