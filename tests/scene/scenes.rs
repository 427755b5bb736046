//! Random scenes: each caster comes to what it comes to alone.

use std::sync::Arc;

use rimline::gpu::{Capacities, SceneFrame, SceneOptions};
use rimline::internals::cpu;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{limited, text};
use rimline_testkit::{is_long, must_fail, same, shapes};

use crate::found::{Found, LitFace, Tally, check_frame};
use crate::random_scene::RandomScene;

pub(crate) const TESTS: &[Test] = &[
    ("casters_of_random_scenes_come_to_what_they_come_to_alone", random_scenes),
    ("forty_lights_are_two_batches", two_batches),
    ("comparators_notice_one_wrong_bit", controls),
    ("lists_of_one_entry_overflow_and_are_counted", overflow),
    ("pools_grow_in_mid_run", growth),
    ("small_devices_cut_groups_and_dispatches", small_device),
    ("a_scene_that_grows_keeps_its_buffers_for_some_frames", headroom),
];

/// Encodes, submits and compares.
pub(crate) fn check(gpu: &Gpu, scene: &mut RandomScene) -> Result<Tally, String> {
    let frame = gpu.submit(|encoder| scene.encode(encoder))?;
    check_frame(&scene.content, &frame, &Found::read(gpu, &frame)?)
}

/// Lists that hold every edge, so that nothing overflows.
pub(crate) fn roomy(max_lights: usize) -> SceneOptions {
    // Some meshes of random scenes are in clusters.
    SceneOptions {
        max_lights,
        capacities: Capacities { lists: Some(u32::MAX), ..Capacities::default() },
        clusters_from: Some(100),
        ..Default::default()
    }
}

fn run(seed: u64, scenes: usize, lights: usize, casters: usize) -> Result<(), String> {
    println!("seed {seed}");
    let gpu = &*Gpu::shared()?;
    let mut sum = Tally::default();
    for number in 0..scenes as u64 {
        let mut scene = RandomScene::new(gpu, seed + number, roomy(40))?;
        for _ in 0..scene.random.below(lights) {
            scene.add_light()?;
        }
        for _ in 0..scene.random.below(casters) {
            scene.insert(gpu)?;
        }
        for step in 0..4 {
            let tally = check(gpu, &mut scene).map_err(|error| format!("scene {number}, frame {step}: {error}"))?;
            sum.lit += tally.lit;
            sum.kept += tally.kept;
            sum.out_of_range += tally.out_of_range;
            sum.silhouettes += tally.silhouettes;
            sum.in_planes += tally.in_planes;
            scene.change(gpu)?;
        }
    }
    println!("{sum:?}");
    let is_vacuous =
        sum.lit == 0 || sum.kept == 0 || sum.out_of_range == 0 || sum.silhouettes == 0 || sum.in_planes == 0;
    if is_vacuous { Err(format!("nothing was tried: {sum:?}")) } else { Ok(()) }
}

fn random_scenes() -> Result<(), String> {
    run(1301, if is_long() { 2000 } else { 100 }, 9, 16)
}

fn two_batches() -> Result<(), String> {
    let seed = 1501;
    println!("seed {seed}");
    let gpu = &*Gpu::shared()?;
    for number in 0..if is_long() { 40 } else { 4 } {
        let mut scene = RandomScene::new(gpu, seed + number, roomy(40))?;
        for _ in 0..40 {
            scene.add_light()?;
        }
        for _ in 0..12 {
            scene.insert(gpu)?;
        }
        for _ in 0..3 {
            let tally = check(gpu, &mut scene).map_err(|error| format!("scene {number}: {error}"))?;
            println!("{tally:?}");
            scene.change(gpu)?;
        }
    }
    Ok(())
}

/// A scene with a few casters and lights, extracted.
pub(crate) fn sample(gpu: &Gpu, seed: u64, options: SceneOptions) -> Result<(RandomScene, SceneFrame, Found), String> {
    let mut scene = RandomScene::new(gpu, seed, options)?;
    for _ in 0..6 {
        scene.add_light()?;
    }
    for _ in 0..10 {
        scene.insert(gpu)?;
    }
    let frame = gpu.submit(|encoder| scene.encode(encoder))?;
    let found = Found::read(gpu, &frame)?;
    Ok((scene, frame, found))
}

fn controls() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (scene, frame, mut found) = sample(gpu, 1601, roomy(8))?;
    check_frame(&scene.content, &frame, &found)?;
    let LitFace { caster, group: at, slot, bit } = found.lit_face(&scene.content, &frame).ok_or("nothing is lit")?;
    found.groups[at].facing[slot] ^= bit;
    must_fail("a flipped facing bit", &check_frame(&scene.content, &frame, &found))?;
    found.groups[at].facing[slot] ^= bit;
    found.groups[at].excluded[slot] ^= bit;
    must_fail("a flipped bit of a light in a plane", &check_frame(&scene.content, &frame, &found))?;
    found.groups[at].excluded[slot] ^= bit;
    let list = found.groups[at].lists.iter().position(|list| !list.is_empty()).ok_or("no silhouette")?;
    found.groups[at].lists[list][0] ^= cpu::WINDING;
    must_fail("a flipped winding bit", &check_frame(&scene.content, &frame, &found))?;
    found.groups[at].lists[list][0] ^= cpu::WINDING;
    let entry = found.groups[at].lists[list].pop();
    must_fail("a missing entry", &check_frame(&scene.content, &frame, &found))?;
    found.groups[at].lists[list].extend(entry);
    found.lit[caster] = 0;
    must_fail("a light that reaches and does not matter", &check_frame(&scene.content, &frame, &found))?;
    found.lit[caster] = u32::MAX;
    must_fail("a light that is not there", &check_frame(&scene.content, &frame, &found))
}

fn overflow() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for seed in 1701..1705 {
        println!("seed {seed}");
        let (_, _, whole) = sample(gpu, seed, roomy(8))?;
        let small = SceneOptions { capacities: Capacities { lists: Some(1), ..Capacities::default() }, ..roomy(8) };
        let (_, _, found) = sample(gpu, seed, small)?;
        for (found, whole) in found.groups.iter().zip(&whole.groups) {
            same("counts", &found.counts, &whole.counts)?;
            same("facing", &found.facing, &whole.facing)?;
            let overflowed = whole.counts.iter().filter(|&&count| count > 1).count() as u32;
            same("overflowed lists", &[found.statistics.overflowed_lists], &[overflowed])?;
            for (bit, (list, whole)) in found.lists.iter().zip(&whole.lists).enumerate() {
                if found.capacity != 1 || list.len() > 1 || !list.iter().all(|entry| whole.contains(entry)) {
                    return Err(format!("list {bit} of one entry is {list:?}"));
                }
            }
            for (draw, &count) in found.draws.iter().zip(&whole.counts) {
                let instances = if count > 1 { found.edge_slots } else { count };
                same("instances", &[draw.instance_count], &[instances])?;
            }
        }
        if whole.groups.iter().flat_map(|group| &group.counts).all(|&count| count <= 1) {
            return Err("no list overflowed".to_owned());
        }
    }
    Ok(())
}

/// Meshes that do not fit the first page, while frames are encoded; and runs that are used again.
fn growth() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::new(gpu, 1901, roomy(8))?;
    scene.add_light()?;
    scene.add_light()?;
    for step in 0..6 {
        let shape = shapes::torus(40 + 10 * step, 100, 1.0, 0.4);
        let case = rimline_testkit::cases::case("torus", shape);
        let handle = scene.scene.add_mesh(&case.2, &case.1).map_err(text)?;
        scene.content.meshes.push((Arc::new(case), handle));
        for _ in 0..5 {
            scene.insert(gpu)?;
        }
        check(gpu, &mut scene).map_err(|error| format!("step {step}: {error}"))?;
        // All casters of a mesh go, then the mesh; its run is used again later.
        let gone = scene.random.below(scene.content.meshes.len());
        for own in scene.content.casters.extract_if(.., |own| own.mesh == gone) {
            scene.scene.remove(own.handle).map_err(text)?;
        }
        let (_, handle) = scene.content.meshes.swap_remove(gone);
        scene.scene.remove_mesh(handle).map_err(text)?;
        let last = scene.content.meshes.len();
        scene.content.casters.iter_mut().filter(|own| own.mesh == last).for_each(|own| own.mesh = gone);
        check(gpu, &mut scene).map_err(|error| format!("step {step}, without a mesh: {error}"))?;
    }
    let frame = gpu.submit(|encoder| scene.encode(encoder))?;
    if frame.groups() < 2 { Err("one page held everything".to_owned()) } else { Ok(()) }
}

/// Groups of more slots than a binding holds are several, and dispatches of more workgroups than the device allows,
/// too.
fn small_device() -> Result<(), String> {
    let gpu = limited(1 << 16, 1 << 20, 1)?;
    let mut cut = 0;
    for seed in 2501..2507 {
        println!("seed {seed}");
        let mut scene = RandomScene::new(&gpu, seed, SceneOptions { max_lights: 2, ..Default::default() })?;
        for _ in 0..2 {
            scene.add_light()?;
        }
        for _ in 0..100 {
            scene.insert_rigid()?;
        }
        let frame = gpu.submit(|encoder| scene.encode(encoder))?;
        let found = Found::read(&gpu, &frame)?;
        println!("{} groups of {} meshes", frame.groups(), scene.content.meshes.len());
        if found.groups.iter().any(|group| group.statistics.overflowed_lists > 0) {
            return Err("a list overflowed, so it cannot be compared; take another seed".to_owned());
        }
        check_frame(&scene.content, &frame, &found)?;
        // Casters of one page have one group as long as its slots fit.
        cut += frame.groups().saturating_sub(scene.content.meshes.len());
    }
    if cut == 0 { Err("no group was cut".to_owned()) } else { Ok(()) }
}

/// A caster more in each frame makes the buffers anew in a few frames only.
fn headroom() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::new(gpu, 2902, roomy(8))?;
    scene.add_light()?;
    let (mut made, mut last) = (0, None);
    for step in 0..60 {
        scene.insert_rigid_of(0)?;
        let frame = gpu.submit(|encoder| scene.encode(encoder))?;
        let facing = frame.results().map_err(text)?.groups.first().map(|group| group.facing.clone());
        made += usize::from(facing != last);
        last = facing;
        if step % 20 == 19 {
            check_frame(&scene.content, &frame, &Found::read(gpu, &frame)?)?;
        }
    }
    println!("made {made} times in 60 frames");
    if (2..=25).contains(&made) { Ok(()) } else { Err(format!("made {made} times in 60 frames")) }
}
