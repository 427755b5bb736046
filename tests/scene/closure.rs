//! The sides of volumes are the boundary of the faces that cast, also with faces that are excluded at random.

use std::collections::HashMap;

use rimline::ShadowCamera;
use rimline::gpu::FrameInputs;
use rimline::internals::cpu;
use rimline::internals::scene::SceneTable;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::{must_fail, same};

use crate::found::{Found, SlotOrder, entries_of, slot_order};
use crate::histories::camera;
use crate::random_scene::{RandomScene, TestCaster};
use crate::scenes::roomy;

pub(crate) const TESTS: &[Test] = &[("sides_are_the_boundary_of_what_casts", boundary)];

/// How often each edge is traversed from its lower to its higher vertex, less the other way.
type Chain = HashMap<[u32; 2], i32>;

fn add(chain: &mut Chain, [from, to]: [u32; 2], times: i32) {
    // A degenerate face may have a degenerate edge.
    if from == to {
        return;
    }
    let (edge, times) = if from < to { ([from, to], times) } else { ([to, from], -times) };
    let sum = chain.entry(edge).or_default();
    *sum += times;
    if *sum == 0 {
        chain.remove(&edge);
    }
}

/// The boundary of the faces that cast for a light: front-facing ones count once, back-facing ones negatively, excluded ones not.
fn of_faces(faces: &[[u32; 3]], facing: &[bool], excluded: impl Fn(usize) -> bool, every: bool) -> Chain {
    let mut chain = Chain::new();
    for (number, (&[a, b, c], &faces_light)) in faces.iter().zip(facing).enumerate() {
        if !excluded(number) && (every || !faces_light) {
            let sign = if faces_light { 1 } else { -1 };
            for edge in [[a, b], [b, c], [c, a]] {
                add(&mut chain, edge, sign);
            }
        }
    }
    chain
}

/// Faces that the test excludes, by casters and lights.
type Excluded = HashMap<(usize, u32), Vec<u32>>;

fn boundary() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let [mut every, mut back_facing, mut in_planes] = [0; 3];
    for seed in 3201..3241 {
        let mut scene = RandomScene::filled(gpu, seed, roomy(40), [4 + seed as usize % 5, 8])?;
        let mut given = Excluded::new();
        for index in 0..scene.content.casters.len() {
            for light in 0..scene.content.lights.len() {
                let caster = &scene.content.casters[index];
                let faces = scene.content.meshes[caster.mesh].0.2.faces().len() as u32;
                if scene.random.below(3) == 0 {
                    let some: Vec<u32> = (0..faces).filter(|_| scene.random.below(3) == 0).collect();
                    let handle = scene.content.lights[light].0;
                    scene.scene.set_excluded(caster.handle, handle, &some).map_err(text)?;
                    given.insert((index, handle.bit()), some);
                }
            }
        }
        let camera: ShadowCamera = camera(&mut scene.random);
        // The second frame has cached results.
        for _ in 0..2 {
            let frame =
                gpu.submit(|encoder| scene.scene.encode(encoder, FrameInputs::new(&[camera.into()])).map_err(text))?;
            let found = Found::read(gpu, &frame)?;
            let results = frame.results().map_err(text)?;
            let words: Vec<u32> = gpu.read(results.choices.ok_or("no view")?, usize::MAX)?;
            let casters = scene.content.casters.len();
            for (number, caster) in scene.content.casters.iter().enumerate() {
                let (index, group) = frame.locate(caster.handle).ok_or("the frame lacks a caster")?;
                for batch in 0..frame.batches() {
                    let of_group = results.groups.iter().find(|of| (of.group, of.batch) == (group, batch));
                    let of_group = of_group.ok_or("no group")?;
                    let sides: Vec<u32> = gpu.read(of_group.sides[0], usize::MAX)?;
                    let chosen = &words[8 * (batch * casters + index as usize)..][..8];
                    for bit in (0..32).filter(|bit| chosen[0] >> bit & 1 != 0) {
                        let [is_every, heeds] = [1, 4].map(|word| chosen[word] >> bit & 1 != 0);
                        let light = 32 * batch as u32 + bit;
                        let is_given = |face: usize| {
                            given.get(&(number, light)).is_some_and(|faces| faces.contains(&(face as u32)))
                        };
                        if given.get(&(number, light)).is_some_and(|faces| !faces.is_empty()) && !heeds {
                            return Err(format!("caster {number}: excluded faces of the caller are not heeded"));
                        }
                        let (expected, zeros) = expected(&scene, caster, light, is_given, [is_every, heeds])?;
                        let order = slot_order(&frame, caster.handle, scene.content.mesh_and_positions(caster).0);
                        let index_and_order = (index, order.as_ref());
                        let what = format!("caster {number}, light {light}, every face {is_every}");
                        let listed =
                            sides_of(&found, caster, &scene, index_and_order, of_group.side_capacity, (&sides, bit))
                                .map_err(|error| format!("{what}: {error}"))?;
                        compare(&what, &listed, &expected)?;
                        *(if is_every { &mut every } else { &mut back_facing }) += 1;
                        in_planes += zeros;
                        if let Some((&edge, _)) = expected.iter().next() {
                            let mut wrong = listed;
                            add(&mut wrong, edge, 1);
                            must_fail("a side too many", &compare(&what, &wrong, &expected))?;
                        }
                    }
                }
            }
        }
    }
    println!("{every} pairs by every face, {back_facing} by back-facing ones");
    println!("{in_planes} faces with the light in their plane");
    let is_vacuous = every.min(back_facing) < 50 || in_planes == 0;
    if is_vacuous { Err("too few of a kind".to_owned()) } else { Ok(()) }
}

fn compare(what: &str, listed: &Chain, expected: &Chain) -> Result<(), String> {
    let sorted = |chain: &Chain| {
        let mut edges: Vec<_> = chain.iter().map(|(edge, times)| (*edge, *times)).collect();
        edges.sort_unstable();
        edges
    };
    same(what, &sorted(listed), &sorted(expected))
}

/// The boundary by the faces, and how many have the light in their plane.
fn expected(
    scene: &RandomScene,
    caster: &TestCaster,
    light: u32,
    is_given: impl Fn(usize) -> bool,
    [every, heeds]: [bool; 2],
) -> Result<(Chain, usize), String> {
    let (mesh, positions) = scene.content.mesh_and_positions(caster);
    let light = scene.content.moved_light(caster, light).ok_or("a light that is not allowed")?;
    let facing = cpu::facing(positions, mesh.faces(), &[light], rimline::Predicate::Exact, cpu::Threads::ONE);
    let facing: Vec<bool> = facing.iter().map(|mask| mask & 1 != 0).collect();
    let excluded = cpu::excluded(positions, mesh.faces(), &[light]);
    let zeros = excluded.iter().filter(|mask| **mask & 1 != 0).count();
    // A face with the light in its plane counts as back-facing, unless exclusions are heeded.
    let is_excluded = |face: usize| is_given(face) || (heeds && excluded[face] & 1 != 0);
    Ok((of_faces(mesh.faces(), &facing, is_excluded, every), zeros))
}

/// The sides of a caster for a light of the batch, as a chain. There is room for them all.
fn sides_of(
    found: &Found,
    caster: &TestCaster,
    scene: &RandomScene,
    (index, order): (u32, Option<&SlotOrder>),
    capacity: u32,
    (words, bit): (&[u32], u32),
) -> Result<Chain, String> {
    let (mesh, _) = scene.content.mesh_and_positions(caster);
    let entry = SceneTable(&found.table).caster(index);
    let [plain, clipped] = [0, 1].map(|kind| words[(2 * bit + kind) as usize] as usize);
    let range = words[64 + (bit * capacity) as usize..].get(..capacity as usize).ok_or("sides end early")?;
    if plain + clipped > range.len() {
        return Err(format!("{plain} and {clipped} sides, and room for {capacity}"));
    }
    let mut chain = Chain::new();
    let all = [&range[..plain], &range[range.len() - clipped..]].concat();
    for side in entries_of(&entry, &all) {
        let (edge, times) = (side & !cpu::WINDING, if side & cpu::WINDING != 0 { 1 } else { -1 });
        let record = order.map_or(edge, |[_, records]| records[edge as usize]);
        add(&mut chain, mesh.edges().vertices()[record as usize], times);
    }
    Ok(chain)
}
