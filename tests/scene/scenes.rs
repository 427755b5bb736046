//! Random scenes: the results of each caster are those of the caster alone.

use rimline::gpu::{Capacities, SceneOptions};
use rimline::internals::cpu;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{limited, text};
use rimline_testkit::{must_fail, same, shapes};

use crate::found::{Culled, LitFace, certainly_culled, check_frame, checked, read_frame};
use crate::random_scene::RandomScene;

pub(crate) const TESTS: &[Test] = &[
    ("comparators_notice_one_wrong_bit", controls),
    ("lists_of_one_entry_overflow_and_are_counted", overflow),
    ("pools_grow_in_mid_run", growth),
    ("small_devices_cut_groups_and_dispatches", small_device),
    ("a_scene_that_grows_keeps_its_buffers_for_some_frames", headroom),
];

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

fn controls() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::filled(gpu, 1601, roomy(40), [20, 10])?;
    let (frame, mut found) = read_frame(gpu, &mut scene)?;
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
    let relevant = std::mem::replace(&mut found.relevant[caster], 0);
    must_fail("a light that affects the caster and is culled", &check_frame(&scene.content, &frame, &found))?;
    found.relevant[caster] = relevant | 1 << 31;
    must_fail("a light that is not there", &check_frame(&scene.content, &frame, &found))?;
    found.relevant[caster] = relevant;
    for rule in [Culled::ByRange, Culled::ByCone] {
        let content = &scene.content;
        let is_culled = |bit: u32, caster| {
            let light = content.lights.iter().find(|(handle, _)| handle.bit() == bit).map(|(_, light)| *light);
            content.moved_light(caster, bit).is_some()
                && light.and_then(|light| certainly_culled(content, caster, light)) == Some(rule)
        };
        let mut pairs = content.casters.iter().flat_map(|caster| (0..20).map(move |bit| (caster, bit)));
        let (caster, bit) = pairs.find(|&(caster, bit)| is_culled(bit, caster)).ok_or("no such pair")?;
        let (index, _) = frame.locate(caster.handle).ok_or("no caster")?;
        found.relevant[index as usize] ^= 1 << bit;
        must_fail(&format!("a light that is culled {rule:?}"), &check_frame(content, &frame, &found))?;
        found.relevant[index as usize] ^= 1 << bit;
    }
    check_frame(&scene.content, &frame, &found).map(drop)
}

fn overflow() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for seed in 1701..1705 {
        let small = SceneOptions { capacities: Capacities { lists: Some(1), ..Capacities::default() }, ..roomy(8) };
        let found = [roomy(8), small].map(|options| {
            let mut scene = RandomScene::filled(gpu, seed, options, [6, 10])?;
            read_frame(gpu, &mut scene).map(|(_, found)| found)
        });
        let [whole, found] = found;
        let (whole, found) = (whole?, found?);
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

/// Meshes that do not fit the first page, while frames are encoded. Regions of removed meshes are used again.
fn growth() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::filled(gpu, 1901, roomy(8), [2, 0])?;
    for step in 0..6 {
        scene.add_mesh("torus", shapes::torus(40 + 10 * step, 100, 1.0, 0.4))?;
        (0..5).try_for_each(|_| scene.insert(gpu))?;
        checked(gpu, &mut scene).map_err(|error| format!("step {step}: {error}"))?;
        let removed = scene.random.below(scene.content.meshes.len());
        for caster in scene.content.casters.extract_if(.., |caster| caster.mesh == removed) {
            scene.scene.remove(caster.handle).map_err(text)?;
        }
        let (_, handle) = scene.content.meshes.swap_remove(removed);
        scene.scene.remove_mesh(handle).map_err(text)?;
        let last = scene.content.meshes.len();
        scene.content.casters.iter_mut().filter(|caster| caster.mesh == last).for_each(|caster| caster.mesh = removed);
        checked(gpu, &mut scene).map_err(|error| format!("step {step}, without a mesh: {error}"))?;
    }
    let frame = gpu.submit(|encoder| scene.encode(encoder))?;
    if frame.groups() < 2 { Err("one page held everything".to_owned()) } else { Ok(()) }
}

/// Casters with more slots than a binding holds are several groups. Dispatches of more workgroups than the device allows are
/// cut, too.
fn small_device() -> Result<(), String> {
    let gpu = limited(1 << 16, 1 << 20, 1)?;
    let mut cut = 0;
    for seed in 2501..2507 {
        let options = SceneOptions { max_lights: 2, ..Default::default() };
        let mut scene = RandomScene::filled_rigid(&gpu, seed, options, [2, 100])?;
        let (frame, found) = read_frame(&gpu, &mut scene)?;
        if found.groups.iter().any(|group| group.statistics.overflowed_lists > 0) {
            return Err("a list overflowed, so it cannot be compared; take another seed".to_owned());
        }
        check_frame(&scene.content, &frame, &found)?;
        // Casters of one page have one group while its slots fit.
        cut += frame.groups().saturating_sub(scene.content.meshes.len());
    }
    if cut == 0 { Err("no group was cut".to_owned()) } else { Ok(()) }
}

/// One caster more in each frame makes new buffers in few frames.
fn headroom() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::filled(gpu, 2902, roomy(8), [1, 0])?;
    let (mut made, mut last) = (0, None);
    for _ in 0..60 {
        scene.insert_rigid_of(0)?;
        let frame = gpu.submit(|encoder| scene.encode(encoder))?;
        let facing = frame.results().map_err(text)?.groups.first().map(|group| group.facing.clone());
        made += usize::from(facing != last);
        last = facing;
    }
    checked(gpu, &mut scene)?;
    println!("made {made} times in 60 frames");
    if (2..=25).contains(&made) { Ok(()) } else { Err(format!("made {made} times in 60 frames")) }
}
