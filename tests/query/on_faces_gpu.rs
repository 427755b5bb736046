//! Points that name their face, on the GPU: the CPU's integers, however points lie and the query is cut, and what is
//! refused.

use rimline::gpu::{DeviceError, PositionBuffer, QueryError, QueryPoints, ShadowQuery, ShadowQueryOptions};
use rimline::internals::cpu::{self, Threads};
use rimline::mesh::NO_FACE;
use rimline::{Light, Mesh};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{limited, text};
use rimline_testkit::random::Random;
use rimline_testkit::shadow_cases::{ShadowCase, lattice, put_on_faces, shadow_cases};
use rimline_testkit::shapes::{self, Shape};
use rimline_testkit::{is_long, must_fail, same};

pub(crate) const TESTS: &[Test] = &[
    ("depths_of_points_on_faces_are_those_of_the_twin", twin),
    ("depths_of_points_on_faces_on_small_limits", small_limits),
    ("faces_of_points_are_refused_with_typed_errors", refusals),
];

fn mesh_of(shape: &Shape) -> Result<Mesh, String> {
    Mesh::from_faces(shape.positions.len(), shape.faces.clone()).map_err(text)
}

/// Points and faces in a buffer: where the first point is, how far the next, and how far its face.
fn words(points: &[[f32; 3]], on_face: &[u32], [offset, stride, face_at]: [u64; 3]) -> Vec<u32> {
    let [offset, stride, face_at] = [offset, stride, face_at].map(|bytes| bytes as usize / 4);
    let mut words = vec![0xdead_beef; offset + points.len() * stride];
    for (at, (point, &face)) in points.iter().zip(on_face).enumerate() {
        let of_point = &mut words[offset + at * stride..];
        of_point[..3].copy_from_slice(&point.map(f32::to_bits));
        of_point[face_at] = face;
    }
    words
}

fn found(gpu: &Gpu, case: &ShadowCase, on_face: &[u32], packing: [u64; 3]) -> Result<Vec<i32>, String> {
    let options = ShadowQueryOptions {
        max_points: case.points.len() as u32,
        max_lights: case.lights.len(),
        ..ShadowQueryOptions::default()
    };
    let mut query = ShadowQuery::new(&gpu.pipelines, &mesh_of(&case.shape)?, options).map_err(text)?;
    let positions = gpu.storage(&case.shape.positions);
    let points = gpu.storage(&words(&case.points, on_face, packing));
    let positions = PositionBuffer { buffer: &positions, offset: 0, stride: 12 };
    let [offset, stride, face_at] = packing;
    let points = QueryPoints { points: PositionBuffer { buffer: &points, offset, stride }, on_face: Some(face_at) };
    gpu.submit(|encoder| {
        query.encode_at(encoder, positions, points, case.points.len() as u32, &case.lights).map_err(text)
    })?;
    gpu.read(query.occluder_counts(), case.points.len() * case.lights.len())
}

fn expected(case: &ShadowCase, on_face: Option<&[u32]>) -> Result<Vec<i32>, String> {
    let mesh = mesh_of(&case.shape)?;
    cpu::shadow_depth_on_faces(&case.shape.positions, &mesh, &case.points, on_face, &case.lights, Threads::all())
        .map_err(text)
}

fn twin() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let first = 171;
    println!("seeds from {first}");
    let mut changed = 0;
    for seed in first..first + if is_long() { 6 } else { 1 } {
        let mut random = Random::new(seed);
        let mut cases = vec![lattice(&mut random, [20, 300, 33]).0];
        let every = if is_long() { 1 } else { 5 };
        cases.extend(shadow_cases(&mut random, 60, 8).into_iter().step_by(every));
        for mut case in cases {
            let on_face = put_on_faces(&mut random, &case.shape.positions, &case.shape.faces, &mut case.points);
            let right = expected(&case, Some(&on_face))?;
            let name = format!("{}, seed {seed}", case.name);
            // A number that the mesh lacks is none.
            let faces = case.shape.faces.len() as u32;
            let lacking = |(at, face): (u32, u32)| if face == NO_FACE && at % 2 == 0 { faces + at } else { face };
            let given: Vec<u32> = (0..).zip(on_face.iter().copied()).map(lacking).collect();
            same(&name, &found(gpu, &case, &given, [0, 16, 12])?, &right)?;
            let plain = expected(&case, None)?;
            if right != plain {
                changed += 1;
                must_fail("no face named", &same(&name, &plain, &right))?;
            }
        }
    }
    println!("{changed} cases where faces matter");
    if changed > 3 { Ok(()) } else { Err(format!("only {changed} cases where faces matter")) }
}

fn small_limits() -> Result<(), String> {
    let mut random = Random::new(181);
    let shape = shapes::torus(70, 50, 1.0, 0.4).shuffled(3);
    let points = vec![[0.0; 3]; 300];
    let lights = rimline_testkit::lights(&mut random, 40);
    let mut case = ShadowCase { name: "torus".to_owned(), shape, points, lights };
    let on_face = put_on_faces(&mut random, &case.shape.positions, &case.shape.faces, &mut case.points);
    let right = expected(&case, Some(&on_face))?;
    must_fail("no face named", &same("torus", &expected(&case, None)?, &right))?;
    for (binding, workgroups, packing) in [(48 << 10, 64, [4, 16, 12]), (128 << 10, 33, [1000, 48, 40])] {
        let small = limited(binding, 2 << 20, workgroups)?;
        same(&format!("{binding} bytes"), &found(&small, &case, &on_face, packing)?, &right)?;
    }
    Ok(())
}

fn refusals() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let shape = shapes::globe(4, 2);
    let mut query = ShadowQuery::new(&gpu.pipelines, &mesh_of(&shape)?, ShadowQueryOptions::default()).map_err(text)?;
    let positions = gpu.storage(&shape.positions);
    let positions = PositionBuffer { buffer: &positions, offset: 0, stride: 12 };
    // Ten points of 16 bytes, the last without its face.
    let buffer = gpu.storage(&[0_u32; 39]);
    let mut with = |stride: u64, count: u32, on_face: Option<u64>| {
        let points = QueryPoints { points: PositionBuffer { buffer: &buffer, offset: 0, stride }, on_face };
        let light = [Light::directional([0.0, 0.0, 1.0])];
        gpu.submit(|encoder| Ok(query.encode_at(encoder, positions, points, count, &light)))
    };
    for (stride, offset) in [(12, 12), (16, 0), (16, 8), (16, 14), (16, 16), (20, 13), (20, 20), (20, u64::MAX - 3)] {
        let right = Err(QueryError::FaceOffset { offset, stride });
        same(&format!("{offset} of {stride}"), &[with(stride, 1, Some(offset))?], &[right])?;
    }
    match with(16, 10, Some(12))? {
        Err(QueryError::Points(DeviceError::PositionsTooShort { needed: 160, bytes: 156, .. })) => {}
        other => return Err(format!("a short buffer: {other:?}")),
    }
    same("without faces", &[with(16, 10, None)?], &[Ok(())])?;
    same("nine points", &[with(16, 9, Some(12))?], &[Ok(())])
}
