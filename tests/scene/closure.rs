//! The sides of volumes are the boundary of the faces that cast, also with faces that are excluded at random, or with lights
//! in their planes.

use std::collections::{BTreeMap, HashMap};

use rimline::Light;
use rimline::gpu::FrameInputs;
use rimline::internals::cpu;
use rimline::internals::scene::SceneTable;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::{IDENTITY, must_fail, same};

use crate::found::{Found, entries_of, slot_order};
use crate::histories::camera;
use crate::random_scene::{RandomScene, TestCaster};
use crate::scenes::roomy;

pub(crate) const TESTS: &[Test] = &[("sides_are_the_boundary_of_what_casts", boundary)];

/// How often each edge is walked from its lower to its higher vertex, less the other way.
type Chain = BTreeMap<[u32; 2], i32>;

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

/// Half of the scenes exclude faces. The others have cached bits in the second frame, whose camera is another, and a light
/// in the planes of some faces.
fn boundary() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let [mut every, mut back_facing, mut in_planes] = [0; 3];
    for seed in 3201..3241 {
        let mut scene = RandomScene::filled(gpu, seed, roomy(40), [4 + seed as usize % 5, 8])?;
        // Faces that the test excludes, by casters and lights.
        let mut given: HashMap<(usize, u32), Vec<u32>> = HashMap::new();
        if seed % 2 == 0 {
            scene.insert_at(0, IDENTITY)?;
            let corner = scene.content.meshes[0].0.1[0];
            scene.put_light(Light::point(corner))?;
            scene.set_all_lights()?;
        }
        for index in (0..scene.content.casters.len()).filter(|_| seed % 2 != 0) {
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
        for _ in 0..2 {
            let view = camera(&mut scene.random).into();
            let frame = gpu.submit(|encoder| scene.scene.encode(encoder, FrameInputs::new(&[view])).map_err(text))?;
            let found = Found::read(gpu, &frame)?;
            let results = frame.results().map_err(text)?;
            let words: Vec<u32> = gpu.read(results.choices.ok_or("no view")?, usize::MAX)?;
            let casters = scene.content.casters.len();
            for (number, caster) in scene.content.casters.iter().enumerate() {
                let (index, group) = frame.locate(caster.handle).ok_or("the frame lacks a caster")?;
                for of_group in results.groups.iter().filter(|of| of.group == group) {
                    let sides: Vec<u32> = gpu.read(of_group.sides[0], usize::MAX)?;
                    let chosen = &words[8 * (of_group.batch * casters + index as usize)..][..8];
                    for bit in (0..32).filter(|bit| chosen[0] >> bit & 1 != 0) {
                        let [is_every, heeds] = [1, 4].map(|word| chosen[word] >> bit & 1 != 0);
                        let light = 32 * of_group.batch as u32 + bit;
                        let given = given.get(&(number, light)).map(Vec::as_slice).unwrap_or_default();
                        let what = format!("caster {number}, light {light}, every face {is_every}");
                        if !given.is_empty() && !heeds {
                            return Err(format!("{what}: excluded faces of the caller are not heeded"));
                        }
                        let (expected, zeros) = expected(&scene, caster, light, given, [is_every, heeds])?;
                        let order = slot_order(&frame, caster.handle, scene.content.mesh_and_positions(caster).0);
                        let capacity = of_group.side_capacity as usize;
                        let range = &sides[64 + bit as usize * capacity..][..capacity];
                        let [plain, clipped] = [0, 1].map(|kind| sides[(2 * bit + kind) as usize] as usize);
                        let all = [&range[..plain], &range[capacity - clipped..]].concat();
                        let mut listed = Chain::new();
                        for side in entries_of(&SceneTable(&found.table).caster(index), &all) {
                            let (edge, times) = (side & !cpu::WINDING, if side & cpu::WINDING != 0 { 1 } else { -1 });
                            let record = order.as_ref().map_or(edge, |[_, records]| records[edge as usize]);
                            let mesh = scene.content.mesh_and_positions(caster).0;
                            add(&mut listed, mesh.edges().vertices()[record as usize], times);
                        }
                        same(&what, &Vec::from_iter(&listed), &Vec::from_iter(&expected))?;
                        *(if is_every { &mut every } else { &mut back_facing }) += 1;
                        in_planes += zeros;
                        if let Some((&edge, _)) = expected.iter().next() {
                            add(&mut listed, edge, 1);
                            let wrong = same(&what, &Vec::from_iter(&listed), &Vec::from_iter(&expected));
                            must_fail("a side too many", &wrong)?;
                        }
                    }
                }
            }
        }
    }
    println!(
        "{every} pairs by every face, {back_facing} by back-facing ones, {in_planes} faces with the light in their plane"
    );
    if every.min(back_facing) < 50 || in_planes < 50 { Err("too few of a kind".to_owned()) } else { Ok(()) }
}

/// The boundary of the faces that cast for a light: front-facing ones count once, back-facing ones negatively, excluded ones
/// not. And how many have the light in their plane.
fn expected(
    scene: &RandomScene,
    caster: &TestCaster,
    light: u32,
    given: &[u32],
    [every, heeds]: [bool; 2],
) -> Result<(Chain, usize), String> {
    let (mesh, positions) = scene.content.mesh_and_positions(caster);
    let light = scene.content.moved_light(caster, light).ok_or("a light that is not allowed")?;
    let facing = cpu::facing(positions, mesh.faces(), &[light], rimline::Predicate::Exact, cpu::Threads::ONE);
    let excluded = cpu::excluded(positions, mesh.faces(), &[light]);
    let mut chain = Chain::new();
    for ((number, &[a, b, c]), (facing, excluded)) in (0..).zip(mesh.faces()).zip(facing.iter().zip(&excluded)) {
        // A face with the light in its plane counts as back-facing, unless exclusions are heeded.
        let is_excluded = given.contains(&number) || (heeds && excluded & 1 != 0);
        let faces_light = facing & 1 != 0;
        if !is_excluded && (every || !faces_light) {
            let sign = if faces_light { 1 } else { -1 };
            for edge in [[a, b], [b, c], [c, a]] {
                add(&mut chain, edge, sign);
            }
        }
    }
    Ok((chain, excluded.iter().filter(|mask| **mask & 1 != 0).count()))
}
