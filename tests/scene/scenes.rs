//! Random scenes: each caster comes to what it comes to alone.

use std::sync::Arc;

use rimline::gpu::{Caster, Scene, SceneFrame, SceneOptions};
use rimline::reference::cpu::{self, SceneTable, Threads};
use rimline::{Light, Predicate};
use rimline_measure::band::check_facing;
use rimline_measure::device::Gpu;
use rimline_measure::harness::Test;
use rimline_measure::on_gpu::{limited, text};
use rimline_measure::random::Random;
use rimline_measure::{is_long, must_fail, same, shapes};

use crate::found::{Found, Tally, check_frame};
use crate::random_scene::RandomScene;

pub(crate) const TESTS: &[Test] = &[
    ("casters_of_random_scenes_come_to_what_they_come_to_alone", random_scenes),
    ("forty_lights_are_two_batches", two_batches),
    ("comparators_notice_one_wrong_bit", controls),
    ("lists_of_one_entry_overflow_and_are_counted", overflow),
    ("a_full_list_of_undecided_faces_loses_nothing", undecided_overflow),
    ("pools_grow_in_mid_run", growth),
    ("small_devices_cut_groups_and_dispatches", small_device),
    ("fast_facing_is_right_outside_its_band", fast),
    ("ordinary_scenes_leave_few_faces_undecided", few_undecided),
];

/// Encodes, submits and compares.
fn check(gpu: &Gpu, scene: &mut RandomScene) -> Result<Tally, String> {
    let frame = gpu.submit(|encoder| scene.encode(encoder))?;
    check_frame(&scene.content, &frame, &Found::read(gpu, &frame)?)
}

/// Lists that hold every edge, so that nothing overflows.
fn roomy(max_lights: usize) -> SceneOptions {
    SceneOptions { max_lights, list_capacity: Some(u32::MAX), ..Default::default() }
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
            sum.out_of_range += tally.out_of_range;
            sum.silhouettes += tally.silhouettes;
            sum.in_planes += tally.in_planes;
            scene.change(gpu)?;
        }
    }
    println!("{sum:?}");
    let is_vacuous = sum.lit == 0 || sum.out_of_range == 0 || sum.silhouettes == 0 || sum.in_planes == 0;
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
fn sample(gpu: &Gpu, seed: u64, options: SceneOptions) -> Result<(RandomScene, SceneFrame, Found), String> {
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
    let table = found.table.clone();
    // A caster that some light reaches.
    let index = (0..scene.content.casters.len()).find(|&index| found.lit[index] != 0).ok_or("nothing is lit")?;
    let caster = SceneTable(&table).caster(index as u32);
    let own =
        scene.content.casters.iter().find(|own| frame.place(own.handle).is_some_and(|(at, _)| at as usize == index));
    let (_, group) = own.and_then(|own| frame.place(own.handle)).ok_or("no such caster")?;
    let at = found.groups.iter().position(|found| (found.group, found.batch) == (group, 0)).ok_or("no group")?;
    found.groups[at].facing[caster.first_face_slot as usize] ^= 1;
    must_fail("a flipped facing bit", &check_frame(&scene.content, &frame, &found))?;
    found.groups[at].facing[caster.first_face_slot as usize] ^= 1;
    found.groups[at].excluded[caster.first_face_slot as usize] ^= 1;
    must_fail("a flipped bit of a light in a plane", &check_frame(&scene.content, &frame, &found))?;
    found.groups[at].excluded[caster.first_face_slot as usize] ^= 1;
    let list = found.groups[at].lists.iter().position(|list| !list.is_empty()).ok_or("no silhouette")?;
    found.groups[at].lists[list][0] ^= cpu::WINDING;
    must_fail("a flipped winding bit", &check_frame(&scene.content, &frame, &found))?;
    found.groups[at].lists[list][0] ^= cpu::WINDING;
    let entry = found.groups[at].lists[list].pop();
    must_fail("a missing entry", &check_frame(&scene.content, &frame, &found))?;
    found.groups[at].lists[list].extend(entry);
    found.lit[index] = 0;
    must_fail("a light that reaches and does not matter", &check_frame(&scene.content, &frame, &found))?;
    found.lit[index] = u32::MAX;
    must_fail("a light that is not there", &check_frame(&scene.content, &frame, &found))
}

fn overflow() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for seed in 1701..1705 {
        println!("seed {seed}");
        let (_, _, whole) = sample(gpu, seed, roomy(8))?;
        let small = SceneOptions { max_lights: 8, list_capacity: Some(1), ..Default::default() };
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

fn undecided_overflow() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut undecided = 0;
    for seed in 1801..1811 {
        println!("seed {seed}");
        let options = SceneOptions { undecided_capacity: Some(1), ..roomy(8) };
        let (mut scene, frame, found) = sample(gpu, seed, options)?;
        check_frame(&scene.content, &frame, &found)?;
        undecided += found.groups.iter().map(|group| group.statistics.undecided_pairs).sum::<u32>();
        scene.change(gpu)?;
        check(gpu, &mut scene)?;
    }
    println!("{undecided} undecided pairs");
    if undecided < 1000 { Err("hardly anything was undecided".to_owned()) } else { Ok(()) }
}

/// Meshes that do not fit the first page, while frames are encoded; and runs that are used again.
fn growth() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::new(gpu, 1901, roomy(8))?;
    scene.add_light()?;
    scene.add_light()?;
    for step in 0..6 {
        let shape = shapes::torus(40 + 10 * step, 100, 1.0, 0.4);
        let case = rimline_measure::cases::case("torus", shape);
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

/// Groups of more slots than a binding holds are several, and dispatches of more workgroups than the device allows, too.
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

/// Facing without exact arithmetic errs in its band only, and the lists hold what its masks say.
fn fast() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut silhouettes = 0;
    for seed in 2601..2611 {
        println!("seed {seed}");
        let options = SceneOptions { predicate: Predicate::Fast, ..roomy(8) };
        let (scene, frame, found) = sample(gpu, seed, options)?;
        for own in &scene.content.casters {
            let (index, group) = frame.place(own.handle).ok_or("the frame lacks a caster")?;
            let lit = found.lit[index as usize];
            let bits: Vec<u32> = (0..32).filter(|bit| lit >> bit & 1 != 0).collect();
            let lights = bits.iter().map(|&bit| scene.content.own_light(own, bit));
            let lights: Vec<_> = lights.collect::<Option<_>>().ok_or("a light is not allowed")?;
            if lights.is_empty() {
                continue;
            }
            let (mesh, positions) = scene.content.mesh_and_positions(own);
            let caster = SceneTable(&found.table).caster(index);
            let results = found.group(group, 0)?;
            let slots = caster.first_face_slot as usize..(caster.first_face_slot + caster.faces) as usize;
            let gather =
                |&mask: &u32| bits.iter().zip(0..).fold(0, |all, (bit, place)| all | (mask >> bit & 1) << place);
            let facing: Vec<u32> = results.facing[slots].iter().map(gather).collect();
            check_facing(&format!("caster {index}"), &facing, positions, mesh.faces(), &lights)?;
            let masks = cpu::edges(mesh.edges(), &facing, mesh.faces().len(), lights.len(), Threads::ONE);
            let edges = caster.first_edge_slot..caster.first_edge_slot + caster.edges;
            for (place, &bit) in (0..).zip(&bits) {
                let own = |entry: &&u32| edges.contains(&(**entry & !cpu::WINDING));
                let list = &results.lists[bit as usize];
                let list: Vec<u32> = list.iter().filter(own).map(|entry| entry - edges.start).collect();
                same("list", &list, &cpu::compact(&masks, place, usize::MAX).entries)?;
                silhouettes += list.len();
            }
        }
    }
    if silhouettes == 0 { Err("no silhouettes".to_owned()) } else { Ok(()) }
}

/// Places past the last light of a caster repeat it, and each caster has a bound of its own lights: neither leaves faces
/// undecided that a single mesh would not.
fn few_undecided() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(2801);
    let shape = shapes::torus(30, 20, 1.0, 0.4);
    let mesh = shape.mesh().map_err(text)?;
    for lights in [1, 2, 3, 5, 6, 7] {
        let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, roomy(8)).map_err(text)?;
        let torus = scene.add_mesh(&mesh, &shape.positions).map_err(text)?;
        for _ in 0..lights {
            let xyz = [(); 3].map(|()| random.between(-30.0, 30.0));
            scene.add_light(Light::point(xyz)).map_err(text)?;
        }
        for _ in 0..20 {
            let [x, y, z] = [(); 3].map(|()| random.between(-20.0, 20.0));
            let rows = [[0.6, 0.0, 0.8, x], [0.0, 1.0, 0.0, y], [-0.8, 0.0, 0.6, z]];
            scene.insert(Caster::rigid(torus, rows)).map_err(text)?;
        }
        let frame = gpu.submit(|encoder| scene.encode(encoder, &[], None).map_err(text))?;
        let undecided: u32 = Found::read(gpu, &frame)?.groups.iter().map(|group| group.undecided).sum();
        println!("{lights} lights: {undecided} of {} faces undecided", 20 * mesh.faces().len());
        if undecided as usize * 100 > 20 * mesh.faces().len() {
            return Err(format!("{undecided} faces are undecided"));
        }
    }
    Ok(())
}
