//! Random scenes: the results of each caster are those of the caster alone.

use rimline::gpu::{Capacities, SceneOptions};
use rimline::internals::cpu;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{limited, text};
use rimline_testkit::{must_fail, same, shapes};

use crate::found::{Culled, Found, LitFace, certainly_culled, check_frame, checked, read_frame};
use crate::random_scene::{RandomScene, TestCaster};

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

/// A change of what was found, and its name.
type Flip<'a> = (&'a str, &'a dyn Fn(&mut Found));

fn controls() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::filled(gpu, 1601, roomy(40), [20, 10])?;
    let (frame, mut found) = read_frame(gpu, &mut scene)?;
    let content = &scene.content;
    check_frame(content, &frame, &found)?;
    let LitFace { caster, group: at, slot, bit } = found.lit_face(content, &frame).ok_or("nothing is lit")?;
    let list = found.groups[at].lists.iter().position(|list| !list.is_empty()).ok_or("no silhouette")?;
    let by_rule = |rule| {
        let is_culled = |&(caster, bit): &(&TestCaster, u32)| {
            let light = content.lights.iter().find(|(handle, _)| handle.bit() == bit).map(|(_, light)| *light);
            content.moved_light(caster, bit).is_some()
                && light.and_then(|light| certainly_culled(content, caster, light)) == Some(rule)
        };
        let mut pairs = content.casters.iter().flat_map(|caster| (0..20).map(move |bit| (caster, bit)));
        let (caster, bit) = pairs.find(is_culled)?;
        Some((frame.locate(caster.handle)?.0 as usize, bit))
    };
    let (by_range, range_bit) = by_rule(Culled::ByRange).ok_or("no such pair")?;
    let (by_cone, cone_bit) = by_rule(Culled::ByCone).ok_or("no such pair")?;
    // Each flips a bit, twice.
    let flips: [Flip<'_>; 7] = [
        ("a facing bit", &|found| found.groups[at].facing[slot] ^= bit),
        ("a bit of a light in a plane", &|found| found.groups[at].excluded[slot] ^= bit),
        ("a winding bit", &|found| found.groups[at].lists[list][0] ^= cpu::WINDING),
        ("a light that affects the caster and is culled", &|found| found.relevant[caster] ^= bit),
        ("a light that is not there", &|found| found.relevant[caster] ^= 1 << 31),
        ("a light that is out of range", &|found| found.relevant[by_range] ^= 1 << range_bit),
        ("a light that is beside its cone", &|found| found.relevant[by_cone] ^= 1 << cone_bit),
    ];
    for (what, flip) in flips {
        flip(&mut found);
        must_fail(what, &check_frame(content, &frame, &found))?;
        flip(&mut found);
    }
    found.groups[at].lists[list].pop();
    must_fail("a missing entry", &check_frame(content, &frame, &found))
}

fn overflow() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for seed in 1701..1705 {
        let capacities = Capacities { lists: Some(1), ..Capacities::default() };
        let [whole, found] = [roomy(8), SceneOptions { capacities, ..roomy(8) }].map(|options| {
            let mut scene = RandomScene::filled(gpu, seed, options, [6, 10])?;
            read_frame(gpu, &mut scene).map(|(_, found)| found.groups)
        });
        let (whole, found) = (whole?, found?);
        same("groups", &[found.len()], &[whole.len()])?;
        let mut sum = 0;
        for (found, whole) in found.iter().zip(&whole) {
            same("counts", &found.counts, &whole.counts)?;
            same("facing", &found.facing, &whole.facing)?;
            let overflowed = whole.counts.iter().filter(|&&count| count > 1).count() as u32;
            same("overflowed lists", &[found.statistics.overflowed_lists], &[overflowed])?;
            same("capacity", &[found.capacity], &[1])?;
            for (list, whole) in found.lists.iter().zip(&whole.lists) {
                let is_right = list.len() == whole.len().min(1) && list.iter().all(|entry| whole.contains(entry));
                same(&format!("{list:?} of {whole:?}"), &[is_right], &[true])?;
            }
            let instances: Vec<u32> = found.draws.iter().map(|draw| draw.instance_count).collect();
            let expected = whole.counts.iter().map(|&count| if count > 1 { found.edge_slots } else { count });
            same("instances", &instances, &expected.collect::<Vec<_>>())?;
            sum += overflowed;
        }
        must_fail("no list overflowed", &same("overflowed lists", &[sum], &[0]))?;
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
