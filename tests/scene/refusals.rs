//! Typed errors for input that a scene refuses.

use rimline::gpu::{
    Caster, CasterPositions, DeviceError, ExtractorError, FrameInputs, LightMask, MAX_BOUNDARY_EDGES, Scene,
    SceneOptions, ShadowError,
};
use rimline::{DepthDirection, Light, LightError, Mesh, ShadowCamera, mesh::Weld};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{limited, text};
use rimline_testkit::polygons::{PolygonSet, quad_box};
use rimline_testkit::refusals::{Expected, is, refusal, refused, shows};
use rimline_testkit::shapes;

use crate::random_scene::IDENTITY;

pub(crate) const TESTS: &[Test] = &[
    ("stale_handles_and_those_of_other_scenes_are_typed_errors", handles),
    ("meshes_in_use_and_missing_positions_are_typed_errors", meshes),
    ("lights_without_room_are_typed_errors", lights),
    ("position_buffers_that_do_not_fit_are_typed_errors", positions),
    ("what_does_not_fit_the_memory_is_a_typed_error", memory),
    ("views_that_do_not_fit_are_refused_once", views),
    ("what_fits_a_new_scene_fits_one_that_grew", grown),
];

fn cube() -> Result<(Vec<[f32; 3]>, Mesh), String> {
    let shape = shapes::cube();
    let mesh = Mesh::new(&shape.positions, &shape.faces, Weld::Position).map_err(text)?;
    Ok((shape.positions, mesh))
}

fn scene(gpu: &Gpu) -> Result<Scene, String> {
    Scene::new(&gpu.pipelines, &gpu.queue, SceneOptions { max_lights: 2, ..Default::default() }).map_err(text)
}

fn handles() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (positions, mesh) = cube()?;
    let (mut one, mut other) = (scene(gpu)?, scene(gpu)?);
    let cube = one.add_mesh(&mesh, &positions).map_err(text)?;
    let caster = one.insert(Caster::rigid(cube, IDENTITY)).map_err(text)?;
    let light = one.add_light(Light::directional([0.0, 1.0, 0.0])).map_err(text)?;
    let rows = |scene: &mut Scene, error: fn(&'static str) -> ShadowError| {
        refused([
            refusal("insert", scene.insert(Caster::rigid(cube, IDENTITY)), is(error("mesh"))),
            refusal("remove_mesh", scene.remove_mesh(cube), is(error("mesh"))),
            refusal("set_transform", scene.set_transform(caster, IDENTITY), is(error("caster"))),
            refusal("set_lights", scene.set_lights(caster, LightMask::ALL), is(error("caster"))),
            refusal("remove", scene.remove(caster), is(error("caster"))),
            refusal("set_light", scene.set_light(light, Light::point([0.0; 3])), is(error("light"))),
            refusal("remove_light", scene.remove_light(light), is(error("light"))),
        ])
    };
    rows(&mut other, |what| ShadowError::OtherScene { what })?;
    one.remove(caster).map_err(text)?;
    one.remove_light(light).map_err(text)?;
    one.remove_mesh(cube).map_err(text)?;
    // An item that reuses the slot of a removed one has another handle.
    let again = one.add_mesh(&mesh, &positions).map_err(text)?;
    one.insert(Caster::rigid(again, IDENTITY)).map_err(text)?;
    one.add_light(Light::directional([0.0, 1.0, 0.0])).map_err(text)?;
    rows(&mut one, |what| ShadowError::Removed { what })
}

fn meshes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (positions, mesh) = cube()?;
    let mut scene = scene(gpu)?;
    let quads = quad_box(1);
    let of_quads = quads.mesh(Weld::Position).map_err(text)?;
    let few = ShadowError::TooFewPositions { given: positions.len() - 1, needed: mesh.vertex_count() };
    refused([refusal("positions", scene.add_mesh(&mesh, &positions[1..]), is(few))])?;
    let quads = scene.add_mesh(&of_quads, &quads.positions).map_err(text)?;
    let quads = scene.insert(Caster::rigid(quads, IDENTITY)).map_err(text)?;
    let light = scene.add_light(Light::directional([0.0, 1.0, 0.0])).map_err(text)?;
    refused([refusal("faces of polygons", scene.set_excluded(quads, light, &[1]), is(ShadowError::Polygons))])?;
    let mut gap = PolygonSet::default();
    gap.push_points(&[(0..=MAX_BOUNDARY_EDGES as u32).map(|n| [n as f32, (n * n) as f32, 0.0]).collect()]);
    let too_large = ExtractorError::BoundaryTooLarge { polygon: 0, edges: MAX_BOUNDARY_EDGES + 1 };
    let added = scene.add_mesh(&gap.mesh(Weld::Position).map_err(text)?, &gap.positions);
    refused([refusal("a boundary", added, is(ShadowError::Extraction(too_large)))])?;
    let cube = scene.add_mesh(&mesh, &positions).map_err(text)?;
    let casters = [(); 2].map(|()| scene.insert(Caster::rigid(cube, IDENTITY)));
    let used = ShadowError::MeshInUse { casters: 2 };
    refused([refusal("a mesh in use", scene.remove_mesh(cube), is(used))])?;
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
    let range = ShadowError::Light(LightError::Range { index: 0, range: -1.0 });
    let none = SceneOptions { max_lights: 0, ..Default::default() };
    let none = Scene::new(&gpu.pipelines, &gpu.queue, none);
    refused([
        refusal("a third light", two.add_light(light), is(ShadowError::NoLightBit { limit: 2 })),
        refusal("a range", two.set_light(first, light.with_range(-1.0)), is(range)),
        refusal("no room", none, is(ShadowError::Light(LightError::NoRoom))),
    ])
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
    refused([
        refusal(
            "an offset",
            insert(2, 12),
            is(ShadowError::Device(DeviceError::PositionLayout { offset: 2, stride: 12 })),
        ),
        refusal("a short buffer", insert(12, 12), shows(&["Device(PositionsTooShort"])),
    ])?;
    let caster = insert(0, 12).map_err(text)?;
    let transform = scene.set_transform(caster, IDENTITY);
    // A buffer that is gone when the frame is laid out.
    buffer.destroy();
    scene.add_light(Light::point([1.0, 2.0, 3.0])).map_err(text)?;
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    refused([
        refusal("a transform", transform, is(ShadowError::NotRigid)),
        refusal(
            "a destroyed buffer",
            scene.encode(&mut encoder, FrameInputs::default()),
            shows(&["Device(BufferRefused"]),
        ),
        refusal("its removal", scene.remove(caster), Expected::Taken),
        refusal("without it", scene.encode(&mut encoder, FrameInputs::default()), Expected::Taken),
    ])
}

fn memory() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (positions, mesh) = cube()?;
    let options = SceneOptions { memory_limit: Some(1000), ..Default::default() };
    let mut small = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
    let page = small.add_mesh(&mesh, &positions);
    // Statistics take memory without content, too.
    let options = SceneOptions { memory_limit: Some(0), ..Default::default() };
    let mut none = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
    let empty = gpu.submit(|encoder| Ok(none.encode(encoder, FrameInputs::default())))?;
    refused([
        refusal("a page beyond the limit", page, shows(&["Device(MemoryLimit", "limit: 1000"])),
        refusal("no memory", empty, shows(&["Device(MemoryLimit", "limit: 0"])),
    ])?;
    // A page fits, and the results of many casters do not.
    let options = SceneOptions { memory_limit: Some(2_000_000), ..Default::default() };
    let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
    let cube = scene.add_mesh(&mesh, &positions).map_err(text)?;
    scene.add_light(Light::point([1.0, 2.0, 3.0])).map_err(text)?;
    let casters = (0..10_000).map(|_| scene.insert(Caster::rigid(cube, IDENTITY)).map_err(text));
    let casters = casters.collect::<Result<Vec<_>, _>>()?;
    let encoded = gpu.submit(|encoder| Ok(scene.encode(encoder, FrameInputs::default())))?;
    refused([refusal("results beyond the limit", encoded, shows(&["Device(MemoryLimit", "limit: 2000000"]))])?;
    for caster in &casters[1..] {
        scene.remove(*caster).map_err(text)?;
    }
    gpu.submit(|encoder| scene.encode(encoder, FrameInputs::default()).map_err(text))?;
    // A mesh that one binding does not hold.
    let tight = limited(1 << 16, 1 << 20, 65_535)?;
    let shape = shapes::torus(60, 60, 1.0, 0.4);
    let mesh = Mesh::new(&shape.positions, &shape.faces, Weld::Position).map_err(text)?;
    let mut scene = Scene::new(&tight.pipelines, &tight.queue, SceneOptions::default()).map_err(text)?;
    let large = scene.add_mesh(&mesh, &shape.positions);
    refused([refusal("a large mesh", large, shows(&["Device(BindingTooLarge { what: \"faces\""]))])
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
    let mut encode =
        |views| gpu.submit(|encoder| Ok(scene.encode(encoder, FrameInputs::new(&vec![camera().into(); views]))));
    for (views, error) in [(1000, "Device(MemoryLimit"), (100_000, "Device(BindingTooLarge")] {
        refused([refusal(format!("{views} views"), encode(views)?, shows(&[error]))])?;
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
            match gpu.submit(|encoder| Ok(scene.encode(encoder, FrameInputs::new(&[camera().into()]))))? {
                Ok(_) => {}
                Err(ShadowError::Device(DeviceError::MemoryLimit { .. })) => return Ok(false),
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
