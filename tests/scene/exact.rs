//! Facing of scenes by exact arithmetic, and how much is left to it.

use rimline::gpu::{Caster, FrameInputs, LightMask, Scene, SceneOptions};
use rimline::internals::cpu::{self, Threads};
use rimline::{Light, Mesh, Predicate};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::on_gpu::text;
use rimline_testkit::{IDENTITY, must_fail, same, shapes};

use crate::found::Found;
use crate::scenes::roomy;

pub(crate) const TESTS: &[Test] = &[
    ("ordinary_scenes_leave_few_faces_undecided", few_undecided),
    ("exact_facing_of_scenes_ends_however_much_there_is_to_settle", full_invocations),
];

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
