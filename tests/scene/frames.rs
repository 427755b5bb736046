//! Encoders that hold two frames, meshes that are removed before a frame with them is submitted, and the frames of benches.

use glam::Vec3;
use rimline::Light;
use rimline::gpu::{ExtractorOptions, SceneFrame, SceneOptions};
use rimline::internals::scene::SceneTable;
use rimline_bench::gpu::Gpu as BenchGpu;
use rimline_bench::record::{Camera, ExtractorRecorder, SceneRecorder, Setting, Until};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::{IDENTITY, same, shapes};

use crate::found::{Checked, Found, check_frame, checked, sorted_lists};
use crate::random_scene::{RandomScene, TestCaster, encoder};
use crate::scenes::roomy;

pub(crate) const TESTS: &[Test] = &[
    ("two_frames_in_one_encoder", two_frames),
    ("regions_of_removed_meshes_wait_for_late_frames", removed_mesh),
    ("benches_count_silhouettes_of_all_batches", benches),
];

/// Each frame of an encoder sees its own scene: the lists of the first are copied before the second overwrites them.
fn two_frames() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for seed in 2301..2311 {
        let [scene, alone] = [(); 2].map(|()| RandomScene::filled(gpu, seed, roomy(40), [6, 8]));
        let (mut scene, expected) = (scene?, checked(gpu, &mut alone?)?.found);
        let mut both = encoder(gpu);
        let first = scene.encode(&mut both)?;
        let mut copies = Vec::new();
        for group in first.results().map_err(text)?.groups {
            let copy = gpu.storage(&vec![0_u32; group.lists.size() as usize / 4]);
            both.copy_buffer_to_buffer(group.lists, 0, &copy, 0, copy.size());
            copies.push((group.capacity, copy));
        }
        scene.change(gpu)?;
        let second = scene.encode(&mut both)?;
        gpu.queue.submit([both.finish()]);
        check_frame(&scene.content, &second, &Found::read(gpu, &second)?)?;
        let lists = copies
            .iter()
            .map(|(capacity, copy)| Ok::<_, String>(sorted_lists(&gpu.read::<u32>(copy, usize::MAX)?, *capacity)));
        let expected: Vec<_> = expected.groups.into_iter().map(|group| (group.counts, group.lists)).collect();
        same("the first frame", &lists.collect::<Result<Vec<_>, _>>()?, &expected)?;
    }
    Ok(())
}

/// A frame that is submitted after its mesh was removed finds the mesh. Later its region is used again.
fn removed_mesh() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let shape = shapes::torus(12, 9, 1.0, 0.4);
    let mut turned = shape.clone();
    turned.positions.iter_mut().for_each(|position| *position = [-position[0] * 0.5, position[2], position[1] + 7.0]);
    let mut scene = RandomScene::filled(gpu, 2401, roomy(40), [6, 8])?;
    let add = |scene: &mut RandomScene, shape: &shapes::Shape| {
        let mesh = scene.add_mesh("torus", shape.clone())?;
        scene.insert_rigid_of(mesh)
    };
    let first_face = |table: &[[u32; 4]], caster: &TestCaster, frame: &SceneFrame| {
        let (index, _) = frame.locate(caster.handle).ok_or("the frame lacks a caster")?;
        Ok::<_, String>(SceneTable(table).caster(index).first_face)
    };
    add(&mut scene, &shape)?;
    let mut late = encoder(gpu);
    let frame = scene.encode(&mut late)?;
    let (before, results) = (scene.content.clone(), frame.results().map_err(text)?);
    let caster = scene.content.casters.pop().ok_or("no caster")?;
    let (_, handle) = scene.content.meshes.pop().ok_or("no mesh")?;
    scene.scene.remove(caster.handle).map_err(text)?;
    scene.scene.remove_mesh(handle).map_err(text)?;
    scene.encode(&mut encoder(gpu))?;
    add(&mut scene, &turned)?;
    gpu.queue.submit([late.finish()]);
    let found = Found::of(gpu, &results)?;
    check_frame(&before, &frame, &found)?;
    let expected = first_face(&found.table, &caster, &frame)?;
    checked(gpu, &mut scene)?;
    add(&mut scene, &turned)?;
    let Checked { frame, found } = checked(gpu, &mut scene)?;
    let last = scene.content.casters.last().ok_or("no caster")?;
    same("the region of the removed mesh", &[first_face(&found.table, last, &frame)?], &[expected])
}

/// The recorders of benches count as many silhouette edges for each light in a scene as for a mesh alone, also past the first
/// batch of lights.
fn benches() -> Result<(), String> {
    let (shared, mut random) = Gpu::seeded(2501)?;
    let gpu = &BenchGpu {
        device: shared.device.clone(),
        queue: shared.queue.clone(),
        pipelines: shared.pipelines.clone(),
        reported: Box::new(|| None),
    };
    let shape = shapes::torus(12, 9, 1.0, 0.4);
    let lights: Vec<_> = (0..40).map(|_| Light::point(random.direction().map(|c| 5.0 * c))).collect();
    let options = ExtractorOptions { max_lights: lights.len(), ..ExtractorOptions::default() };
    let mesh = shape.mesh().map_err(text)?;
    let mut alone = ExtractorRecorder::new(gpu, options, &mesh, &shape.positions, &lights).map_err(text)?;
    let options = SceneOptions { max_lights: lights.len(), ..SceneOptions::default() };
    let camera = Camera::level(Vec3::new(0.0, 0.0, 4.0), Vec3::NEG_Z, 1.0, 0.1);
    let setting = Setting::rigid(vec![shape], vec![(0, IDENTITY)], lights, &camera);
    let mut scene = SceneRecorder::new(gpu, &setting, None, options).map_err(text)?;
    shared.submit(|encoder| {
        alone.encode(encoder, None).map_err(text)?;
        scene.encode(encoder, Until::Extraction, None).map_err(text)
    })?;
    let [found, expected] = [scene.silhouette_edges(gpu), alone.silhouette_edges(gpu)];
    same("silhouette edges", &found.map_err(text)?, &expected.map_err(text)?)
}
