//! Encoders that are dropped, submitted in another order, or hold two frames.

use std::sync::Arc;

use rimline::gpu::{Capacities, SceneFrame, SceneOptions, ShadowError};
use rimline::internals::scene::SceneTable;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::{same, shapes};

use crate::found::{Found, check_frame, sorted_lists};
use crate::random_scene::{Own, RandomScene};

pub(crate) const TESTS: &[Test] = &[
    ("a_dropped_encoder_spoils_nothing", dropped),
    ("swapped_encoders_spoil_nothing", swapped),
    ("two_frames_in_one_encoder", two_frames),
    ("runs_of_removed_meshes_wait_for_late_frames", removed_mesh),
    ("empty_scenes_are_legal", empty),
];

fn encoder(gpu: &Gpu) -> wgpu::CommandEncoder {
    gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default())
}

fn scene(gpu: &Gpu, seed: u64) -> Result<RandomScene, String> {
    println!("seed {seed}");
    let options = SceneOptions {
        max_lights: 40,
        capacities: Capacities { lists: Some(u32::MAX), ..Capacities::default() },
        ..Default::default()
    };
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
            check_frame(&scene.content, &frame, &Found::read(gpu, &frame)?)
                .map_err(|error| format!("{step}: {error}"))?;
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
    let mut noticed = 0;
    for seed in 2201..2221 {
        let mut scene = scene(gpu, seed)?;
        let mut first = encoder(gpu);
        let earlier = scene.encode(&mut first)?;
        let before = scene.content.clone();
        // The buffers of a frame that becomes stale; its results are asked for while it is current.
        let results = earlier.results().map_err(text)?;
        scene.change(gpu)?;
        let mut second = encoder(gpu);
        let later = scene.encode(&mut second)?;
        gpu.queue.submit([second.finish()]);
        check_frame(&scene.content, &later, &Found::read(gpu, &later)?)?;
        gpu.queue.submit([first.finish()]);
        check_frame(&before, &earlier, &Found::of(gpu, &results)?)?;
        same("a stale frame", &[earlier.results().err()], &[Some(ShadowError::StaleFrame)])?;
        scene.change(gpu)?;
        let frame = gpu.submit(|encoder| scene.encode(encoder))?;
        check_frame(&scene.content, &frame, &Found::read(gpu, &frame)?)?;
        // A change may change no result.
        noticed += usize::from(check_frame(&before, &frame, &Found::read(gpu, &frame)?).is_err());
    }
    if noticed < 10 {
        Err(format!("negative control: only {noticed} of 20 other moments were noticed"))
    } else {
        Ok(())
    }
}

/// Each frame of an encoder sees its own scene: the lists of the first are copied before the second overwrites them.
fn two_frames() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for seed in 2301..2321 {
        let (mut scene, mut alone) = (scene(gpu, seed)?, scene(gpu, seed)?);
        let frame = gpu.submit(|encoder| alone.encode(encoder))?;
        let expected = Found::read(gpu, &frame)?;
        check_frame(&alone.content, &frame, &expected)?;

        let mut both = encoder(gpu);
        let first = scene.encode(&mut both)?;
        let results = first.results().map_err(text)?;
        let copy = |list: &wgpu::Buffer| gpu.storage(&vec![0_u32; list.size() as usize / 4]);
        let copies: Vec<_> = results.groups.iter().map(|group| (group.capacity, copy(group.lists))).collect();
        for (group, (_, copy)) in results.groups.iter().zip(&copies) {
            both.copy_buffer_to_buffer(group.lists, 0, copy, 0, copy.size());
        }
        scene.change(gpu)?;
        let second = scene.encode(&mut both)?;
        gpu.queue.submit([both.finish()]);
        check_frame(&scene.content, &second, &Found::read(gpu, &second)?)?;
        same("groups", &[copies.len()], &[expected.groups.len()])?;
        for ((capacity, copy), expected) in copies.iter().zip(&expected.groups) {
            let (counts, lists) = sorted_lists(&gpu.read::<u32>(copy, usize::MAX)?, *capacity);
            same("counts of the first frame", &counts, &expected.counts)?;
            same("lists of the first frame", &lists, &expected.lists)?;
        }
    }
    Ok(())
}

/// A frame that is submitted after its mesh was removed finds the mesh. Later the run of the mesh is used again.
fn removed_mesh() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let shape = shapes::torus(12, 9, 1.0, 0.4);
    let mesh = shape.mesh().map_err(text)?;
    let turned: Vec<_> = shape.positions.iter().map(|[x, y, z]| [-x * 0.5, *z, y + 7.0]).collect();
    let mut scene = scene(gpu, 2401)?;
    let handle = scene.scene.add_mesh(&mesh, &shape.positions).map_err(text)?;
    let add = |scene: &mut RandomScene, handle, positions: &[[f32; 3]]| {
        let case = ("torus".to_owned(), positions.to_vec(), mesh.clone());
        scene.content.meshes.push((Arc::new(case), handle));
        scene.insert_rigid_of(scene.content.meshes.len() - 1)
    };
    add(&mut scene, handle, &shape.positions)?;
    let mut late = encoder(gpu);
    let frame = scene.encode(&mut late)?;
    let (before, results) = (scene.content.clone(), frame.results().map_err(text)?);
    let first_face = |own: &Own, frame: &SceneFrame| {
        let table: Vec<[u32; 4]> = gpu.read(frame.results().map_err(text)?.table, usize::MAX)?;
        let (index, _) = frame.locate(own.handle).ok_or("the frame lacks a caster")?;
        Ok::<_, String>(SceneTable(&table).caster(index).first_face)
    };
    let own = scene.content.casters.pop().ok_or("no caster")?;
    scene.content.meshes.pop();
    scene.scene.remove(own.handle).map_err(text)?;
    scene.scene.remove_mesh(handle).map_err(text)?;
    scene.encode(&mut encoder(gpu))?;
    let second = scene.scene.add_mesh(&mesh, &turned).map_err(text)?;
    add(&mut scene, second, &turned)?;
    gpu.queue.submit([late.finish()]);
    check_frame(&before, &frame, &Found::of(gpu, &results)?)?;
    let place = SceneTable(&Found::of(gpu, &results)?.table).caster(frame.locate(own.handle).map_or(0, |(at, _)| at));

    let frame = gpu.submit(|encoder| scene.encode(encoder))?;
    check_frame(&scene.content, &frame, &Found::read(gpu, &frame)?)?;
    let third = scene.scene.add_mesh(&mesh, &turned).map_err(text)?;
    add(&mut scene, third, &turned)?;
    let frame = gpu.submit(|encoder| scene.encode(encoder))?;
    check_frame(&scene.content, &frame, &Found::read(gpu, &frame)?)?;
    let last = scene.content.casters.last().ok_or("no caster")?;
    same("the run of the removed mesh", &[first_face(last, &frame)?], &[place.first_face])
}

/// No casters, no lights, neither, and both again.
fn empty() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::new(
        gpu,
        2401,
        SceneOptions {
            capacities: Capacities { lists: Some(u32::MAX), ..Capacities::default() },
            ..Default::default()
        },
    )?;
    let check = |scene: &mut RandomScene| {
        let frame = gpu.submit(|encoder| scene.encode(encoder))?;
        let found = Found::read(gpu, &frame)?;
        check_frame(&scene.content, &frame, &found).map(|_| (frame, found.groups.len()))
    };
    check(&mut scene)?;
    scene.add_light()?;
    let (frame, groups) = check(&mut scene)?;
    same("no casters", &[frame.batches(), groups, frame.lights().len()], &[1, 0, 1])?;
    scene.insert(gpu)?;
    check(&mut scene)?;
    let (light, _) = scene.content.lights.swap_remove(0);
    scene.scene.remove_light(light).map_err(text)?;
    let (frame, groups) = check(&mut scene)?;
    same("no lights", &[frame.batches(), groups, frame.lights().len()], &[0, 0, 0])?;
    scene.add_light()?;
    check(&mut scene)?;
    Ok(())
}
