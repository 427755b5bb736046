//! Zero of anything in a scene: no lights of a caster, no casters, no views, no edges, no polygons, lists without room.
//! Nothing fails, and other casters throw the same shadows as alone.

use std::ops::ControlFlow;

use rimline::cpu::{OccludedFaces, OcclusionOptions};
use rimline::gpu::{
    Capacities, Caster, CasterHandle, DeformerOptions, FrameInputs, LightHandle, LightMask, Pipelines, PositionBuffer,
    Scene, SceneFrame, SceneOptions, ShadowError, StencilCounts, read_back_vec, read_back_vec_async,
};
use rimline::{Counting, DepthDirection, Light, Model, Pose, ShadowCamera};
use rimline_testkit::cases::{CORNERS, without_extent};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{text, views};
use rimline_testkit::refusals::{is, refusal, refused};
use rimline_testkit::{IDENTITY, must_fail, same, shapes};

use crate::histories::volumes;

pub(crate) const TESTS: &[Test] = &[
    ("meshes_without_an_edge_throw_nothing", without_edges),
    ("lists_without_room_lose_nothing", without_room),
    ("no_views_casters_and_faces_are_legal", without_lists),
    ("nothing_is_read_and_warmed_up", without_content),
];

const COUNTINGS: [Counting; 4] = [Counting::Auto, Counting::ZPass, Counting::ZpPlus, Counting::ZFail];

/// A scene with a cube and a plane, or without, and two lights.
struct Stage {
    scene: Scene,
    casters: Vec<CasterHandle>,
    lights: Vec<LightHandle>,
}

impl Stage {
    fn new(gpu: &Gpu, options: SceneOptions, has_casters: bool) -> Result<Self, String> {
        let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, options).map_err(text)?;
        let mut casters = Vec::new();
        for shape in [shapes::cube(), shapes::plane_grid(3, 3)].into_iter().filter(|_| has_casters) {
            let mesh = scene.add_mesh(&shape.mesh().map_err(text)?, &shape.positions).map_err(text)?;
            casters.push(scene.insert(Caster::rigid(mesh, IDENTITY)).map_err(text)?);
        }
        let lights = [Light::point([1.0, 5.0, 2.0]), Light::directional([0.2, 1.0, 0.3])];
        let lights = lights.map(|light| scene.add_light(light).map_err(text));
        Ok(Self { scene, casters, lights: lights.into_iter().collect::<Result<_, _>>()? })
    }

    fn encode(&mut self, gpu: &Gpu, cameras: &[ShadowCamera]) -> Result<SceneFrame, String> {
        gpu.submit(|encoder| self.scene.encode(encoder, FrameInputs::new(&views(cameras))).map_err(text))
    }
}

/// Before the cube, looking at it.
fn eye() -> ShadowCamera {
    let view_projection = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, -1.0], [0.0, 0.0, 0.1, 0.0]];
    ShadowCamera { view_projection, origin: [0.0, 0.5, 6.0], depth: DepthDirection::Reversed }
}

/// By each method, with clusters and without.
fn without_edges() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for (number, counting) in COUNTINGS.into_iter().enumerate() {
        let clusters_from = [None, Some(0)][number % 2];
        let stencil = StencilCounts { bound_counts: true, ..StencilCounts::default() };
        let options = SceneOptions { counting, clusters_from, stencil, ..SceneOptions::default() };
        let [mut alone, mut beside, mut reference] =
            [Stage::new(gpu, options, false)?, Stage::new(gpu, options, true)?, Stage::new(gpu, options, true)?];
        let buffer = gpu.storage(&CORNERS);
        for mesh in without_extent().into_iter().filter(|mesh| mesh.polygons().is_none()) {
            same("edges", &[mesh.edges().is_empty()], &[true])?;
            for scene in [&mut alone.scene, &mut beside.scene] {
                let handle = scene.add_mesh(&mesh, &CORNERS).map_err(text)?;
                scene.insert(Caster::rigid(handle, IDENTITY)).map_err(text)?;
                let positions = PositionBuffer { buffer: &buffer, offset: 0, stride: 12 };
                scene.insert(Caster { in_depth: false, ..Caster::in_buffer(handle, positions) }).map_err(text)?;
            }
        }
        for views in [1, 0, 2] {
            let mut stages = [&mut alone, &mut beside, &mut reference];
            let frames = stages.each_mut().map(|stage| stage.encode(gpu, &vec![eye(); views]));
            let frames = frames.into_iter().collect::<Result<Vec<_>, _>>()?;
            if views > 0 {
                let found = frames.iter().map(|frame| volumes(gpu, frame, views).map(|of| of.instances));
                let found = found.collect::<Result<Vec<_>, _>>()?;
                let nothing = vec![[0; 6]; found[0].len()];
                same(
                    &format!("{counting:?}, {views} views"),
                    &found,
                    &[nothing.clone(), found[2].clone(), found[2].clone()],
                )?;
                must_fail("a cube", &same("nothing", &found[2], &nothing))?;
            }
        }
    }
    Ok(())
}

/// No room is taken as room for one entry, and no batch as one; so lists overflow, of which other tests have pictures.
fn without_room() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for counting in COUNTINGS {
        let found = [Some(0), Some(1), None].map(|room| {
            let capacities = Capacities { lists: room, undecided: room, caps: room, pieces: room };
            let (count_batches, clusters_from) = (room.unwrap_or(1), room.or(Some(4096)));
            let stencil = StencilCounts { count_batches, bound_counts: true, ..StencilCounts::default() };
            let options = SceneOptions { counting, stencil, capacities, clusters_from, ..SceneOptions::default() };
            let frame = Stage::new(gpu, options, true)?.encode(gpu, &[eye()])?;
            volumes(gpu, &frame, 1)
        });
        let [none, one, all] = found;
        let one = one?;
        same(&format!("{counting:?}"), &[&none?], &[&one])?;
        must_fail("room for all", &same("one entry", &[&all?], &[&one]))?;
    }
    Ok(())
}

/// Lists of nothing, of casters, views, faces, polygons and lights.
fn without_lists() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let options = SceneOptions::default();
    let (mut stage, mut reference) = (Stage::new(gpu, options, true)?, Stage::new(gpu, options, true)?);
    let (caster, light) = (stage.casters[0], stage.lights[0]);
    let go_on = |_, _| ControlFlow::Continue(());
    let occluded =
        OccludedFaces::find(Light::point([1.0, 5.0, 2.0]), &[], OcclusionOptions::default(), go_on).map_err(text)?;
    let scene = &mut stage.scene;
    scene.set_excluded(caster, light, &[]).map_err(text)?;
    scene.set_occluders(caster, &[]).map_err(text)?;
    scene.set_occluded_faces(light, &[], Some(&occluded)).map_err(text)?;
    scene.set_occluded_faces(light, &[], None).map_err(text)?;
    let no_corners = ShadowError::OccluderCorners { number: 0, corners: 0 };
    refused([refusal("an occluder without corners", scene.set_occluders(caster, &[&[]]), is(no_corners))])?;
    // No camera; no instances, of a model without any.
    let model = Model::new(Vec::new(), Vec::new()).map_err(text)?;
    let pose = Pose::new(Vec::new());
    let model = stage.scene.insert_model(&model, &pose, DeformerOptions::default()).map_err(text)?;
    same("instances", &[stage.scene.casters(model).map(<[_]>::len)], &[Ok(0)])?;
    let truth = volumes(gpu, &reference.encode(gpu, &[eye()])?, 1)?.instances;
    for cameras in [&[][..], &[eye()]] {
        stage.scene.set_pose(model, &pose).map_err(text)?;
        let frame = gpu.submit(|encoder| {
            stage.scene.deform(encoder, FrameInputs::new(&views(cameras))).map_err(text)?;
            stage.scene.encode(encoder, FrameInputs::new(&views(cameras))).map_err(text)
        })?;
        if !cameras.is_empty() {
            same("volumes", &volumes(gpu, &frame, 1)?.instances, &truth)?;
        }
    }
    stage.scene.remove_model(model).map_err(text)?;
    // Casters for no light, and with no light left.
    for caster in stage.casters.clone() {
        stage.scene.set_lights(caster, LightMask::only([])).map_err(text)?;
    }
    let frame = stage.encode(gpu, &[eye()])?;
    let sum: u32 = volumes(gpu, &frame, 1)?.instances.iter().flatten().sum();
    same("casters for no light", &[sum], &[0])?;
    for light in std::mem::take(&mut stage.lights) {
        stage.scene.remove_light(light).map_err(text)?;
    }
    let frame = stage.encode(gpu, &[eye()])?;
    same("no light", &[frame.lights().len(), frame.batches()], &[0, 0])?;
    let frame = Stage::new(gpu, options, false)?.encode(gpu, &[])?;
    let groups = frame.results().map_err(text)?.groups.len();
    same("no caster", &[frame.lights().len(), frame.batches(), groups], &[2, 1, 0])
}

fn without_content() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let pipelines = Pipelines::new(&gpu.device);
    pipelines.warm_up(&[]).map_err(text)?;
    same("pipelines", &[pipelines.is_empty()], &[true])?;
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("nothing"),
        size: 0,
        usage: wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    let words: Vec<u32> = read_back_vec(&gpu.device, &gpu.queue, &buffer).map_err(text)?;
    same("words", &words, &[])?;
    let words = read_back_vec_async::<u32>(&gpu.device, &gpu.queue, &buffer);
    same("words, without waiting", &pollster::block_on(words).map_err(text)?, &[])
}
