//! Cached bits and lists: they are right, and only what changed is computed. `cull_lights` finds the active lights,
//! `relist` the dirty lists of views.

use std::collections::HashMap;

use rimline::gpu::{
    CasterHandle, CasterPositions, FrameInputs, Measuring, SceneFrame, SceneStatistics, ShadowError, ShadowStatistics,
};
use rimline::internals::scene::CHOICE_WORDS;
use rimline::{Light, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{text, views};
use rimline_testkit::random::Random;
use rimline_testkit::{must_fail, same, shapes};

use crate::found::{Found, Tally, check_frame, checked, read_frame};
use crate::histories::camera;
use crate::random_scene::{Content, IDENTITY, Placed, RandomScene, encoder};
use crate::scenes::roomy;

pub(crate) const TESTS: &[Test] = &[
    ("bits_are_cached_where_nothing_changed", random_frames),
    ("a_still_frame_tests_nothing", still),
    ("lists_of_views_are_cached", lists),
    ("buffers_with_a_version_are_cached", versions),
    ("stated_boxes_are_heeded", boxes),
    ("faces_that_callers_exclude_are_not_cached", excluded),
    ("lights_in_planes_of_cached_faces_are_known", zeros),
    ("late_frames_of_another_layout_spoil_nothing", late),
];

/// The versions of casters and lights that the bits on the GPU were computed from: how often each had changed.
#[derive(Clone, Default)]
struct Memory {
    casters: HashMap<CasterHandle, u64>,
    lights: HashMap<u32, u64>,
    /// The relevant lights of each caster, by batches.
    relevant: HashMap<CasterHandle, Vec<u32>>,
}

/// Compares a frame with the casters alone, and its active lights with `before`, unless this is unknown. Returns the memory
/// after the frame.
fn check(
    content: &Content,
    frame: &SceneFrame,
    found: &Found,
    before: Option<&Memory>,
    (now, tally): (&Memory, &mut Tally),
) -> Result<Memory, String> {
    tally.add(&check_frame(content, frame, found)?);
    let mut after = now.clone();
    for caster in &content.casters {
        let (index, _) = frame.locate(caster.handle).ok_or("the frame lacks a caster")?;
        let words = |all: &[u32]| -> Vec<u32> {
            (0..frame.batches()).map(|batch| all[batch * content.casters.len() + index as usize]).collect()
        };
        let relevant = words(&found.relevant);
        if let Some(before) = before {
            let is_same =
                before.casters.get(&caster.handle) == now.casters.get(&caster.handle) && is_rigid(&caster.placed);
            let old = before.relevant.get(&caster.handle).filter(|_| is_same);
            let is_cached = |bit: u32| {
                let was_relevant =
                    old.and_then(|old| old.get(bit as usize / 32)).is_some_and(|old| old >> (bit % 32) & 1 != 0);
                was_relevant && before.lights.get(&bit) == now.lights.get(&bit)
            };
            let expected = relevant.iter().zip(0..).map(|(relevant, batch)| {
                (0..32).filter(|bit| is_cached(32 * batch + bit)).fold(*relevant, |active, bit| active & !(1 << bit))
            });
            let expected: Vec<u32> = expected.collect();
            same(&format!("active lights of caster {index}"), &words(&found.active), &expected)?;
        }
        after.relevant.insert(caster.handle, relevant);
    }
    Ok(after)
}

fn is_rigid(placed: &Placed) -> bool {
    matches!(placed, Placed::Rigid(_))
}

/// Changes that need no new layout. `now` counts them.
fn change(scene: &mut RandomScene, now: &mut Memory, number: u64) -> Result<(), String> {
    match scene.random.below(6) {
        0 => {}
        1 | 2 => {
            for (handle, light) in scene.move_lights()? {
                println!("light {} to {light:?}", handle.bit());
                now.lights.insert(handle.bit(), number);
            }
        }
        _ => {
            for handle in scene.move_casters()? {
                now.casters.insert(handle, number);
            }
        }
    }
    Ok(())
}

/// A scene with one or two batches of lights.
fn filled(gpu: &Gpu, seed: u64) -> Result<RandomScene, String> {
    let mut random = Random::new(seed);
    RandomScene::filled(gpu, seed, roomy(40), [[3, 9, 40][random.below(3)], 1 + random.below(14)])
}

/// Results of each caster are those of the caster alone. Frames are dropped, or submitted after a later one, of the same
/// layout or of another. Half of the scenes have a mesh of many clusters.
fn random_frames() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut pairs, mut cached, mut noticed, mut sum) = (0, 0, 0, Tally::default());
    for seed in 2501..2551 {
        let mut scene = filled(gpu, seed)?;
        if seed % 2 == 0 {
            let mesh = scene.add_mesh("blob", shapes::blob(12, 0.3, seed as u32))?;
            scene.insert_at(mesh, IDENTITY)?;
        }
        // `None`: frames of two layouts wrote the buffers, which the layouts may share or not.
        let (mut now, mut memory) = (Memory::default(), Some(Memory::default()));
        for number in 1..9 {
            let what = |error: String| format!("frame {number}: {error}");
            match scene.random.below(8) {
                0 => drop(scene.encode(&mut encoder(gpu))?),
                event @ (1 | 2) => {
                    let mut first = encoder(gpu);
                    let frame = scene.encode(&mut first)?;
                    let (results, content, then) = (frame.results().map_err(text)?, scene.content.clone(), now.clone());
                    let is_same_layout = event == 1;
                    if is_same_layout {
                        change(&mut scene, &mut now, 100 + number)?;
                    } else {
                        scene.change(gpu)?;
                        scene.insert(gpu)?;
                        memory = None;
                    }
                    let mut second = encoder(gpu);
                    let later = scene.encode(&mut second)?;
                    gpu.queue.submit([second.finish()]);
                    let found = Found::read(gpu, &later)?;
                    let after =
                        check(&scene.content, &later, &found, memory.as_ref(), (&now, &mut sum)).map_err(what)?;
                    gpu.queue.submit([first.finish()]);
                    let found = Found::of(gpu, &results)?;
                    let before = Some(&after).filter(|_| is_same_layout);
                    memory = Some(check(&content, &frame, &found, before, (&then, &mut sum)).map_err(what)?)
                        .filter(|_| is_same_layout);
                    same("a stale frame", &[frame.results().err()], &[Some(ShadowError::StaleFrame)])?;
                }
                3 => {
                    scene.change(gpu)?;
                    drop(scene.encode(&mut encoder(gpu))?);
                    scene.insert(gpu)?;
                    memory = Some(Memory::default());
                }
                _ => {}
            }
            let (frame, found) = read_frame(gpu, &mut scene)?;
            let last = memory.take();
            memory = Some(check(&scene.content, &frame, &found, last.as_ref(), (&now, &mut sum)).map_err(what)?);
            pairs += found.statistics.pairs;
            cached += found.statistics.cached_pairs;
            if found.statistics.cached_pairs > 0 && last.is_some_and(|last| !last.relevant.is_empty()) {
                let other =
                    check(&scene.content, &frame, &found, Some(&Memory::default()), (&now, &mut Tally::default()));
                must_fail("pairs that should be active", &other.map(drop))?;
                noticed += 1;
            }
            change(&mut scene, &mut now, number)?;
        }
    }
    println!("{cached} of {pairs} pairs cached, {noticed} controls; {sum:?}");
    let [by_range, by_cone] = sum.certain;
    let counts = [noticed, sum.relevant, sum.cached, sum.culled, sum.silhouettes as u32, sum.in_planes];
    let is_vacuous = counts.contains(&0) || by_range < 100 || by_cone < 500;
    if 5 * cached < pairs || cached == pairs || is_vacuous { Err("too few of a kind".to_owned()) } else { Ok(()) }
}

/// A second frame of the same content computes nothing. Without caching it computes what the first did.
fn still() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for (seed, caches) in (2701..2709).flat_map(|seed| [(seed, true), (seed, false)]) {
        let mut options = roomy(40);
        options.measuring.set(Measuring::CACHED_BITS, !caches);
        let mut scene = RandomScene::filled_rigid(gpu, seed, options, [6, 8])?;
        let [first, second, third] = [(); 3].map(|()| checked(gpu, &mut scene).map(|checked| checked.found.statistics));
        let (all, later) = (first?, [second?, third?]);
        let (faces, edges, untested_faces, untested_edges) = (0, 0, 0, 0);
        let none = SceneStatistics { cached_pairs: all.pairs, faces, edges, untested_faces, untested_edges, ..all };
        same("the first frame", &[all.cached_pairs, u32::from(all.faces > 0)], &[0, 1])?;
        let [expected, other] = if caches { [none, all] } else { [all, none] };
        same(&format!("later frames, cached {caches}"), &later, &[expected; 2])?;
        must_fail("a frame that is computed", &same("later", &later, &[other; 2]))?;
    }
    Ok(())
}

/// The lists of a frame for its views, and the choices for them.
#[derive(Clone, Debug, PartialEq)]
struct ViewLists {
    /// The versions of lists: for each group, batch and view 32 pairs.
    versions: Vec<[u32; 2]>,
    choices: Vec<u32>,
    /// Sides for each group and batch, all views.
    sides: Vec<Vec<u32>>,
    cached: u32,
}

impl ViewLists {
    fn read(gpu: &Gpu, frame: &SceneFrame) -> Result<Self, String> {
        let results = frame.results().map_err(text)?;
        let statistics: Vec<ShadowStatistics> = gpu.read(frame.shadow_statistics().ok_or("no view")?, 1)?;
        let sides = results.groups.iter().flat_map(|group| &group.sides).map(|sides| gpu.read(sides, usize::MAX));
        Ok(Self {
            versions: gpu.read(results.listed.ok_or("no view")?, usize::MAX)?,
            choices: gpu.read(results.choices.ok_or("no view")?, usize::MAX)?,
            sides: sides.collect::<Result<_, _>>()?,
            cached: statistics[0].cached_lists,
        })
    }
}

/// Lists of views are cached if casters, light and camera are as before, by the versions that the frame wrote.
fn lists() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut partly = 0;
    for seed in 2751..2761 {
        let mut scene = RandomScene::filled_rigid(gpu, seed, roomy(40), [6, 8])?;
        let mut random = Random::new(seed);
        let mut cameras = vec![camera(&mut random), camera(&mut random)];
        let mut last = Vec::new();
        let mut frame = |scene: &mut RandomScene, cameras: &[ShadowCamera]| {
            let frame =
                gpu.submit(|encoder| scene.scene.encode(encoder, FrameInputs::new(&views(cameras))).map_err(text))?;
            let results = frame.results().map_err(text)?;
            let cache: Vec<u32> = gpu.read(results.cache, usize::MAX)?;
            let listed = ViewLists::read(gpu, &frame)?;
            // The lists that are dirty, from the words of the frame.
            let (views, mut dirty) = (cameras.len(), 0);
            for (part, group) in results.groups.iter().enumerate() {
                for view in 0..views {
                    let first = 32 * (part * views + view);
                    let versions = &listed.versions[first..first + 32];
                    let encodes: Vec<u32> = versions.iter().map(|pair| pair[0]).collect();
                    same("encodes of lists", &encodes, &cache[group.dispatch.lists_offset as usize..][..32])?;
                    let before: &[[u32; 2]] = last.get(first..first + 32).unwrap_or_default();
                    let is_dirty = |bit: &usize| versions.get(*bit) != before.get(*bit);
                    let expected = (0..32).filter(is_dirty).fold(0_u32, |mask, bit| mask | 1 << bit);
                    let word = (view * frame.batches() + group.batch) * group.dispatch.casters as usize;
                    let found = listed.choices[CHOICE_WORDS * word + 7];
                    same("dirty lists", &[found], &[expected])?;
                    dirty += (found & 63).count_ones();
                }
            }
            same("cached lists", &[listed.cached], &[(6 * results.groups.len() * views) as u32 - dirty])?;
            last.clone_from(&listed.versions);
            Ok::<_, String>((listed, dirty))
        };
        let (first, all) = frame(&mut scene, &cameras)?;
        same("first", &[first.cached], &[0])?;
        let (mut second, dirty) = frame(&mut scene, &cameras)?;
        same("still", &[dirty, second.cached], &[0, all])?;
        second.cached = 0;
        let without_mask = |listed: &ViewLists| {
            let mut listed = listed.clone();
            listed.choices.iter_mut().skip(7).step_by(CHOICE_WORDS).for_each(|word| *word = 0);
            listed
        };
        same("lists of a still frame", &[without_mask(&second)], &[without_mask(&first)])?;
        // A camera moves.
        cameras[1] = camera(&mut random);
        let (third, dirty) = frame(&mut scene, &cameras)?;
        same("one camera", &[dirty, third.cached], &[all / 2, all / 2])?;
        must_fail("old lists", &same("lists", &[without_mask(&third)], &[without_mask(&second)]))?;
        // A light moves.
        let light = scene.content.lights[2].1.with_range(777.0);
        scene.set_light(2, light)?;
        let (_, dirty) = frame(&mut scene, &cameras)?;
        if dirty > all / 6 {
            return Err(format!("one light of 6 changed, and {dirty} of {all} lists"));
        }
        partly += u32::from(dirty > 0);
        // Setting an equal value changes nothing. A moved caster changes lists of its group.
        let Placed::Rigid(rows) = scene.content.casters[0].placed else { return Err("not rigid".to_owned()) };
        let moved = rows.map(|row| [row[0], row[1], row[2], row[3] + 1.0]);
        for (rows, changes) in [(rows, false), (moved, true), (moved, false)] {
            scene.scene.set_transform(scene.content.casters[0].handle, rows).map_err(text)?;
            scene.set_light(2, light)?;
            let (_, dirty) = frame(&mut scene, &cameras)?;
            if dirty > 0 && !changes {
                return Err(format!("nothing changed, and {dirty} lists"));
            }
            partly += u32::from(dirty > 0);
        }
    }
    if partly < 10 { Err(format!("{partly} frames with some dirty lists")) } else { Ok(()) }
}

/// Each encode computes positions in a buffer, unless their version is the same.
fn versions() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::filled(gpu, 2801, roomy(8), [4, 0])?;
    let mut random = Random::new(2802);
    let rest = scene.content.meshes[0].0.1.clone();
    let mut moved = || -> Vec<[f32; 3]> {
        let by = random.direction();
        rest.iter().map(|p| [p[0] + 3.0 * by[0], p[1] + 3.0 * by[1], p[2] + 3.0 * by[2]]).collect()
    };
    let world = moved();
    let buffer = gpu.storage(&world);
    let positions = CasterPositions::Buffer { buffer: buffer.clone(), offset: 0, stride: 12 };
    let handle = scene.insert_as(0, Placed::World(world), positions)?;
    let frame = |scene: &mut RandomScene| {
        let statistics = checked(gpu, scene)?.found.statistics;
        Ok::<_, String>(statistics.cached_pairs == statistics.pairs)
    };
    let write = |scene: &mut RandomScene, world: Vec<[f32; 3]>| {
        gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(&world));
        scene.content.casters[0].placed = Placed::World(world);
    };
    // Whether the buffer is written, its version, and whether the frame uses all cached results.
    let steps: [(bool, Option<u64>, bool); 9] = [
        (false, None, false),
        (true, None, false),
        (false, Some(7), false),
        (false, Some(7), true),
        (true, Some(8), false),
        (false, Some(8), true),
        (true, Some(7), false),
        (true, None, false),
        (false, None, false),
    ];
    for (step, (writes, version, is_cached)) in steps.into_iter().enumerate() {
        if writes {
            write(&mut scene, moved());
        }
        scene.scene.set_position_version(handle, version).map_err(text)?;
        same(&format!("step {step}, all cached"), &[frame(&mut scene)?], &[is_cached])?;
    }
    // Negative control: a wrong version leaves old bits.
    scene.scene.set_position_version(handle, Some(9)).map_err(text)?;
    frame(&mut scene)?;
    write(&mut scene, rest.iter().map(|p| [-p[2] - 9.0, p[0], 2.0 * p[1]]).collect());
    must_fail("old bits", &frame(&mut scene).map(drop))?;
    scene.insert_rigid()?;
    let rigid = scene.content.casters[1].handle;
    let refused = scene.scene.set_position_version(rigid, Some(1));
    same("a version for a rigid caster", &[refused], &[Err(ShadowError::NoBuffer)])
}

/// A stated box culls, even if it is wrong. Only finite boxes are accepted.
fn boxes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::filled(gpu, 2951, roomy(8), [0, 0])?;
    scene.put_light(Light::point([0.0, 0.0, 0.0]).with_range(2.0))?;
    let world = scene.content.meshes[0].0.1.clone();
    let positions = CasterPositions::Buffer { buffer: gpu.storage(&world), offset: 0, stride: 12 };
    let caster = scene.insert_as(0, Placed::World(world), positions)?;
    scene.set_all_lights()?;
    let mut pairs = |bounds| {
        scene.scene.set_bounds(caster, bounds).map_err(text)?;
        read_frame(gpu, &mut scene).map(|(_, found)| found.statistics.pairs)
    };
    let (near, far) = ([[1.0, 0.0, 0.0], [3.0, 1.0, 1.0]], [[2.5, 0.0, 0.0], [3.0, 1.0, 1.0]]);
    let found = [pairs(None)?, pairs(Some(near))?, pairs(Some(far))?, pairs(Some(near))?, pairs(None)?];
    same("pairs", &found, &[1, 1, 0, 1, 1])?;
    for bounds in [[[0.0; 3], [-1.0, 1.0, 1.0]], [[0.0; 3], [1.0, f32::INFINITY, 1.0]], [[f32::NAN; 3], [1.0; 3]]] {
        let refused = scene.scene.set_bounds(caster, Some(bounds));
        if !matches!(refused, Err(ShadowError::Bounds { .. })) {
            return Err(format!("{bounds:?}: {refused:?}"));
        }
    }
    scene.insert_rigid()?;
    let rigid = scene.content.casters[1].handle;
    same("a rigid caster", &[scene.scene.set_bounds(rigid, None)], &[Err(ShadowError::NoBuffer)])
}

/// Masks of callers are copied for each frame, and nothing of their group is cached.
fn excluded() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::filled_rigid(gpu, 2901, roomy(8), [4, 5])?;
    let (caster, light) = (scene.content.casters[2].handle, scene.content.lights[1].0);
    let frame = |scene: &mut RandomScene| read_frame(gpu, scene).map(|(_, found)| found);
    frame(&mut scene)?;
    scene.scene.set_excluded(caster, light, &[0]).map_err(text)?;
    let [first, second] = [frame(&mut scene)?, frame(&mut scene)?];
    same("cached pairs", &[second.statistics.cached_pairs], &[0])?;
    let masks = |found: &Found| found.groups.iter().flat_map(|group| group.excluded.clone()).collect::<Vec<_>>();
    same("masks", &masks(&second), &masks(&first))?;
    scene.scene.set_excluded(caster, light, &[]).map_err(text)?;
    checked(gpu, &mut scene)?;
    let statistics = checked(gpu, &mut scene)?.found.statistics;
    same("pairs cached again", &[statistics.cached_pairs], &[statistics.pairs])
}

/// The counts of lists tell that a light is in the plane of a face with cached bits.
fn zeros() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::filled(gpu, 3001, roomy(8), [0, 0])?;
    let mesh = scene.content.meshes.iter().position(|(case, _)| case.0 == "cube").unwrap_or(0);
    scene.insert_at(mesh, IDENTITY)?;
    // A corner of a face lies in its plane.
    let (_, positions, shape) = &*scene.content.meshes[mesh].0.clone();
    let corner = positions[shape.faces()[0][0] as usize];
    scene.put_light(Light::point(corner))?;
    scene.set_all_lights()?;
    let flag = |scene: &mut RandomScene| {
        let frame = gpu.submit(|encoder| scene.encode(encoder))?;
        let results = frame.results().map_err(text)?;
        let group = results.groups.first().ok_or("no group")?;
        let counts: Vec<u32> = gpu.read(group.lists, 64)?;
        let record: Vec<u32> = gpu.read(group.record, 4)?;
        Ok::<_, String>([u32::from(record[3] != 0), u32::from(counts[32] != 0)])
    };
    same(
        "computed, and cached",
        &[flag(&mut scene)?, flag(&mut scene)?, flag(&mut scene)?],
        &[[1, 0], [0, 1], [0, 1]],
    )?;
    scene.set_light(0, Light::point([corner[0] + 7.3, corner[1] + 5.1, corner[2] + 9.7]))?;
    same("moved away", &[flag(&mut scene)?, flag(&mut scene)?], &[[0, 0], [0, 0]])
}

/// The late frame has larger masks and fewer casters: the words about its bits do not fit the new layout, but its masks
/// would.
fn late() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::filled(gpu, 3101, roomy(8), [4, 0])?;
    let large = scene.add_mesh("large", shapes::torus(60, 40, 1.0, 0.4))?;
    scene.insert_rigid_of(large)?;
    let mut late = encoder(gpu);
    scene.encode(&mut late)?;
    scene.remove_caster(0)?;
    let faces = |mesh: &usize| scene.content.meshes[*mesh].0.2.faces().len();
    let small = (0..scene.content.meshes.len()).min_by_key(faces).ok_or("no mesh")?;
    (0..30).try_for_each(|_| scene.insert_rigid_of(small))?;
    scene.set_all_lights()?;
    let first = checked(gpu, &mut scene)?.found.statistics;
    gpu.queue.submit([late.finish()]);
    let second = checked(gpu, &mut scene)?.found.statistics;
    same("pairs", &[second.pairs, u32::from(first.pairs > 0)], &[first.pairs, 1])
}
