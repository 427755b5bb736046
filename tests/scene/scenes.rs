//! Random scenes: each caster comes to what it comes to alone.

use rimline::gpu::{ExtractionStatistics, SceneFrame, SceneOptions};
use rimline::reference::cpu::{self, SceneTable};
use rimline::reference::layout::{CHUNK, DrawArguments};
use rimline_measure::device::Gpu;
use rimline_measure::harness::Test;
use rimline_measure::on_gpu::text;
use rimline_measure::{is_long, must_fail, same};

use crate::random_scene::{Expected, Own, Placed, RandomScene};

pub(crate) const TESTS: &[Test] = &[
    ("casters_of_random_scenes_come_to_what_they_come_to_alone", random_scenes),
    ("forty_lights_are_two_batches", two_batches),
    ("comparators_notice_one_wrong_bit", controls),
    ("lists_of_one_entry_overflow_and_are_counted", overflow),
    ("a_full_list_of_undecided_faces_loses_nothing", undecided_overflow),
    ("pools_grow_in_mid_run", growth),
];

/// What a frame left in its buffers.
pub(crate) struct Found {
    pub(crate) table: Vec<[u32; 4]>,
    pub(crate) lit: Vec<u32>,
    pub(crate) groups: Vec<GroupFound>,
}

pub(crate) struct GroupFound {
    group: usize,
    batch: usize,
    pub(crate) facing: Vec<u32>,
    excluded: Vec<u32>,
    /// For each light of the batch.
    pub(crate) counts: Vec<u32>,
    pub(crate) lists: Vec<Vec<u32>>,
    capacity: u32,
    edge_slots: u32,
    draws: Vec<DrawArguments>,
    statistics: ExtractionStatistics,
}

impl Found {
    pub(crate) fn read(gpu: &Gpu, frame: &SceneFrame) -> Result<Self, String> {
        let results = frame.results().map_err(text)?;
        let mut found = Self {
            table: gpu.read(results.table, usize::MAX)?,
            lit: gpu.read(results.lit, usize::MAX)?,
            groups: Vec::new(),
        };
        for group in &results.groups {
            let words: Vec<u32> = gpu.read(group.lists, usize::MAX)?;
            let (counts, entries) = words.split_at(32);
            let capacity = group.capacity as usize;
            let list = |(light, &count): (usize, &u32)| {
                let mut list: Vec<u32> =
                    entries.iter().skip(light * capacity).take(capacity.min(count as usize)).copied().collect();
                list.sort_by_key(|entry| entry & !cpu::WINDING);
                list
            };
            let record: Vec<u32> = gpu.read(group.record, 4)?;
            found.groups.push(GroupFound {
                group: group.group,
                batch: group.batch,
                facing: gpu.read(group.facing, (CHUNK * group.dispatch.face_chunks) as usize)?,
                excluded: gpu.read(group.excluded, (CHUNK * group.dispatch.face_chunks) as usize)?,
                counts: counts.to_vec(),
                lists: counts.iter().enumerate().map(list).collect(),
                capacity: group.capacity,
                edge_slots: CHUNK * group.dispatch.edge_chunks,
                draws: gpu.read(group.draws, 32)?,
                statistics: *bytemuck::from_bytes(bytemuck::cast_slice(&record)),
            });
        }
        Ok(found)
    }

    fn group(&self, group: usize, batch: usize) -> Result<&GroupFound, String> {
        let found = self.groups.iter().find(|found| (found.group, found.batch) == (group, batch));
        found.ok_or_else(|| format!("no results of group {group}, batch {batch}"))
    }
}

/// Whether the light certainly reaches the caster: a corner of a face is within its range.
fn certainly_reaches(scene: &RandomScene, own: &Own, bit: u32) -> bool {
    let Some((_, light)) = scene.lights.iter().find(|(handle, _)| handle.bit() == bit) else { return false };
    let Placed::Rigid(rows) = &own.placed else { return true };
    if !light.range.is_finite() || light.w == 0.0 {
        return true;
    }
    let ((_, rest, mesh), _) = &scene.meshes[own.mesh];
    let corners = mesh.faces().iter().flatten().map(|&vertex| rest[vertex as usize].map(f64::from));
    let squares = corners.map(|position| {
        let placed = rows.map(|row| {
            let [a, b, c, d] = row.map(f64::from);
            a * position[0] + b * position[1] + c * position[2] + d
        });
        (0..3).map(|axis| (placed[axis] - f64::from(light.xyz[axis]) / f64::from(light.w)).powi(2)).sum::<f64>()
    });
    squares.fold(f64::MAX, f64::min).sqrt() <= f64::from(light.range) * (1.0 - 1e-5)
}

/// What the pairs of a scene came to, for tests that must not be vacuous.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Tally {
    lit: u32,
    out_of_range: u32,
    silhouettes: usize,
    in_planes: u32,
}

/// The lights that matter to a caster, a word for each batch. None that certainly reaches it may be missing.
fn lit_of(
    scene: &RandomScene,
    own: &Own,
    found: &Found,
    index: u32,
    batches: usize,
    tally: &mut Tally,
) -> Result<Vec<u32>, String> {
    let casters = scene.casters.len();
    let lit: Vec<u32> = (0..batches).map(|batch| found.lit[batch * casters + index as usize]).collect();
    for bit in 0..32 * batches as u32 {
        let is_lit = lit[bit as usize / 32] >> (bit % 32) & 1 != 0;
        let is_allowed = scene.own_light(own, bit).is_some();
        if is_lit && !is_allowed {
            return Err(format!("light {bit} is not allowed for caster {index}, and it matters"));
        }
        if is_allowed && !is_lit && certainly_reaches(scene, own, bit) {
            return Err(format!("light {bit} reaches caster {index}, and it does not matter"));
        }
        tally.lit += u32::from(is_lit);
        tally.out_of_range += u32::from(is_allowed && !is_lit);
    }
    Ok(lit)
}

/// Compares one caster's part of the results.
fn check_caster(found: &Found, group: usize, index: u32, lit: &[u32], expected: &Expected) -> Result<usize, String> {
    let caster = SceneTable(&found.table).caster(index);
    let faces = caster.first_face_slot as usize..(caster.first_face_slot + caster.faces) as usize;
    let edges = caster.first_edge_slot..caster.first_edge_slot + caster.edges;
    let mut silhouettes = 0;
    for (batch, &lit) in lit.iter().enumerate().filter(|(_, lit)| **lit != 0) {
        let results = found.group(group, batch)?;
        let what = format!("caster {index}, batch {batch}");
        same(&format!("{what}, facing"), &results.facing[faces.clone()], &expected.facing[batch])?;
        same(&format!("{what}, lights in planes"), &results.excluded[faces.clone()], &expected.excluded[batch])?;
        for bit in 0..32 {
            let own = |entry: &&u32| edges.contains(&(**entry & !cpu::WINDING));
            let list: Vec<u32> = results.lists[bit].iter().filter(own).map(|entry| entry - edges.start).collect();
            let is_lit = lit >> bit & 1 != 0;
            let expected = &expected.lists[32 * batch + bit];
            same(&format!("{what}, list {bit}"), &list, if is_lit { expected } else { &[] })?;
            silhouettes += list.len();
        }
    }
    Ok(silhouettes)
}

/// Compares a whole frame. Returns what it came to.
pub(crate) fn check_frame(scene: &RandomScene, frame: &SceneFrame, found: &Found) -> Result<Tally, String> {
    let mut tally = Tally::default();
    let batches = frame.batches();
    let mut non_finite = 0;
    for own in &scene.casters {
        let (index, group) = frame.place(own.handle).ok_or("the frame lacks a caster")?;
        let lit = if batches == 0 { Vec::new() } else { lit_of(scene, own, found, index, batches, &mut tally)? };
        let expected = scene.alone(own, &lit)?;
        tally.silhouettes += check_caster(found, group, index, &lit, &expected)?;
        tally.in_planes += expected.excluded.iter().flatten().map(|mask| mask.count_ones()).sum::<u32>();
        let ((_, rest, mesh), _) = &scene.meshes[own.mesh];
        let positions = if let Placed::World(world) = &own.placed { world } else { rest };
        let is_finite = |face: &&[u32; 3]| face.iter().all(|&vertex| cpu::is_finite(positions[vertex as usize]));
        if lit.iter().any(|&lit| lit != 0) {
            non_finite += mesh.faces().len() - mesh.faces().iter().filter(is_finite).count();
        }
    }
    let total: usize = found.groups.iter().flat_map(|group| &group.lists).map(Vec::len).sum();
    same("silhouette edges of all casters", &[total], &[tally.silhouettes])?;
    let counted: u32 = found.groups.iter().map(|group| group.statistics.non_finite_faces).sum();
    same("faces that are not finite", &[counted], &[non_finite as u32])?;
    for group in &found.groups {
        let draws: Vec<u32> = group.draws.iter().map(|draw| draw.instance_count).collect();
        same("draws", &draws, &group.counts)?;
    }
    Ok(tally)
}

/// Encodes, submits and compares.
fn check(gpu: &Gpu, scene: &mut RandomScene) -> Result<Tally, String> {
    let frame = gpu.submit(|encoder| scene.encode(encoder))?;
    check_frame(scene, &frame, &Found::read(gpu, &frame)?)
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
    check_frame(&scene, &frame, &found)?;
    let table = found.table.clone();
    // A caster that some light reaches.
    let index = (0..scene.casters.len()).find(|&index| found.lit[index] != 0).ok_or("nothing is lit")?;
    let caster = SceneTable(&table).caster(index as u32);
    let own = scene.casters.iter().find(|own| frame.place(own.handle).is_some_and(|(at, _)| at as usize == index));
    let (_, group) = own.and_then(|own| frame.place(own.handle)).ok_or("no such caster")?;
    let at = found.groups.iter().position(|found| (found.group, found.batch) == (group, 0)).ok_or("no group")?;
    found.groups[at].facing[caster.first_face_slot as usize] ^= 1;
    must_fail("a flipped facing bit", &check_frame(&scene, &frame, &found))?;
    found.groups[at].facing[caster.first_face_slot as usize] ^= 1;
    found.groups[at].excluded[caster.first_face_slot as usize] ^= 1;
    must_fail("a flipped bit of a light in a plane", &check_frame(&scene, &frame, &found))?;
    found.groups[at].excluded[caster.first_face_slot as usize] ^= 1;
    let list = found.groups[at].lists.iter().position(|list| !list.is_empty()).ok_or("no silhouette")?;
    found.groups[at].lists[list][0] ^= cpu::WINDING;
    must_fail("a flipped winding bit", &check_frame(&scene, &frame, &found))?;
    found.groups[at].lists[list][0] ^= cpu::WINDING;
    let entry = found.groups[at].lists[list].pop();
    must_fail("a missing entry", &check_frame(&scene, &frame, &found))?;
    found.groups[at].lists[list].extend(entry);
    found.lit[index] = 0;
    must_fail("a light that reaches and does not matter", &check_frame(&scene, &frame, &found))?;
    found.lit[index] = u32::MAX;
    must_fail("a light that is not there", &check_frame(&scene, &frame, &found))
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
        check_frame(&scene, &frame, &found)?;
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
        let shape = rimline_measure::shapes::torus(40 + 10 * step, 100, 1.0, 0.4);
        let case = rimline_measure::cases::case("torus", shape);
        let handle = scene.scene.add_mesh(&case.2, &case.1).map_err(text)?;
        scene.meshes.push((case, handle));
        for _ in 0..5 {
            scene.insert(gpu)?;
        }
        check(gpu, &mut scene).map_err(|error| format!("step {step}: {error}"))?;
        // All casters of a mesh go, then the mesh; its run is used again later.
        let gone = scene.random.below(scene.meshes.len());
        for own in scene.casters.extract_if(.., |own| own.mesh == gone) {
            scene.scene.remove(own.handle).map_err(text)?;
        }
        let (_, handle) = scene.meshes.swap_remove(gone);
        scene.scene.remove_mesh(handle).map_err(text)?;
        let last = scene.meshes.len();
        scene.casters.iter_mut().filter(|own| own.mesh == last).for_each(|own| own.mesh = gone);
        check(gpu, &mut scene).map_err(|error| format!("step {step}, without a mesh: {error}"))?;
    }
    let frame = gpu.submit(|encoder| scene.encode(encoder))?;
    if frame.groups() < 2 { Err("one page held everything".to_owned()) } else { Ok(()) }
}
