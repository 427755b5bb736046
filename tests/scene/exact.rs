//! Facing of scenes by exact arithmetic and without it, and how much is left to it.

use rimline::gpu::{Caster, FrameInputs, LightMask, Measuring, Scene, SceneOptions};
use rimline::internals::cpu::{self, Threads};
use rimline::internals::scene::SceneTable;
use rimline::{Light, Mesh, Predicate};
use rimline_testkit::band::check_facing;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::oracle::listed;
use rimline_testkit::{IDENTITY, must_fail, same, shapes};

use crate::found::{Found, entries_of, read_frame};
use crate::random_scene::RandomScene;
use crate::scenes::roomy;

pub(crate) const TESTS: &[Test] = &[
    ("fast_facing_is_right_outside_its_band", fast),
    ("ordinary_scenes_leave_few_faces_undecided", few_undecided),
    ("exact_facing_of_scenes_ends_however_much_there_is_to_settle", full_invocations),
];

/// Facing without exact arithmetic errs in its band only, and the lists hold what its masks say.
fn fast() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut silhouettes = 0;
    for seed in 2601..2611 {
        // Slots have the order of the mesh.
        let options = SceneOptions { measuring: Measuring::FAST, ..roomy(8) };
        let mut scene = RandomScene::filled(gpu, seed, options, [6, 10])?;
        let (frame, found) = read_frame(gpu, &mut scene)?;
        for caster in &scene.content.casters {
            let (index, group) = frame.locate(caster.handle).ok_or("the frame lacks a caster")?;
            let bits: Vec<u32> = (0..32).filter(|bit| found.relevant[index as usize] >> bit & 1 != 0).collect();
            let lights = bits.iter().map(|&bit| scene.content.moved_light(caster, bit));
            let lights = lights.collect::<Option<Vec<_>>>().ok_or("a light is not allowed")?;
            if lights.is_empty() {
                continue;
            }
            let (mesh, positions) = scene.content.mesh_and_positions(caster);
            let entry = SceneTable(&found.table).caster(index);
            let results = found.group(group, 0)?;
            let slots = entry.first_face_slot as usize..(entry.first_face_slot + entry.faces) as usize;
            let gather = |&mask: &u32| bits.iter().zip(0..).fold(0, |all, (bit, at)| all | (mask >> bit & 1) << at);
            let facing: Vec<u32> = results.facing[slots].iter().map(gather).collect();
            check_facing(&format!("caster {index}"), &facing, positions, mesh.faces(), &lights)?;
            let masks = cpu::edges(mesh.edges(), &facing, mesh.faces().len(), lights.len(), Threads::ONE);
            for (light, &bit) in (0..).zip(&bits) {
                let mut list = entries_of(&entry, &results.lists[bit as usize]);
                let expected = listed(&masks, light);
                same("list", &list, &expected)?;
                silhouettes += list.len();
                if let Some(entry) = list.last_mut() {
                    *entry ^= cpu::WINDING;
                    must_fail("a flipped winding bit", &same("list", &list, &expected))?;
                }
            }
        }
    }
    if silhouettes == 0 { Err("no silhouettes".to_owned()) } else { Ok(()) }
}

/// Light indices past the last light of a caster repeat it, and each caster has a bound of its own lights. Neither
/// leaves more faces undecided than in a single mesh.
fn few_undecided() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(2801)?;
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
        let frame = gpu.submit(|encoder| scene.encode(encoder, FrameInputs::default()).map_err(text))?;
        let undecided: u32 = Found::read(&gpu, &frame)?.groups.iter().map(|group| group.undecided).sum();
        if undecided as usize * 100 > 20 * mesh.faces().len() {
            return Err(format!("{undecided} faces are undecided"));
        }
    }
    Ok(())
}

/// Every pair beyond `f32` and beyond fixed point, and as many faces as fill an invocation's turns, 64 invocations of 40 on a
/// CPU, with all lights of a batch and with one left out: llvmpipe ends an invocation's loops after 65,535 turns without a
/// word.
fn full_invocations() -> Result<(), String> {
    const FULL: u32 = 64 * 40;
    let (gpu, mut random) = Gpu::seeded(2901)?;
    let mut flat = || [random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(-1.0, 1.0) * 1e-39];
    let positions: Vec<[f32; 3]> = (0..3 * FULL).map(|_| flat()).collect();
    let lights: Vec<Light> = (0..32).map(|_| Light::point(flat())).collect();
    let faces: Vec<[u32; 3]> = (0..FULL).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
    let mesh = Mesh::from_faces(positions.len(), faces).map_err(text)?;
    let right = cpu::facing(&positions, mesh.faces(), &lights, Predicate::Exact, Threads::all());
    for allowed in [u32::MAX, u32::MAX - 1] {
        // A scene of its own: bits of lights that are left out stay as they are.
        let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, SceneOptions::default()).map_err(text)?;
        let handles = lights.iter().map(|&light| scene.add_light(light).map_err(text));
        let handles = handles.collect::<Result<Vec<_>, _>>()?;
        let flat = scene.add_mesh(&mesh, &positions).map_err(text)?;
        let mask = if allowed & 1 == 0 { LightMask::ALL.without(handles[0]) } else { LightMask::ALL };
        scene.insert(Caster { lights: mask, ..Caster::rigid(flat, IDENTITY) }).map_err(text)?;
        let frame = gpu.submit(|encoder| scene.encode(encoder, FrameInputs::default()).map_err(text))?;
        let found = Found::read(&gpu, &frame)?;
        let group = found.group(0, 0)?;
        same("undecided pairs", &[group.statistics.undecided_pairs], &[allowed.count_ones() * FULL])?;
        let expected: Vec<u32> = right.iter().map(|mask| mask & allowed).collect();
        let mut facing = group.facing[..FULL as usize].to_vec();
        same("facing", &facing, &expected)?;
        facing[FULL as usize - 1] ^= 2;
        must_fail("a flipped facing bit", &same("facing", &facing, &expected))?;
    }
    Ok(())
}
