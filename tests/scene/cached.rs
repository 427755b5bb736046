//! Cached bits and lists: they are right, and only what changed is computed. `cull_lights` finds the active lights,
//! `relist` the dirty lists of views.

use rimline::gpu::{
    Capacities, CasterPositions, FrameInputs, Measuring, SceneOptions, SceneStatistics, ShadowError, ShadowStatistics,
};
use rimline::{Light, ShadowCamera};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::{text, views};
use rimline_testkit::random::Random;
use rimline_testkit::refusals::{is, refusal, refused, shows};
use rimline_testkit::{IDENTITY, must_fail, same, shapes};

use crate::found::{Found, Tally, check_frame, checked, read_frame};
use crate::histories::camera;
use crate::random_scene::{Placed, RandomScene, encoder};
use crate::scenes::roomy;

pub(crate) const TESTS: &[Test] = &[
    ("results_of_casters_are_those_of_each_alone", random_frames),
    ("only_what_changed_is_computed", lists),
    ("buffers_with_a_version_are_cached", versions),
    ("stated_boxes_are_heeded", boxes),
    ("faces_that_callers_exclude_are_not_cached", excluded),
    ("lights_in_planes_of_cached_faces_are_known", zeros),
    ("late_frames_of_another_layout_spoil_nothing", late),
];

/// Scenes change, some frames are dropped, and lists of undecided faces have no room in some. Half have a mesh of many
/// clusters, and casters that are not turned, with lights in planes of their faces.
fn random_frames() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut pairs, mut cached, mut undecided, mut sum) = (0, 0, 0, Tally::default());
    for seed in 2501..2551 {
        let mut random = Random::new(seed);
        // One or two batches of lights.
        let counts = [[3, 9, 40][random.below(3)], 1 + random.below(14)];
        let room = (seed % 3 == 0).then_some(1);
        let options = SceneOptions { capacities: Capacities { undecided: room, ..roomy(40).capacities }, ..roomy(40) };
        let mut scene = RandomScene::filled(gpu, seed, options, counts)?;
        if seed % 2 == 0 {
            scene.add_mesh("blob", shapes::blob(12, 0.3, seed as u32))?;
            (0..scene.content.meshes.len()).try_for_each(|mesh| scene.insert_at(mesh, IDENTITY).map(drop))?;
        }
        for number in 0..8 {
            let (frame, found) = read_frame(gpu, &mut scene)?;
            sum.add(&check_frame(&scene.content, &frame, &found).map_err(|error| format!("frame {number}: {error}"))?);
            pairs += found.statistics.pairs;
            cached += found.statistics.cached_pairs;
            let of_groups = found.groups.iter().map(|group| group.statistics.undecided_pairs);
            undecided += room.map_or(0, |_| of_groups.sum::<u32>());
            match scene.random.below(6) {
                0 => {}
                1 => drop(scene.move_lights()?),
                2 | 3 => drop(scene.move_casters()?),
                _ => scene.change(gpu)?,
            }
            if scene.random.below(4) == 0 {
                scene.encode(&mut encoder(gpu))?;
                drop(scene.move_casters()?);
            }
        }
    }
    println!("{cached} of {pairs} pairs cached, {undecided} undecided without room; {sum:?}");
    let [by_range, by_cone] = sum.certain;
    let counts = [sum.relevant, sum.cached, sum.culled, sum.silhouettes as u32, sum.in_planes];
    let is_vacuous = counts.contains(&0) || by_range < 100 || by_cone < 500 || undecided < 1000;
    if is_vacuous || cached < pairs / 8 { Err("too few of a kind".to_owned()) } else { Ok(()) }
}

/// A still frame computes nothing. After a change only the pairs of the caster or light are computed, and lists of views
/// are made anew if casters, light or camera changed. `histories.rs` tells whether they are right.
fn lists() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut partly = 0;
    for seed in 2751..2761 {
        let mut scene = RandomScene::filled_rigid(gpu, seed, roomy(40), [6, 8])?;
        let mut random = Random::new(seed);
        let mut cameras = vec![camera(&mut random), camera(&mut random)];
        // The lists of views, how many are cached, the counts of bits, and the active pairs of caster and light.
        let frame = |scene: &mut RandomScene, cameras: &[ShadowCamera]| {
            let frame =
                gpu.submit(|encoder| scene.scene.encode(encoder, FrameInputs::new(&views(cameras))).map_err(text))?;
            let found = Found::read(gpu, &frame)?;
            let of_views = gpu.read::<ShadowStatistics>(frame.shadow_statistics().ok_or("no view")?, 1)?[0];
            let mut active = Vec::new();
            for caster in &scene.content.casters {
                let (index, _) = frame.locate(caster.handle).ok_or("no caster")?;
                active.push(found.active[index as usize]);
            }
            let all = 6 * frame.results().map_err(text)?.groups.len() * cameras.len();
            Ok::<_, String>((all as u32, of_views.cached_lists, found.statistics, active))
        };
        let (all, cached, first, active) = frame(&mut scene, &cameras)?;
        same("first", &[cached, first.cached_pairs, u32::from(first.faces > 0)], &[0, 0, 1])?;
        let (faces, edges, untested_faces, untested_edges) = (0, 0, 0, 0);
        let none = SceneStatistics { cached_pairs: first.pairs, faces, edges, untested_faces, untested_edges, ..first };
        let no_pair = vec![0; active.len()];
        same("still", &[frame(&mut scene, &cameras)?], &[(all, all, none, no_pair.clone())])?;
        must_fail("a frame that is computed", &same("pairs", &active, &no_pair))?;
        cameras[1] = camera(&mut random);
        same("one camera", &[frame(&mut scene, &cameras)?], &[(all, all / 2, none, no_pair)])?;
        let (light_bit, light) = (scene.content.lights[2].0.bit(), scene.content.lights[2].1.with_range(777.0));
        let Placed::Rigid(rows) = scene.content.casters[0].placed else { return Err("not rigid".to_owned()) };
        let moved = rows.map(|row| [row[0], row[1], row[2], row[3] + 1.0]);
        // The light moves, then nothing; the caster moves, then nothing. Setting an equal value changes nothing.
        for (rows, least, changed) in [
            (rows, all - all / 6, [1 << light_bit; 2]),
            (rows, all, [0; 2]),
            (moved, 0, [u32::MAX, 0]),
            (moved, all, [0; 2]),
        ] {
            scene.set_light(2, light)?;
            scene.scene.set_transform(scene.content.casters[0].handle, rows).map_err(text)?;
            let (_, cached, _, active) = frame(&mut scene, &cameras)?;
            let is_changed = |(number, active): (usize, &u32)| active & !changed[usize::from(number > 0)] == 0;
            if cached < least || !active.iter().enumerate().all(is_changed) {
                return Err(format!("{cached} of {all} lists are cached, at least {least}; active pairs {active:?}"));
            }
            partly += u32::from(cached < all);
        }
    }
    // Without caching a later frame computes what the first did.
    let mut options = roomy(40);
    options.measuring.set(Measuring::CACHED_BITS, true);
    let mut scene = RandomScene::filled_rigid(gpu, 2701, options, [6, 8])?;
    let [first, later] = [checked(gpu, &mut scene)?, checked(gpu, &mut scene)?].map(|checked| checked.found.statistics);
    same("not cached", &[later], &[first])?;
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
    must_fail("old bits", &frame(&mut scene))
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
        refused([refusal("bounds", scene.scene.set_bounds(caster, Some(bounds)), shows(&["Bounds {"]))])?;
    }
    scene.insert_rigid()?;
    let rigid = scene.content.casters[1].handle;
    refused([
        refusal("bounds of a rigid caster", scene.scene.set_bounds(rigid, None), is(ShadowError::NoBuffer)),
        refusal("its version", scene.scene.set_position_version(rigid, Some(1)), is(ShadowError::NoBuffer)),
    ])
}

/// Masks of callers are copied for each frame, and nothing of their group is cached. The same faces again keep the layout.
fn excluded() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::filled_rigid(gpu, 2901, roomy(8), [4, 5])?;
    let (caster, light) = (scene.content.casters[2].handle, scene.content.lights[1].0);
    read_frame(gpu, &mut scene)?;
    scene.scene.set_excluded(caster, light, &[0]).map_err(text)?;
    let (frame, first) = read_frame(gpu, &mut scene)?;
    scene.scene.set_excluded(caster, light, &[0]).map_err(text)?;
    let (same_faces, second) = read_frame(gpu, &mut scene)?;
    same("the layout is the same", &[same_faces.has_layout_of(&frame)], &[true])?;
    same("cached pairs", &[second.statistics.cached_pairs], &[0])?;
    let masks = |found: &Found| found.groups.iter().flat_map(|group| group.excluded.clone()).collect::<Vec<_>>();
    same("masks", &masks(&second), &masks(&first))?;
    scene.scene.set_excluded(caster, light, &[]).map_err(text)?;
    let no_faces = checked(gpu, &mut scene)?.frame;
    same("the layout is another", &[no_faces.has_layout_of(&frame)], &[false])?;
    scene.scene.set_excluded(caster, light, &[]).map_err(text)?;
    let statistics = checked(gpu, &mut scene)?.found.statistics;
    same("pairs cached again", &[statistics.cached_pairs], &[statistics.pairs])
}

/// The counts of lists tell that a light is in the plane of a face with cached bits.
fn zeros() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut scene = RandomScene::filled(gpu, 3001, roomy(8), [0, 0])?;
    let mesh = scene.add_mesh("cube", shapes::cube())?;
    scene.insert_at(mesh, IDENTITY)?;
    // A corner of a face lies in its plane.
    let corner = shapes::cube().positions[0];
    scene.put_light(Light::point(corner))?;
    scene.set_all_lights()?;
    let flags = |scene: &mut RandomScene| {
        let frame = gpu.submit(|encoder| scene.encode(encoder))?;
        let results = frame.results().map_err(text)?;
        let group = results.groups.first().ok_or("no group")?;
        let (counts, record) = (gpu.read::<u32>(group.lists, 64)?, gpu.read::<u32>(group.record, 4)?);
        Ok::<_, String>([record[3] != 0, counts[32] != 0])
    };
    let found = [flags(&mut scene)?, flags(&mut scene)?, flags(&mut scene)?];
    same("computed, and cached", &found, &[[true, false], [false, true], [false, true]])?;
    scene.set_light(0, Light::point([corner[0] + 7.3, corner[1] + 5.1, corner[2] + 9.7]))?;
    same("moved away", &[flags(&mut scene)?, flags(&mut scene)?], &[[false; 2]; 2])
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
