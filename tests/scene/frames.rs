//! Encoders that are dropped, submitted in another order, or hold two frames.

use rimline::gpu::{SceneError, SceneOptions};
use rimline_measure::device::Gpu;
use rimline_measure::harness::Test;
use rimline_measure::must_fail;

use crate::random_scene::RandomScene;
use crate::scenes::{Found, check_frame};

pub(crate) const TESTS: &[Test] = &[
    ("a_dropped_encoder_spoils_nothing", dropped),
    ("swapped_encoders_spoil_nothing", swapped),
    ("two_frames_in_one_encoder", two_frames),
    ("empty_scenes_are_legal", empty),
];

fn encoder(gpu: &Gpu) -> wgpu::CommandEncoder {
    gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
}

fn scene(gpu: &Gpu, seed: u64) -> Result<RandomScene, String> {
    println!("seed {seed}");
    let options = SceneOptions { max_lights: 40, list_capacity: Some(u32::MAX), ..Default::default() };
    let mut scene = RandomScene::new(gpu, seed, options)?;
    for _ in 0..6 {
        scene.add_light()?;
    }
    for _ in 0..8 {
        scene.insert(gpu)?;
    }
    Ok(scene)
}

/// Frames before, between and after dropped ones are right, whatever changed.
fn dropped() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for seed in 2101..2111 {
        let mut scene = scene(gpu, seed)?;
        for step in 0..4 {
            if step % 2 == 0 {
                scene.encode(&mut encoder(gpu))?;
            }
            let frame = gpu.submit(|encoder| scene.encode(encoder))?;
            check_frame(&scene, &frame, &Found::read(gpu, &frame)?).map_err(|error| format!("{step}: {error}"))?;
            scene.change(gpu)?;
            scene.encode(&mut encoder(gpu))?;
            scene.change(gpu)?;
        }
    }
    Ok(())
}

/// A frame that is submitted after a later one has its own results then, and the frame after both is right.
fn swapped() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for seed in 2201..2211 {
        let mut scene = scene(gpu, seed)?;
        let mut first = encoder(gpu);
        let earlier = scene.encode(&mut first)?;
        scene.change(gpu)?;
        let mut second = encoder(gpu);
        let later = scene.encode(&mut second)?;
        gpu.queue.submit([second.finish()]);
        let found = Found::read(gpu, &later)?;
        check_frame(&scene, &later, &found)?;
        gpu.queue.submit([first.finish()]);
        if earlier.check_current() != Err(SceneError::StaleFrame) {
            return Err("an earlier frame is current".to_owned());
        }
        must_fail("results of a stale frame", &earlier.results().map_err(|error| error.to_string()))?;
        scene.change(gpu)?;
        let frame = gpu.submit(|encoder| scene.encode(encoder))?;
        check_frame(&scene, &frame, &Found::read(gpu, &frame)?)?;
    }
    Ok(())
}

/// Each frame of an encoder sees its own scene: what the first left is copied before the second overwrites it.
fn two_frames() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for seed in 2301..2311 {
        let (mut scene, mut alone) = (scene(gpu, seed)?, scene(gpu, seed)?);
        let frame = gpu.submit(|encoder| alone.encode(encoder))?;
        let expected = Found::read(gpu, &frame)?;
        check_frame(&alone, &frame, &expected)?;

        let mut both = encoder(gpu);
        let first = scene.encode(&mut both)?;
        let lists: Vec<_> = first
            .results()
            .map_err(|error| error.to_string())?
            .groups
            .iter()
            .map(|group| group.lists.clone())
            .collect();
        let copies: Vec<_> = lists.iter().map(|list| gpu.storage(&vec![0_u32; list.size() as usize / 4])).collect();
        for (list, copy) in lists.iter().zip(&copies) {
            both.copy_buffer_to_buffer(list, 0, copy, 0, list.size());
        }
        scene.change(gpu)?;
        let second = scene.encode(&mut both)?;
        gpu.queue.submit([both.finish()]);
        check_frame(&scene, &second, &Found::read(gpu, &second)?)?;
        for (copy, expected) in copies.iter().zip(&expected.groups) {
            let counts: Vec<u32> = gpu.read(copy, 32)?;
            rimline_measure::same("counts of the first frame", &counts, &expected.counts)?;
        }
    }
    Ok(())
}

/// No casters, no lights, neither, and both again.
fn empty() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::new(gpu, 2401, SceneOptions { list_capacity: Some(u32::MAX), ..Default::default() })?;
    let check = |scene: &mut RandomScene| {
        let frame = gpu.submit(|encoder| scene.encode(encoder))?;
        let found = Found::read(gpu, &frame)?;
        check_frame(scene, &frame, &found).map(|_| (frame, found.groups.len()))
    };
    check(&mut scene)?;
    scene.add_light()?;
    let (frame, groups) = check(&mut scene)?;
    rimline_measure::same("no casters", &[frame.batches(), groups, frame.lights().len()], &[1, 0, 1])?;
    scene.insert(gpu)?;
    check(&mut scene)?;
    let (light, _) = scene.lights.swap_remove(0);
    scene.scene.remove_light(light).map_err(|error| error.to_string())?;
    let (frame, groups) = check(&mut scene)?;
    rimline_measure::same("no lights", &[frame.batches(), groups, frame.lights().len()], &[0, 0, 0])?;
    scene.add_light()?;
    check(&mut scene)?;
    Ok(())
}
