//! Typed errors for input that a scene refuses.

use rimline::gpu::{
    Caster, CasterPositions, DeformError, DeformerOptions, DeviceError, ExtractorError, FrameInputs, LightMask,
    MAX_BOUNDARY_EDGES, MeshHandle, PositionBuffer, Scene, SceneOptions, ShadowError, StencilCounts,
};
use rimline::{
    DepthDirection, Geometry, GeometryOptions, Instance, InstancePose, Light, LightError, Mesh, Model, Pose,
    ShadowCamera, mesh::Weld,
};
use rimline_testkit::IDENTITY;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{limited, text};
use rimline_testkit::polygons::{PolygonSet, quad_box};
use rimline_testkit::random::Random;
use rimline_testkit::refusals::{Expected, is, refusal, refused, shows};
use rimline_testkit::shapes;

use crate::crowd::Crowd;
use crate::random_scene::encoder;

pub(crate) const TESTS: &[Test] = &[
    ("stale_handles_and_those_of_other_scenes_are_typed_errors", handles),
    ("meshes_lights_and_buffers_that_do_not_fit_are_typed_errors", misfits),
    ("what_does_not_fit_the_memory_is_a_typed_error", memory),
    ("what_fits_a_new_scene_fits_one_that_grew", grown),
    ("meshes_fit_where_memory_is_short_of_a_larger_page", small_pages),
    ("removed_meshes_of_polygons_give_their_memory_back", given_back),
    ("a_removed_mesh_takes_memory_until_the_next_encode", held),
    ("a_removed_model_takes_memory_until_the_next_encode", held_positions),
    ("an_encode_beyond_the_memory_holds_nothing_that_was_removed", held_by_nothing),
    ("more_views_or_groups_than_the_device_allows_are_typed_errors", too_many),
    ("buffers_that_are_destroyed_between_encodes_are_typed_errors", destroyed),
];

const LIGHT: Light = Light::point([1.0, 2.0, 3.0]);

fn cube() -> Result<(Vec<[f32; 3]>, Mesh), String> {
    let shape = shapes::cube();
    let mesh = Mesh::new(&shape.positions, &shape.faces, Weld::Position).map_err(text)?;
    Ok((shape.positions, mesh))
}

/// A scene for two lights within this memory.
fn scene(gpu: &Gpu, memory_limit: Option<u64>) -> Result<Scene, String> {
    let options = SceneOptions { max_lights: 2, memory_limit, ..Default::default() };
    Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)
}

fn add_cube(scene: &mut Scene) -> Result<MeshHandle, String> {
    let (positions, mesh) = cube()?;
    scene.add_mesh(&mesh, &positions).map_err(text)
}

fn handles() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut one, mut other) = (scene(gpu, None)?, scene(gpu, None)?);
    let cube = add_cube(&mut one)?;
    let caster = one.insert(Caster::rigid(cube, IDENTITY)).map_err(text)?;
    let light = one.add_light(LIGHT).map_err(text)?;
    let rows = |scene: &mut Scene, error: fn(&'static str) -> ShadowError| {
        refused([
            refusal("insert", scene.insert(Caster::rigid(cube, IDENTITY)), is(error("mesh"))),
            refusal("remove_mesh", scene.remove_mesh(cube), is(error("mesh"))),
            refusal("set_transform", scene.set_transform(caster, IDENTITY), is(error("caster"))),
            refusal("set_lights", scene.set_lights(caster, LightMask::ALL), is(error("caster"))),
            refusal("remove", scene.remove(caster), is(error("caster"))),
            refusal("set_light", scene.set_light(light, LIGHT), is(error("light"))),
            refusal("remove_light", scene.remove_light(light), is(error("light"))),
        ])
    };
    rows(&mut other, |what| ShadowError::OtherScene { what })?;
    one.remove(caster).map_err(text)?;
    one.remove_light(light).map_err(text)?;
    one.remove_mesh(cube).map_err(text)?;
    // An item that reuses the slot of a removed one has another handle.
    let again = add_cube(&mut one)?;
    one.insert(Caster::rigid(again, IDENTITY)).map_err(text)?;
    one.add_light(LIGHT).map_err(text)?;
    rows(&mut one, |what| ShadowError::Removed { what })
}

fn misfits() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (rest, mesh) = cube()?;
    let mut scene = scene(gpu, None)?;
    let quads = quad_box(1);
    let of_quads = scene.add_mesh(&quads.mesh(Weld::Position).map_err(text)?, &quads.positions).map_err(text)?;
    let of_quads = scene.insert(Caster::rigid(of_quads, IDENTITY)).map_err(text)?;
    let [first, second] = [scene.add_light(LIGHT).map_err(text)?, scene.add_light(LIGHT).map_err(text)?];
    let mut gap = PolygonSet::default();
    gap.push_points(&[(0..=MAX_BOUNDARY_EDGES as u32).map(|n| [n as f32, (n * n) as f32, 0.0]).collect()]);
    let gap = (gap.mesh(Weld::Position).map_err(text)?, gap.positions);
    let too_large = ExtractorError::BoundaryTooLarge { polygon: 0, edges: MAX_BOUNDARY_EDGES + 1 };
    let few = ShadowError::TooFewPositions { given: rest.len() - 1, needed: mesh.vertex_count() };
    let range = ShadowError::Light(LightError::Range { index: 0, range: -1.0 });
    let none = SceneOptions { max_lights: 0, ..Default::default() };
    let none = Scene::new(&gpu.pipelines, &gpu.queue, none);
    refused([
        refusal("positions", scene.add_mesh(&mesh, &rest[1..]), is(few)),
        refusal("faces of polygons", scene.set_excluded(of_quads, second, &[1]), is(ShadowError::Polygons)),
        refusal("a boundary", scene.add_mesh(&gap.0, &gap.1), is(ShadowError::Extraction(too_large))),
        refusal("a third light", scene.add_light(LIGHT), is(ShadowError::NoLightBit { limit: 2 })),
        refusal("a range", scene.set_light(first, LIGHT.with_range(-1.0)), is(range)),
        refusal("no room", none, is(ShadowError::Light(LightError::NoRoom))),
    ])?;
    let cube = add_cube(&mut scene)?;
    let buffer = gpu.storage(&rest);
    let mut insert = |offset, stride| {
        let positions = CasterPositions::Buffer { buffer: buffer.clone(), offset, stride };
        scene.insert(Caster { positions, ..Caster::rigid(cube, IDENTITY) })
    };
    let layout = ShadowError::Device(DeviceError::PositionLayout { offset: 2, stride: 12 });
    refused([
        refusal("an offset", insert(2, 12), is(layout)),
        refusal("a short buffer", insert(12, 12), shows(&["Device(PositionsTooShort"])),
    ])?;
    let caster = insert(0, 12).map_err(text)?;
    // A buffer that is gone when the frame is laid out.
    buffer.destroy();
    let mut encoder = encoder(gpu);
    refused([
        refusal("a transform", scene.set_transform(caster, IDENTITY), is(ShadowError::NotRigid)),
        refusal("a mesh in use", scene.remove_mesh(cube), is(ShadowError::MeshInUse { casters: 1 })),
        refusal(
            "a destroyed buffer",
            scene.encode(&mut encoder, FrameInputs::default()),
            shows(&["Device(BufferRefused"]),
        ),
        refusal("its removal", scene.remove(caster), Expected::Taken),
        refusal("without it", scene.encode(&mut encoder, FrameInputs::default()), Expected::Taken),
        refusal("a mesh in no use", scene.remove_mesh(cube), Expected::Taken),
    ])
}

/// At the origin, looking along x.
fn views(count: usize) -> Vec<rimline::gpu::View<'static>> {
    let view_projection = [[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.1, 0.0]];
    let camera = ShadowCamera { view_projection, origin: [-5.0, 0.0, 0.0], depth: DepthDirection::Reversed };
    vec![camera.into(); count]
}

fn encoded(gpu: &Gpu, scene: &mut Scene, count: usize) -> Result<Result<(), ShadowError>, String> {
    gpu.submit(|encoder| Ok(scene.encode(encoder, FrameInputs::new(&views(count))).map(drop)))
}

/// The error of a memory limit.
fn beyond(limit: u64) -> Expected {
    shows(&["Device(MemoryLimit", &format!("limit: {limit}")])
}

/// A limit refuses a page, results and views, and what fits is taken afterwards. Bindings refuse meshes and views.
fn memory() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (positions, mesh) = cube()?;
    // Statistics take memory without content, too.
    let none = encoded(gpu, &mut scene(gpu, Some(0))?, 0)?;
    let page = scene(gpu, Some(1000))?.add_mesh(&mesh, &positions);
    refused([refusal("a page", page, beyond(1000)), refusal("no memory", none, beyond(0))])?;
    // A page fits, and the results of many casters do not.
    let mut many = scene(gpu, Some(2_000_000))?;
    let cube = add_cube(&mut many)?;
    many.add_light(LIGHT).map_err(text)?;
    let casters = (0..10_000).map(|_| many.insert(Caster::rigid(cube, IDENTITY)).map_err(text));
    let casters = casters.collect::<Result<Vec<_>, _>>()?;
    refused([refusal("results", encoded(gpu, &mut many, 0)?, beyond(2_000_000))])?;
    casters[1..].iter().try_for_each(|&caster| many.remove(caster)).map_err(text)?;
    encoded(gpu, &mut many, 0)?.map_err(text)?;
    // The memory and the bindings have no room for so many views, and still have room for one.
    let mut seen = scene(gpu, Some(4_050_000))?;
    let cube = add_cube(&mut seen)?;
    seen.insert(Caster::rigid(cube, IDENTITY)).map_err(text)?;
    seen.add_light(LIGHT).map_err(text)?;
    for (views, error) in [(1000, "Device(MemoryLimit"), (100_000, "Device(BindingTooLarge")] {
        refused([refusal(format!("{views} views"), encoded(gpu, &mut seen, views)?, shows(&[error]))])?;
        for views in [1, 0, 2] {
            encoded(gpu, &mut seen, views)?.map_err(text)?;
        }
    }
    // The table of draws is refused before the host makes it.
    let stencil = StencilCounts { count_batches: u32::MAX, ..StencilCounts::default() };
    let mut batches =
        Scene::new(&gpu.pipelines, &gpu.queue, SceneOptions { stencil, ..Default::default() }).map_err(text)?;
    let without_lights = encoded(gpu, &mut batches, 1)?;
    batches.add_light(LIGHT).map_err(text)?;
    let table = shows(&["Device(BindingTooLarge { what: \"shadow draw lights\""]);
    refused([
        refusal("batches without lights, at once", without_lights, Expected::Taken),
        refusal("batches of casters", encoded(gpu, &mut batches, 1)?, table),
    ])?;
    // A mesh that one binding does not hold.
    let tight = limited(1 << 16, 1 << 20, 65_535)?;
    let shape = shapes::torus(60, 60, 1.0, 0.4);
    let mesh = Mesh::new(&shape.positions, &shape.faces, Weld::Position).map_err(text)?;
    let large = scene(&tight, None)?.add_mesh(&mesh, &shape.positions);
    refused([refusal("a large mesh", large, shows(&["Device(BindingTooLarge { what: \"faces\""]))])
}

/// Whether casters fit that are inserted one by one, with an encode after each but the first few.
fn fits(memory_limit: u64, one_by_one: usize, casters: usize) -> Result<bool, String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = scene(gpu, Some(memory_limit))?;
    let Ok(cube) = add_cube(&mut scene) else { return Ok(false) };
    scene.add_light(LIGHT).map_err(text)?;
    for number in 1..=casters {
        scene.insert(Caster::rigid(cube, IDENTITY)).map_err(text)?;
        if number + one_by_one >= casters {
            match encoded(gpu, &mut scene, 1)? {
                Ok(()) => {}
                Err(ShadowError::Device(DeviceError::MemoryLimit { .. })) => return Ok(false),
                Err(error) => return Err(error.to_string()),
            }
        }
    }
    Ok(true)
}

/// With the smallest limit at which the casters and a view fit a new scene.
fn grown() -> Result<(), String> {
    let (mut least, mut most) = (0, 1 << 24);
    while most - least > 1 {
        let limit = u64::midpoint(least, most);
        *(if fits(limit, 0, 200)? { &mut most } else { &mut least }) = limit;
    }
    println!("{most} bytes");
    if fits(most, 100, 200)? { Ok(()) } else { Err("a scene that grew does not fit".to_owned()) }
}

/// Two meshes fill a page. The second page would be four times as large, which the memory has no room for.
fn small_pages() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let shape = shapes::torus(60, 60, 1.0, 0.4);
    let mesh = Mesh::new(&shape.positions, &shape.faces, Weld::Position).map_err(text)?;
    let mut scene = scene(gpu, Some(2_000_000))?;
    for number in 0..4 {
        scene.add_mesh(&mesh, &shape.positions).map_err(|error| format!("mesh {number}: {error}"))?;
    }
    refused([refusal("a third page", scene.add_mesh(&mesh, &shape.positions), beyond(2_000_000))])
}

/// Each mesh is larger than those before, so it does not fit where they were.
fn given_back() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let of_box = |cuts| {
        let set = quad_box(cuts);
        Ok::<_, String>((set.mesh(Weld::Position).map_err(text)?, set.positions))
    };
    let boxes = (1..=24).map(of_box).collect::<Result<Vec<_>, String>>()?;
    let [mut alone, mut together] = [scene(gpu, Some(1_000_000))?, scene(gpu, Some(1_000_000))?];
    for (mesh, positions) in &boxes {
        let added = alone.add_mesh(mesh, positions).map_err(text)?;
        alone.remove_mesh(added).map_err(text)?;
    }
    let all = boxes.iter().try_for_each(|(mesh, positions)| together.add_mesh(mesh, positions).map(drop));
    refused([refusal("all at once", all, shows(&["Device(MemoryLimit"]))])
}

/// A beginning within as little memory as can be, and that memory. Each step says how much it needs; a little more covers
/// rounding to whole words.
fn begun<T>(begin: impl Fn(u64) -> Result<Result<T, ShadowError>, String>) -> Result<(T, u64), String> {
    let mut limit = 0;
    loop {
        match begin(limit)? {
            Ok(begun) => return Ok((begun, limit)),
            Err(
                ShadowError::Device(DeviceError::MemoryLimit { bytes, .. })
                | ShadowError::Deform(DeformError::Device(DeviceError::MemoryLimit { bytes, .. })),
            ) => limit = bytes + 1000,
            Err(error) => return Err(error.to_string()),
        }
    }
}

/// The steps of the last encode bind the page of the mesh.
fn held() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let set = quad_box(24);
    let mesh = set.mesh(Weld::Position).map_err(text)?;
    let ((mut scene, of_box, caster), limit) = begun(|limit| {
        let mut scene = scene(gpu, Some(limit))?;
        scene.add_light(LIGHT).map_err(text)?;
        let of_box = match scene.add_mesh(&mesh, &set.positions) {
            Ok(of_box) => of_box,
            Err(error) => return Ok(Err(error)),
        };
        let caster = scene.insert(Caster::rigid(of_box, IDENTITY)).map_err(text)?;
        Ok(encoded(gpu, &mut scene, 0)?.map(|()| (scene, of_box, caster)))
    })?;
    scene.remove(caster).map_err(text)?;
    scene.remove_mesh(of_box).map_err(text)?;
    refused([
        refusal("beside it", scene.add_mesh(&mesh, &set.positions), beyond(limit)),
        refusal("an encode", encoded(gpu, &mut scene, 0)?, Expected::Taken),
        refusal("in its stead", scene.add_mesh(&mesh, &set.positions), Expected::Taken),
    ])
}

/// They bind the positions of a model, too.
fn held_positions() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let crowd = Crowd::new(1)?;
    let pose = crowd.pose(&crowd.walkers(&mut Random::new(4962)))?;
    let insert = |scene: &mut Scene| scene.insert_model(&crowd.model, &pose, DeformerOptions::default());
    let ((mut scene, model), limit) = begun(|limit| {
        let mut scene = scene(gpu, Some(limit))?;
        scene.add_light(LIGHT).map_err(text)?;
        let model = match insert(&mut scene) {
            Ok(model) => model,
            Err(error) => return Ok(Err(error)),
        };
        Ok(encoded(gpu, &mut scene, 0)?.map(|()| (scene, model)))
    })?;
    scene.remove_model(model).map_err(text)?;
    refused([
        refusal("beside it", insert(&mut scene), beyond(limit)),
        refusal("an encode", encoded(gpu, &mut scene, 0)?, Expected::Taken),
        refusal("in its stead", insert(&mut scene), Expected::Taken),
    ])
}

/// Its positions take more than the results. Positions without a face make no results.
fn held_by_nothing() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let geometry = Geometry::new(vec![[0.0; 3]; 60_000], vec![[0, 1, 2]], GeometryOptions::default()).map_err(text)?;
    let model = Model::new(vec![geometry], vec![Instance::new(0, None)]).map_err(text)?;
    let pose = Pose::new(vec![InstancePose::new([IDENTITY], Vec::new()).map_err(text)?]);
    let insert = |scene: &mut Scene| scene.insert_model(&model, &pose, DeformerOptions::default());
    let (positions, mesh) = cube()?;
    let ((mut scene, cube, handle), limit) = begun(|limit| {
        let mut scene = scene(gpu, Some(limit))?;
        scene.add_light(LIGHT).map_err(text)?;
        let added = scene.add_mesh(&mesh, &positions);
        let (cube, handle) = match added.and_then(|cube| Ok((cube, insert(&mut scene)?))) {
            Ok(added) => added,
            Err(error) => return Ok(Err(error)),
        };
        Ok(encoded(gpu, &mut scene, 0)?.map(|()| (scene, cube, handle)))
    })?;
    scene.remove_model(handle).map_err(text)?;
    let casters = (0..30_000).map(|_| scene.insert(Caster::rigid(cube, IDENTITY)).map_err(text));
    let casters = casters.collect::<Result<Vec<_>, _>>()?;
    refused([refusal("many casters", encoded(gpu, &mut scene, 0)?, beyond(limit))])?;
    casters.into_iter().try_for_each(|caster| scene.remove(caster)).map_err(text)?;
    refused([refusal("in its stead", insert(&mut scene), Expected::Taken)])
}

fn too_many() -> Result<(), String> {
    let needs = |subject, needed, there| {
        let limit = "max_compute_workgroups_per_dimension";
        is(ShadowError::Device(DeviceError::Limit { subject, limit, needed, there }))
    };
    let seen = |gpu: &Gpu, views| {
        let mut scene = scene(gpu, None)?;
        let cube = add_cube(&mut scene)?;
        scene.insert(Caster::rigid(cube, IDENTITY)).map_err(text)?;
        scene.add_light(LIGHT).map_err(text)?;
        encoded(gpu, &mut scene, views)
    };
    let (few, more) = (&limited(1 << 27, 1 << 28, 16)?, &limited(1 << 27, 1 << 28, 32)?);
    refused([
        refusal("without a view", seen(few, 0)?, Expected::Taken),
        refusal("volumes", seen(few, 1)?, needs("drawing shadow volumes or outlines", 32, 16)),
        refusal("as many views", seen(more, 32)?, Expected::Taken),
        refusal("a view more", seen(more, 33)?, needs("an encode of so many views", 33, 32)),
    ])?;
    // Each caster with a buffer of its own is a group, with a uniform of 256 bytes.
    let gpu = limited(1 << 16, 1 << 16, 65_535)?;
    let (rest, _) = cube()?;
    let mut scene = scene(&gpu, None)?;
    let cube = add_cube(&mut scene)?;
    scene.add_light(LIGHT).map_err(text)?;
    for _ in 0..257 {
        let positions = PositionBuffer { buffer: &gpu.storage(&rest), offset: 0, stride: 12 };
        scene.insert(Caster::in_buffer(cube, positions)).map_err(text)?;
    }
    let groups = shows(&["Device(BufferTooLarge { label: \"scene dispatches\", bytes: 65792"]);
    refused([refusal("groups", encoded(&gpu, &mut scene, 0)?, groups)])
}

/// The layout of the scene stays, and its steps bind a buffer that is gone.
fn destroyed() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (rest, _) = cube()?;
    let mut scene = scene(gpu, None)?;
    let cube = add_cube(&mut scene)?;
    scene.add_light(LIGHT).map_err(text)?;
    let [kept, gone] = [(); 2].map(|()| gpu.storage(&rest));
    let of = |buffer| PositionBuffer { buffer, offset: 0, stride: 12 };
    let mut insert = |buffer| scene.insert(Caster::in_buffer(cube, of(buffer))).map_err(text);
    insert(&kept)?;
    let casters = [insert(&gone)?, insert(&gone)?];
    encoded(gpu, &mut scene, 1)?.map_err(text)?;
    gone.destroy();
    let buffer_refused = || shows(&["Device(BufferRefused"]);
    refused([
        refusal("a destroyed buffer", encoded(gpu, &mut scene, 1)?, buffer_refused()),
        refusal("the same again", encoded(gpu, &mut scene, 1)?, buffer_refused()),
    ])?;
    casters.into_iter().try_for_each(|caster| scene.set_positions(caster, of(&kept))).map_err(text)?;
    refused([refusal("another buffer", encoded(gpu, &mut scene, 1)?, Expected::Taken)])
}
