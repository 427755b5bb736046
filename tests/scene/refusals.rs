//! Typed errors for input that a scene refuses.

use rimline::gpu::{Caster, CasterPositions, LightMask, MemoryError, PositionError, Scene, SceneError, SceneOptions};
use rimline::{DepthDirection, Light, LightError, Mesh, ShadowCamera, mesh::Weld};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{limited, text};
use rimline_testkit::polygons::quad_box;
use rimline_testkit::{same, shapes};

pub(crate) const TESTS: &[Test] = &[
    ("stale_handles_and_those_of_other_scenes_are_typed_errors", handles),
    ("meshes_in_use_and_missing_positions_are_typed_errors", meshes),
    ("lights_without_room_are_typed_errors", lights),
    ("position_buffers_that_do_not_fit_are_typed_errors", positions),
    ("what_does_not_fit_the_memory_is_a_typed_error", memory),
    ("views_that_do_not_fit_are_refused_once", views),
    ("what_fits_a_new_scene_fits_one_that_grew", grown),
];

const IDENTITY: rimline::Matrix3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

fn cube() -> Result<(Vec<[f32; 3]>, Mesh), String> {
    let shape = shapes::cube();
    let mesh = Mesh::new(&shape.positions, &shape.faces, Weld::Position).map_err(text)?;
    Ok((shape.positions, mesh))
}

fn scene(gpu: &Gpu) -> Result<Scene, String> {
    Scene::new(&gpu.pipelines, &gpu.queue, SceneOptions { max_lights: 2, ..Default::default() }).map_err(text)
}

fn is<T: std::fmt::Debug>(what: &str, got: Result<T, SceneError>, expected: SceneError) -> Result<(), String> {
    same(what, &[got.err()], &[Some(expected)])
}

fn handles() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (positions, mesh) = cube()?;
    let (mut one, mut other) = (scene(gpu)?, scene(gpu)?);
    let cube = one.add_mesh(&mesh, &positions).map_err(text)?;
    let caster = one.insert(Caster::rigid(cube, IDENTITY)).map_err(text)?;
    let light = one.add_light(Light::directional([0.0, 1.0, 0.0])).map_err(text)?;
    let other_scene = |what| SceneError::OtherScene { what };
    is("mesh", other.insert(Caster::rigid(cube, IDENTITY)), other_scene("mesh"))?;
    is("mesh", other.remove_mesh(cube), other_scene("mesh"))?;
    is("caster", other.set_transform(caster, IDENTITY), other_scene("caster"))?;
    is("caster", other.set_lights(caster, LightMask::ALL), other_scene("caster"))?;
    is("caster", other.remove(caster), other_scene("caster"))?;
    is("light", other.set_light(light, Light::point([0.0; 3])), other_scene("light"))?;
    is("light", other.remove_light(light), other_scene("light"))?;
    one.remove(caster).map_err(text)?;
    one.remove_light(light).map_err(text)?;
    one.remove_mesh(cube).map_err(text)?;
    // An item that reuses the slot of a removed one has another handle.
    let again = one.add_mesh(&mesh, &positions).map_err(text)?;
    one.insert(Caster::rigid(again, IDENTITY)).map_err(text)?;
    one.add_light(Light::directional([0.0, 1.0, 0.0])).map_err(text)?;
    let stale = |what| SceneError::Stale { what };
    is("mesh", one.insert(Caster::rigid(cube, IDENTITY)), stale("mesh"))?;
    is("mesh", one.remove_mesh(cube), stale("mesh"))?;
    is("caster", one.set_transform(caster, IDENTITY), stale("caster"))?;
    is("caster", one.set_lights(caster, LightMask::ALL), stale("caster"))?;
    is("caster", one.remove(caster), stale("caster"))?;
    is("light", one.set_light(light, Light::point([0.0; 3])), stale("light"))?;
    is("light", one.remove_light(light), stale("light"))
}

fn meshes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (positions, mesh) = cube()?;
    let mut scene = scene(gpu)?;
    let short = scene.add_mesh(&mesh, &positions[1..]);
    let given = positions.len() - 1;
    is("positions", short, SceneError::TooFewPositions { given, needed: mesh.vertex_count() })?;
    let quads = quad_box(1);
    let of_quads = quads.mesh(Weld::Position).map_err(text)?;
    is("polygons", scene.add_mesh(&of_quads, &quads.positions), SceneError::Polygons)?;
    let cube = scene.add_mesh(&mesh, &positions).map_err(text)?;
    let casters = [(); 2].map(|()| scene.insert(Caster::rigid(cube, IDENTITY)));
    is("a mesh in use", scene.remove_mesh(cube), SceneError::MeshInUse { casters: 2 })?;
    for caster in casters {
        scene.remove(caster.map_err(text)?).map_err(text)?;
    }
    scene.remove_mesh(cube).map_err(text)
}

fn lights() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut two = scene(gpu)?;
    let light = Light::point([1.0, 2.0, 3.0]);
    let first = two.add_light(light).map_err(text)?;
    two.add_light(light).map_err(text)?;
    is("a third light", two.add_light(light), SceneError::NoLightBit { limit: 2 })?;
    let range = |range| SceneError::Light(LightError::Range { index: 0, range });
    is("a range", two.set_light(first, light.with_range(-1.0)), range(-1.0))?;
    let none = SceneOptions { max_lights: 0, ..Default::default() };
    is("no room", Scene::new(&gpu.pipelines, &gpu.queue, none), SceneError::Light(LightError::NoRoom))
}

fn positions() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (rest, mesh) = cube()?;
    let mut scene = scene(gpu)?;
    let cube = scene.add_mesh(&mesh, &rest).map_err(text)?;
    let buffer = gpu.storage(&rest);
    let mut insert = |offset, stride| {
        let positions = CasterPositions::Buffer { buffer: buffer.clone(), offset, stride };
        scene.insert(Caster { positions, ..Caster::rigid(cube, IDENTITY) })
    };
    let alignment = SceneError::Positions(PositionError::Alignment { offset: 2, stride: 12 });
    is("an offset", insert(2, 12), alignment)?;
    match insert(12, 12) {
        Err(SceneError::Positions(PositionError::TooShort { .. })) => {}
        other => return Err(format!("a short buffer: {other:?}")),
    }
    let caster = insert(0, 12).map_err(text)?;
    is("a transform", scene.set_transform(caster, IDENTITY), SceneError::NotRigid)?;
    // A buffer that is gone when the frame is laid out.
    buffer.destroy();
    scene.add_light(Light::point([1.0, 2.0, 3.0])).map_err(text)?;
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    match scene.encode(&mut encoder, &[], None) {
        Err(SceneError::Positions(PositionError::Refused { .. })) => {}
        other => return Err(format!("a destroyed buffer: {other:?}")),
    }
    scene.remove(caster).map_err(text)?;
    scene.encode(&mut encoder, &[], None).map(drop).map_err(text)
}

fn memory() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (positions, mesh) = cube()?;
    let options = SceneOptions { memory_limit: Some(1000), ..Default::default() };
    let mut small = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
    match small.add_mesh(&mesh, &positions) {
        Err(SceneError::Memory(MemoryError::Total { limit: 1000, .. })) => {}
        other => return Err(format!("a page beyond the limit: {other:?}")),
    }
    // A page fits, and the results of many casters do not.
    let options = SceneOptions { memory_limit: Some(2_000_000), ..Default::default() };
    let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
    let cube = scene.add_mesh(&mesh, &positions).map_err(text)?;
    scene.add_light(Light::point([1.0, 2.0, 3.0])).map_err(text)?;
    let casters = (0..10_000).map(|_| scene.insert(Caster::rigid(cube, IDENTITY)).map_err(text));
    let casters = casters.collect::<Result<Vec<_>, _>>()?;
    match gpu.submit(|encoder| Ok(scene.encode(encoder, &[], None))) {
        Ok(Err(SceneError::Memory(MemoryError::Total { limit: 2_000_000, .. }))) => {}
        other => return Err(format!("results beyond the limit: {other:?}")),
    }
    for caster in &casters[1..] {
        scene.remove(*caster).map_err(text)?;
    }
    gpu.submit(|encoder| scene.encode(encoder, &[], None).map_err(text))?;
    // A mesh that one binding does not hold.
    let tight = limited(1 << 16, 1 << 20, 65_535)?;
    let shape = shapes::torus(60, 60, 1.0, 0.4);
    let mesh = Mesh::new(&shape.positions, &shape.faces, Weld::Position).map_err(text)?;
    let mut scene = Scene::new(&tight.pipelines, &tight.queue, SceneOptions::default()).map_err(text)?;
    match scene.add_mesh(&mesh, &shape.positions) {
        Err(SceneError::Memory(MemoryError::Binding { what: "faces", .. })) => Ok(()),
        other => Err(format!("a large mesh: {other:?}")),
    }
}

/// At the origin, looking along x.
fn camera() -> ShadowCamera {
    let view_projection = [[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.1, 0.0]];
    ShadowCamera { view_projection, origin: [-5.0, 0.0, 0.0], depth: DepthDirection::Reversed }
}

/// The memory and the bindings have no room for so many views, and still have room for one.
fn views() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (positions, mesh) = cube()?;
    let options = SceneOptions { memory_limit: Some(4_050_000), ..Default::default() };
    let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
    let cube = scene.add_mesh(&mesh, &positions).map_err(text)?;
    scene.insert(Caster::rigid(cube, IDENTITY)).map_err(text)?;
    scene.add_light(Light::point([1.0, 2.0, 3.0])).map_err(text)?;
    let mut encode = |views| gpu.submit(|encoder| Ok(scene.encode(encoder, &vec![camera(); views], None)));
    for (views, is_memory) in [(1000, true), (100_000, false)] {
        match encode(views)? {
            Err(SceneError::Memory(MemoryError::Total { .. })) if is_memory => {}
            Err(SceneError::Memory(MemoryError::Binding { .. })) if !is_memory => {}
            other => return Err(format!("{views} views: {other:?}")),
        }
        for views in [1, 0, 2] {
            encode(views)?.map_err(text)?;
        }
    }
    Ok(())
}

/// The smallest limit at which some casters and a view fit a new scene.
fn least_limit(casters: usize) -> Result<u64, String> {
    let (mut least, mut most) = (0, 1 << 24);
    while most - least > 1 {
        let limit = u64::midpoint(least, most);
        let fits = grow(Some(limit), 0, casters)?;
        *(if fits { &mut most } else { &mut least }) = limit;
    }
    Ok(most)
}

/// Whether casters fit that are inserted one by one, with an encode after each but the first few.
fn grow(memory_limit: Option<u64>, one_by_one: usize, casters: usize) -> Result<bool, String> {
    let gpu = &*Gpu::shared()?;
    let (positions, mesh) = cube()?;
    let options = SceneOptions { memory_limit, ..Default::default() };
    let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
    let Ok(cube) = scene.add_mesh(&mesh, &positions) else { return Ok(false) };
    scene.add_light(Light::point([1.0, 2.0, 3.0])).map_err(text)?;
    for number in 1..=casters {
        scene.insert(Caster::rigid(cube, IDENTITY)).map_err(text)?;
        if number + one_by_one >= casters {
            match gpu.submit(|encoder| Ok(scene.encode(encoder, &[camera()], None)))? {
                Ok(_) => {}
                Err(SceneError::Memory(MemoryError::Total { .. })) => return Ok(false),
                Err(error) => return Err(error.to_string()),
            }
        }
    }
    Ok(true)
}

fn grown() -> Result<(), String> {
    let limit = least_limit(200)?;
    println!("{limit} bytes");
    if grow(Some(limit - 1), 0, 200)? {
        return Err("the limit is not the smallest".to_owned());
    }
    if grow(Some(limit), 100, 200)? { Ok(()) } else { Err("a scene that grew does not fit".to_owned()) }
}
