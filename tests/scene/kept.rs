//! Bits and lists that are kept from frame to frame: they are right, and no more is computed than what changed.
//! `relist` keeps lists of views.

use std::collections::HashMap;
use std::sync::Arc;

use rimline::ShadowCamera;
use rimline::gpu::{
    CasterHandle, CasterPositions, FrameInputs, Measuring, SceneFrame, SceneOptions, SceneStatistics, ShadowError,
    ShadowStatistics,
};
use rimline::internals::scene::CHOICE_WORDS;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{text, views};
use rimline_testkit::random::Random;
use rimline_testkit::{must_fail, same, shapes};

use crate::found::{Found, check_frame};
use crate::histories::camera;
use crate::lists::listed;
use crate::random_scene::{Content, Placed, RandomScene};
use crate::scenes::roomy;

pub(crate) const TESTS: &[Test] = &[
    ("bits_are_kept_where_nothing_changed", random_frames),
    ("what_is_taken_and_listed_follows_from_what_is_kept", taken),
    ("a_still_frame_tests_nothing", still),
    ("lists_for_views_are_kept", lists),
    ("buffers_with_a_version_are_kept", versions),
    ("stated_boxes_are_heeded", boxes),
    ("faces_that_callers_exclude_are_not_kept", excluded),
    ("lights_in_planes_of_kept_faces_are_known", zeros),
    ("late_frames_of_another_layout_spoil_nothing", late),
];

/// Version of each caster and light when the GPU last computed it: how often it had changed.
#[derive(Clone, Default)]
struct Memory {
    casters: HashMap<CasterHandle, u64>,
    lights: HashMap<u32, u64>,
    /// The lights that mattered to each caster, by batches.
    lit: HashMap<CasterHandle, Vec<u32>>,
}

/// Compares a frame with the casters alone, and what it kept with `before`. Returns what is right to keep from here on.
fn check(
    content: &Content,
    frame: &SceneFrame,
    found: &Found,
    before: &Memory,
    now: &Memory,
) -> Result<Memory, String> {
    check_frame(content, frame, found)?;
    let mut after = now.clone();
    let batches = frame.batches();
    for own in &content.casters {
        let (index, _) = frame.locate(own.handle).ok_or("the frame lacks a caster")?;
        let at = |batch: usize| batch * content.casters.len() + index as usize;
        let lit: Vec<u32> = (0..batches).map(|batch| found.lit[at(batch)]).collect();
        let is_same = before.casters.get(&own.handle) == now.casters.get(&own.handle) && is_rigid(&own.placed);
        let expected: Vec<u32> = lit
            .iter()
            .enumerate()
            .map(|(batch, lit)| {
                let was_lit = before.lit.get(&own.handle).and_then(|lit| lit.get(batch)).copied().unwrap_or(0);
                let same = |bit: &u32| {
                    let number = 32 * batch as u32 + bit;
                    before.lights.get(&number) == now.lights.get(&number)
                };
                let same_lights = (0..32).filter(same).fold(0_u32, |bits, bit| bits | 1 << bit);
                lit & !(if is_same { was_lit & same_lights } else { 0 })
            })
            .collect();
        let taken: Vec<u32> = (0..batches).map(|batch| found.taken[at(batch)]).collect();
        same(&format!("lights taken for caster {index}"), &taken, &expected)?;
        after.lit.insert(own.handle, lit);
    }
    Ok(after)
}

fn is_rigid(placed: &Placed) -> bool {
    matches!(placed, Placed::Rigid(_))
}

/// Changes that leave the layout as it is. `now` counts them.
fn change(scene: &mut RandomScene, now: &mut Memory, number: u64) -> Result<(), String> {
    match scene.random.below(6) {
        // Nothing.
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

fn filled(gpu: &Gpu, seed: u64, options: SceneOptions) -> Result<RandomScene, String> {
    println!("seed {seed}");
    let mut scene = RandomScene::new(gpu, seed, options)?;
    for _ in 0..[3, 9, 40][scene.random.below(3)] {
        scene.add_light()?;
    }
    for _ in 0..=scene.random.below(14) {
        scene.insert(gpu)?;
    }
    Ok(scene)
}

/// Frames are dropped, swapped, or two in an encoder, and some are laid out anew.
fn random_frames() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let encoder = || gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let (mut pairs, mut kept, mut noticed) = (0, 0, 0);
    for seed in 2501..2541 {
        let mut scene = filled(gpu, seed, roomy(40))?;
        let (mut now, mut memory) = (Memory::default(), Memory::default());
        for number in 1..9 {
            let what = |error: String| format!("frame {number}: {error}");
            match scene.random.below(8) {
                0 => drop(scene.encode(&mut encoder())?),
                1 => {
                    // The frame at hand comes after a later one.
                    let mut first = encoder();
                    let frame = scene.encode(&mut first)?;
                    let (results, content, then) = (frame.results().map_err(text)?, scene.content.clone(), now.clone());
                    change(&mut scene, &mut now, 100 + number)?;
                    let mut second = encoder();
                    let later = scene.encode(&mut second)?;
                    gpu.queue.submit([second.finish()]);
                    let found = Found::read(gpu, &later)?;
                    memory = check(&scene.content, &later, &found, &memory, &now).map_err(what)?;
                    gpu.queue.submit([first.finish()]);
                    memory = check(&content, &frame, &Found::of(gpu, &results)?, &memory, &then).map_err(what)?;
                }
                2 => {
                    // All is laid out anew.
                    scene.insert(gpu)?;
                    memory = Memory::default();
                }
                _ => {}
            }
            let frame = gpu.submit(|encoder| scene.encode(encoder))?;
            let found = Found::read(gpu, &frame)?;
            let last = memory.clone();
            memory = check(&scene.content, &frame, &found, &memory, &now).map_err(what)?;
            pairs += found.statistics.pairs;
            kept += found.statistics.cached_pairs;
            // Negative control: nothing was there before.
            let has_kept = found.statistics.cached_pairs > 0;
            let other = check(&scene.content, &frame, &found, &Memory::default(), &now);
            if has_kept && !last.lit.is_empty() {
                must_fail("pairs that are taken without need", &other.map(drop))?;
                noticed += 1;
            }
            change(&mut scene, &mut now, number)?;
        }
    }
    println!("{kept} of {pairs} pairs kept, {noticed} controls");
    if 4 * kept < pairs || kept == pairs || noticed == 0 { Err("not as meant".to_owned()) } else { Ok(()) }
}

fn taken() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut cached_pairs = 0;
    for seed in 2601..2621 {
        let mut scene = filled(gpu, seed, roomy(40))?;
        let mut kept = Vec::new();
        for _ in 0..5 {
            let frame = gpu.submit(|encoder| scene.encode(encoder))?;
            listed(gpu, &frame, &mut kept)?;
            cached_pairs += Found::read(gpu, &frame)?.statistics.cached_pairs;
            change(&mut scene, &mut Memory::default(), 0)?;
        }
    }
    if cached_pairs == 0 { Err("nothing was kept".to_owned()) } else { Ok(()) }
}

/// A second frame of the same computes nothing, unless bits are not kept; then it is the first again.
fn still() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    for seed in 2701..2711 {
        for keep_bits in [true, false] {
            let mut options = roomy(40);
            options.measuring.set(Measuring::CACHED_BITS, !keep_bits);
            let mut scene = RandomScene::new(gpu, seed, options)?;
            for _ in 0..6 {
                scene.add_light()?;
            }
            for _ in 0..8 {
                scene.insert_rigid()?;
            }
            let mut frames = Vec::new();
            for _ in 0..3 {
                let frame = gpu.submit(|encoder| scene.encode(encoder))?;
                let found = Found::read(gpu, &frame)?;
                check_frame(&scene.content, &frame, &found)?;
                frames.push(found.statistics);
            }
            let all = frames[0];
            let none = SceneStatistics {
                cached_pairs: all.pairs,
                faces: 0,
                edges: 0,
                untested_faces: 0,
                untested_edges: 0,
                ..all
            };
            same("the first frame", &[all.cached_pairs, u32::from(all.faces > 0)], &[0, 1])?;
            let expected = if keep_bits { none } else { all };
            same(&format!("later frames, kept {keep_bits}"), &frames[1..], &[expected; 2])?;
            must_fail(
                "a frame that is computed",
                &same("later", &frames[1..2], &[if keep_bits { all } else { none }]),
            )?;
        }
    }
    Ok(())
}

/// The lists of a frame for its views, and what was chosen for them.
#[derive(Clone, Debug, PartialEq)]
struct Listed {
    /// For each group, batch and view 32 pairs.
    made_from: Vec<[u32; 2]>,
    choices: Vec<u32>,
    /// Sides for each group and batch, all views.
    sides: Vec<Vec<u32>>,
    kept: u32,
}

impl Listed {
    fn read(gpu: &Gpu, frame: &SceneFrame) -> Result<Self, String> {
        let results = frame.results().map_err(text)?;
        let statistics: Vec<ShadowStatistics> = gpu.read(frame.shadow_statistics().ok_or("no view")?, 1)?;
        let sides = results.groups.iter().flat_map(|group| &group.sides).map(|sides| gpu.read(sides, usize::MAX));
        Ok(Self {
            made_from: gpu.read(results.listed.ok_or("no view")?, usize::MAX)?,
            choices: gpu.read(results.choices.ok_or("no view")?, usize::MAX)?,
            sides: sides.collect::<Result<_, _>>()?,
            kept: statistics[0].cached_lists,
        })
    }
}

/// Lists for views: kept where casters, light and camera are as before, by the versions that the frame noted.
fn lists() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut partly = 0;
    for seed in 2751..2761 {
        let mut scene = RandomScene::new(gpu, seed, roomy(40))?;
        let mut random = Random::new(seed);
        for _ in 0..6 {
            scene.add_light()?;
        }
        for _ in 0..8 {
            scene.insert_rigid()?;
        }
        let mut cameras = vec![camera(&mut random), camera(&mut random)];
        let mut last = Vec::new();
        let mut frame = |scene: &mut RandomScene, cameras: &[ShadowCamera]| {
            let frame =
                gpu.submit(|encoder| scene.scene.encode(encoder, FrameInputs::new(&views(cameras))).map_err(text))?;
            let results = frame.results().map_err(text)?;
            let kept: Vec<u32> = gpu.read(results.cache, usize::MAX)?;
            let listed = Listed::read(gpu, &frame)?;
            // The inputs of each list, and the lists that are recomputed, from the words of the frame.
            let (views, mut fresh) = (cameras.len(), 0);
            for (part, group) in results.groups.iter().enumerate() {
                for view in 0..views {
                    let at = 32 * (part * views + view);
                    let made_from = &listed.made_from[at..at + 32];
                    let encodes: Vec<u32> = made_from.iter().map(|pair| pair[0]).collect();
                    same("encodes of lists", &encodes, &kept[group.dispatch.lists_offset as usize..][..32])?;
                    let before: &[[u32; 2]] = last.get(at..at + 32).unwrap_or_default();
                    let is_fresh = |bit: &usize| made_from.get(*bit) != before.get(*bit);
                    let expected = (0..32).filter(is_fresh).fold(0_u32, |mask, bit| mask | 1 << bit);
                    let word = (view * frame.batches() + group.batch) * group.dispatch.casters as usize;
                    let found = listed.choices[CHOICE_WORDS * word + 7];
                    same("lists made anew", &[found], &[expected])?;
                    fresh += (found & 63).count_ones();
                }
            }
            same("lists kept", &[listed.kept], &[(6 * results.groups.len() * views) as u32 - fresh])?;
            last.clone_from(&listed.made_from);
            Ok::<_, String>((listed, fresh))
        };
        let (first, all) = frame(&mut scene, &cameras)?;
        same("first", &[first.kept], &[0])?;
        let (mut second, fresh) = frame(&mut scene, &cameras)?;
        same("still", &[fresh, second.kept], &[0, all])?;
        second.kept = 0;
        let without_mask = |listed: &Listed| {
            let mut listed = listed.clone();
            listed.choices.iter_mut().skip(7).step_by(CHOICE_WORDS).for_each(|word| *word = 0);
            listed
        };
        same("lists of a still frame", &[without_mask(&second)], &[without_mask(&first)])?;
        // A camera moves.
        cameras[1] = camera(&mut random);
        let (third, fresh) = frame(&mut scene, &cameras)?;
        same("one camera", &[fresh, third.kept], &[all / 2, all / 2])?;
        must_fail("old lists", &same("lists", &[without_mask(&third)], &[without_mask(&second)]))?;
        // A light moves.
        let (light, of_light) = scene.content.lights[2];
        scene.scene.set_light(light, of_light.with_range(777.0)).map_err(text)?;
        let (_, fresh) = frame(&mut scene, &cameras)?;
        if fresh > all / 6 {
            return Err(format!("one light of 6 changed, and {fresh} of {all} lists"));
        }
        partly += u32::from(fresh > 0);
        // A value that is set to itself is no change. A caster that moves changes lists of its group.
        let Placed::Rigid(rows) = scene.content.casters[0].placed else { return Err("not rigid".to_owned()) };
        let moved = rows.map(|row| [row[0], row[1], row[2], row[3] + 1.0]);
        for (rows, changes) in [(rows, false), (moved, true), (moved, false)] {
            scene.scene.set_transform(scene.content.casters[0].handle, rows).map_err(text)?;
            scene.scene.set_light(light, of_light.with_range(777.0)).map_err(text)?;
            let (_, fresh) = frame(&mut scene, &cameras)?;
            if fresh > 0 && !changes {
                return Err(format!("nothing changed, and {fresh} lists"));
            }
            partly += u32::from(fresh > 0);
        }
    }
    if partly < 10 { Err(format!("{partly} frames of which a part was made anew")) } else { Ok(()) }
}

/// Positions in a buffer are computed anew, unless their version is the same.
fn versions() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::new(gpu, 2801, roomy(8))?;
    for _ in 0..4 {
        scene.add_light()?;
    }
    let mut random = Random::new(2802);
    let rest = scene.content.meshes[0].0.1.clone();
    let mut moved = || -> Vec<[f32; 3]> {
        let by = random.direction();
        rest.iter().map(|p| [p[0] + 3.0 * by[0], p[1] + 3.0 * by[1], p[2] + 3.0 * by[2]]).collect()
    };
    let mut world = moved();
    let buffer = gpu.storage(&world);
    let positions = CasterPositions::Buffer { buffer: buffer.clone(), offset: 0, stride: 12 };
    let handle = scene.insert_as(0, Placed::World(world.clone()), positions)?;
    let frame = |scene: &mut RandomScene| {
        let frame = gpu.submit(|encoder| scene.encode(encoder))?;
        let found = Found::read(gpu, &frame)?;
        check_frame(&scene.content, &frame, &found).map(|_| found.statistics.cached_pairs == found.statistics.pairs)
    };
    let write = |scene: &mut RandomScene, world: &[[f32; 3]]| {
        gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(world));
        scene.content.casters[0].placed = Placed::World(world.to_vec());
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
    for (step, (writes, version, keeps)) in steps.into_iter().enumerate() {
        if writes {
            world = moved();
            write(&mut scene, &world);
        }
        scene.scene.set_position_version(handle, version).map_err(text)?;
        same(&format!("step {step}, all kept"), &[frame(&mut scene)?], &[keeps])?;
    }
    // Negative control: a version that is not true leaves old bits.
    scene.scene.set_position_version(handle, Some(9)).map_err(text)?;
    frame(&mut scene)?;
    write(&mut scene, &rest.iter().map(|p| [-p[2] - 9.0, p[0], 2.0 * p[1]]).collect::<Vec<_>>());
    must_fail("old bits", &frame(&mut scene).map(drop))?;
    scene.insert_rigid()?;
    let rigid = scene.content.casters[1].handle;
    let refused = scene.scene.set_position_version(rigid, Some(1));
    same("a version for a rigid caster", &[refused], &[Err(ShadowError::NoBuffer)])
}

/// A stated box is heeded, whether it is true or not, and only finite boxes are taken.
fn boxes() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::new(gpu, 2951, roomy(8))?;
    let light = rimline::Light::point([0.0, 0.0, 0.0]).with_range(2.0);
    let handle = scene.scene.add_light(light).map_err(text)?;
    scene.content.lights.push((handle, light));
    let world = scene.content.meshes[0].0.1.clone();
    let buffer = gpu.storage(&world);
    let positions = CasterPositions::Buffer { buffer, offset: 0, stride: 12 };
    let caster = scene.insert_as(0, Placed::World(world), positions)?;
    scene.set_all_lights()?;
    let mut pairs = |bounds| {
        scene.scene.set_bounds(caster, bounds).map_err(text)?;
        let frame = gpu.submit(|encoder| scene.encode(encoder))?;
        Ok::<_, String>(Found::read(gpu, &frame)?.statistics.pairs)
    };
    let (near, far) = ([[1.0, 0.0, 0.0], [3.0, 1.0, 1.0]], [[2.5, 0.0, 0.0], [3.0, 1.0, 1.0]]);
    let found = [pairs(None)?, pairs(Some(near))?, pairs(Some(far))?, pairs(Some(near))?, pairs(None)?];
    same("pairs", &found, &[1, 1, 0, 1, 1])?;
    for [low, high] in [[[0.0; 3], [-1.0, 1.0, 1.0]], [[0.0; 3], [1.0, f32::INFINITY, 1.0]], [[f32::NAN; 3], [1.0; 3]]]
    {
        let refused = scene.scene.set_bounds(caster, Some([low, high]));
        if !matches!(refused, Err(ShadowError::Bounds { .. })) {
            return Err(format!("{low:?} {high:?}: {refused:?}"));
        }
    }
    scene.insert_rigid()?;
    let rigid = scene.content.casters[1].handle;
    same("a rigid caster", &[scene.scene.set_bounds(rigid, None)], &[Err(ShadowError::NoBuffer)])
}

/// Masks of callers are copied for each frame, and nothing of their group is kept.
fn excluded() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::new(gpu, 2901, roomy(8))?;
    for _ in 0..4 {
        scene.add_light()?;
    }
    for _ in 0..5 {
        scene.insert_rigid()?;
    }
    let (caster, light) = (scene.content.casters[2].handle, scene.content.lights[1].0);
    let frame = |scene: &mut RandomScene| {
        let frame = gpu.submit(|encoder| scene.encode(encoder))?;
        Found::read(gpu, &frame)
    };
    frame(&mut scene)?;
    scene.scene.set_excluded(caster, light, &[0]).map_err(text)?;
    let first = frame(&mut scene)?;
    let second = frame(&mut scene)?;
    same("pairs kept", &[second.statistics.cached_pairs], &[0])?;
    let masks = |found: &Found| found.groups.iter().flat_map(|group| group.excluded.clone()).collect::<Vec<_>>();
    same("masks", &masks(&second), &masks(&first))?;
    scene.scene.set_excluded(caster, light, &[]).map_err(text)?;
    let frame = gpu.submit(|encoder| scene.encode(encoder))?;
    check_frame(&scene.content, &frame, &Found::read(gpu, &frame)?)?;
    let frame = gpu.submit(|encoder| scene.encode(encoder))?;
    let found = Found::read(gpu, &frame)?;
    check_frame(&scene.content, &frame, &found)?;
    same("pairs kept again", &[found.statistics.cached_pairs], &[found.statistics.pairs])
}

/// The counts of lists tell that a light was in the plane of a face, until nothing is left of that.
fn zeros() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::new(gpu, 3001, roomy(8))?;
    let cube = scene.content.meshes.iter().position(|(case, _)| case.0 == "cube");
    let mesh = cube.unwrap_or(0);
    let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    scene.insert_as(mesh, Placed::Rigid(rows), CasterPositions::Rigid(rows.into()))?;
    // A corner of a face lies in its plane.
    let (_, corner, shape) = &*scene.content.meshes[mesh].0.clone();
    let at = corner[shape.faces()[0][0] as usize];
    let light = rimline::Light::point(at);
    let handle = scene.scene.add_light(light).map_err(text)?;
    scene.content.lights.push((handle, light));
    scene.set_all_lights()?;
    let flag = |scene: &mut RandomScene| {
        let frame = gpu.submit(|encoder| scene.encode(encoder))?;
        let results = frame.results().map_err(text)?;
        let group = results.groups.first().ok_or("no group")?;
        let counts: Vec<u32> = gpu.read(group.lists, 64)?;
        let record: Vec<u32> = gpu.read(group.record, 4)?;
        Ok::<_, String>([u32::from(record[3] != 0), u32::from(counts[32] != 0)])
    };
    same("computed, and kept", &[flag(&mut scene)?, flag(&mut scene)?, flag(&mut scene)?], &[[1, 0], [0, 1], [0, 1]])?;
    let away = rimline::Light::point([at[0] + 7.3, at[1] + 5.1, at[2] + 9.7]);
    scene.scene.set_light(handle, away).map_err(text)?;
    same("moved away", &[flag(&mut scene)?, flag(&mut scene)?], &[[0, 0], [0, 0]])
}

/// The late frame has larger masks and fewer casters: what describes its bits does not fit the new layout, though its masks
/// would.
fn late() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::new(gpu, 3101, roomy(8))?;
    for _ in 0..4 {
        scene.add_light()?;
    }
    let shape = shapes::torus(60, 40, 1.0, 0.4);
    let mesh = shape.mesh().map_err(text)?;
    let handle = scene.scene.add_mesh(&mesh, &shape.positions).map_err(text)?;
    scene.content.meshes.push((Arc::new(("large".to_owned(), shape.positions, mesh)), handle));
    scene.insert_rigid_of(scene.content.meshes.len() - 1)?;
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    scene.encode(&mut encoder)?;
    let own = scene.content.casters.swap_remove(0);
    scene.scene.remove(own.handle).map_err(text)?;
    let faces = |mesh: &usize| scene.content.meshes[*mesh].0.2.faces().len();
    let small = (0..scene.content.meshes.len()).min_by_key(faces).ok_or("no mesh")?;
    for _ in 0..30 {
        scene.insert_rigid_of(small)?;
    }
    scene.set_all_lights()?;
    let check = |scene: &mut RandomScene| {
        let frame = gpu.submit(|encoder| scene.encode(encoder))?;
        let found = Found::read(gpu, &frame)?;
        check_frame(&scene.content, &frame, &found).map(|_| found.statistics)
    };
    let first = check(&mut scene)?;
    gpu.queue.submit([encoder.finish()]);
    let second = check(&mut scene)?;
    same("pairs", &[second.pairs, u32::from(first.pairs > 0)], &[first.pairs, 1])
}
