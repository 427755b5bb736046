//! Facing of scenes by exact arithmetic and without it, and what is left to it.

use rimline::gpu::{Capacities, Caster, FrameInputs, LightMask, Measuring, Scene, SceneOptions};
use rimline::internals::cpu::{self, Threads};
use rimline::internals::scene::SceneTable;
use rimline::{Light, Mesh, Predicate};
use rimline_testkit::band::check_facing;
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::oracle::listed;
use rimline_testkit::random::Random;
use rimline_testkit::{must_fail, same, shapes};

use crate::found::{Found, checked, entries_of, read_frame};
use crate::random_scene::{IDENTITY, RandomScene};
use crate::scenes::roomy;

pub(crate) const TESTS: &[Test] = &[
    ("a_full_list_of_undecided_faces_loses_nothing", undecided_overflow),
    ("fast_facing_is_right_outside_its_band", fast),
    ("ordinary_scenes_leave_few_faces_undecided", few_undecided),
    ("exact_facing_of_scenes_ends_however_much_there_is_to_settle", full_invocations),
];

fn undecided_overflow() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut undecided = 0;
    for seed in 1801..1811 {
        let options = SceneOptions { capacities: Capacities { undecided: Some(1), ..roomy(8).capacities }, ..roomy(8) };
        let mut scene = RandomScene::filled(gpu, seed, options, [6, 10])?;
        // Some lights lie in planes of faces of these.
        (0..scene.content.meshes.len()).try_for_each(|mesh| scene.insert_at(mesh, IDENTITY).map(drop))?;
        let found = checked(gpu, &mut scene)?.found;
        undecided += found.groups.iter().map(|group| group.statistics.undecided_pairs).sum::<u32>();
        scene.change(gpu)?;
        checked(gpu, &mut scene)?;
    }
    println!("{undecided} undecided pairs");
    if undecided < 1000 { Err("hardly anything was undecided".to_owned()) } else { Ok(()) }
}

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
            let relevant = found.relevant[index as usize];
            let bits: Vec<u32> = (0..32).filter(|bit| relevant >> bit & 1 != 0).collect();
            let lights = bits.iter().map(|&bit| scene.content.moved_light(caster, bit));
            let lights: Vec<_> = lights.collect::<Option<_>>().ok_or("a light is not allowed")?;
            if lights.is_empty() {
                continue;
            }
            let (mesh, positions) = scene.content.mesh_and_positions(caster);
            let entry = SceneTable(&found.table).caster(index);
            let results = found.group(group, 0)?;
            let slots = entry.first_face_slot as usize..(entry.first_face_slot + entry.faces) as usize;
            let gather =
                |&mask: &u32| bits.iter().zip(0..).fold(0, |all, (bit, index)| all | (mask >> bit & 1) << index);
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
        let frame = gpu.submit(|encoder| scene.encode(encoder, FrameInputs::default()).map_err(text))?;
        let undecided: u32 = Found::read(gpu, &frame)?.groups.iter().map(|group| group.undecided).sum();
        println!("{lights} lights: {undecided} of {} faces undecided", 20 * mesh.faces().len());
        if undecided as usize * 100 > 20 * mesh.faces().len() {
            return Err(format!("{undecided} faces are undecided"));
        }
    }
    Ok(())
}

/// A workgroup of 64 that each have 40 faces, as many as a CPU's have.
const FULL: u32 = 64 * 40;

/// Every pair beyond `f32` and beyond fixed point, and as many faces as fill an invocation's turns, with all lights of
/// a batch and with one left out: llvmpipe ends an invocation's loops after 65,535 turns without a word.
fn full_invocations() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let seed = 2901;
    println!("seed {seed}");
    let mut random = Random::new(seed);
    let mut flat = || [random.between(-1.0, 1.0), random.between(-1.0, 1.0), random.between(-1.0, 1.0) * 1e-39];
    let positions: Vec<[f32; 3]> = (0..3 * FULL).map(|_| flat()).collect();
    let lights: Vec<Light> = (0..32).map(|_| Light::point(flat())).collect();
    let faces: Vec<[u32; 3]> = (0..FULL).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
    let mesh = Mesh::from_faces(positions.len(), faces).map_err(text)?;
    let right = cpu::facing(&positions, mesh.faces(), &lights, Predicate::Exact, Threads::all());
    for left_out in [None, Some(0)] {
        let mut scene = Scene::new(&gpu.pipelines, &gpu.queue, SceneOptions::default()).map_err(text)?;
        let handles = lights.iter().map(|&light| scene.add_light(light).map_err(text));
        let handles = handles.collect::<Result<Vec<_>, _>>()?;
        let flat = scene.add_mesh(&mesh, &positions).map_err(text)?;
        let mask = left_out.map_or(LightMask::ALL, |bit: usize| LightMask::ALL.without(handles[bit]));
        scene.insert(Caster { lights: mask, ..Caster::rigid(flat, IDENTITY) }).map_err(text)?;
        let frame = gpu.submit(|encoder| scene.encode(encoder, FrameInputs::default()).map_err(text))?;
        let found = Found::read(gpu, &frame)?;
        let group = found.group(0, 0)?;
        let allowed = left_out.map_or(u32::MAX, |bit| !(1 << bit));
        same("undecided pairs", &[group.statistics.undecided_pairs], &[allowed.count_ones() * FULL])?;
        let expected: Vec<u32> = right.iter().map(|mask| mask & allowed).collect();
        let mut facing = group.facing[..FULL as usize].to_vec();
        same("facing", &facing, &expected)?;
        facing[FULL as usize - 1] ^= 2;
        must_fail("a flipped facing bit", &same("facing", &facing, &expected))?;
    }
    Ok(())
}
