//! Clusters of rigid casters: every bit and every list is what it is without them, in any motion.

use std::sync::Arc;

use rimline::Light;
use rimline::gpu::{CasterPositions, SceneFrame, SceneOptions};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::on_gpu::text;
use rimline_testkit::random::Random;
use rimline_testkit::{must_fail, same, shapes};

use crate::cluster_meshes::{self, Case};
use crate::found::{Found, check_frame};
use crate::lists::{Listed, listed};
use crate::random_scene::{Placed, RandomScene};
use crate::scenes::roomy;

pub(crate) const TESTS: &[Test] = &[
    ("clusters_change_no_bit", hostile),
    ("clusters_are_right_after_late_and_dropped_frames", late),
    ("words_of_clusters_of_an_older_layout_are_not_believed", shifted),
    ("clusters_spare_most_faces_of_smooth_meshes", smooth),
];

const IDENTITY: rimline::Matrix3x4 = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

fn options() -> SceneOptions {
    SceneOptions { clusters_from: Some(1), ..roomy(40) }
}

/// A scene with one more mesh, and a caster of it that lies as the mesh does.
fn with_mesh(gpu: &Gpu, seed: u64, shape: shapes::Shape) -> Result<RandomScene, String> {
    let mut scene = RandomScene::new(gpu, seed, options())?;
    let case = rimline_testkit::cases::case("clusters", shape);
    let handle = scene.scene.add_mesh(&case.2, &case.1).map_err(text)?;
    scene.content.meshes.push((Arc::new(case), handle));
    let mesh = scene.content.meshes.len() - 1;
    scene.insert_as(mesh, Placed::Rigid(IDENTITY), CasterPositions::Rigid(IDENTITY.into()))?;
    Ok(scene)
}

fn put_lights(scene: &mut RandomScene, lights: &[Light]) -> Result<(), String> {
    for (index, &light) in lights.iter().enumerate().take(40) {
        if let Some((handle, old)) = scene.content.lights.get_mut(index) {
            *old = light;
            scene.scene.set_light(*handle, light).map_err(text)?;
        } else {
            let handle = scene.scene.add_light(light).map_err(text)?;
            scene.content.lights.push((handle, light));
        }
    }
    Ok(())
}

/// A frame against casters alone, and what it listed. `kept` is as in [`listed`]. In the first frame a flipped bit must be noticed.
fn check(gpu: &Gpu, scene: &mut RandomScene, kept: &mut Vec<u32>) -> Result<Listed, String> {
    let frame: SceneFrame = gpu.submit(|encoder| scene.encode(encoder))?;
    let mut found = Found::read(gpu, &frame)?;
    check_frame(&scene.content, &frame, &found)?;
    if let Some(face) = found.lit_face(&scene.content, &frame).filter(|_| kept.is_empty()) {
        found.groups[face.group].facing[face.slot] ^= face.bit;
        must_fail("a flipped facing bit", &check_frame(&scene.content, &frame, &found))?;
    }
    listed(gpu, &frame, kept)
}

/// Smooth, flat, nearly flat, huge, tiny and spoilt meshes, with lights where a bound only just decides, in planes and on
/// vertices. Lights and casters move from frame to frame.
fn hostile() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(4101);
    println!("seed 4101");
    let mut sum = Listed::default();
    for index in 0..if is_long() { 600 } else { 60 } {
        let Case { name, shape, lights } = cluster_meshes::case(&mut random, index);
        let what = |error: String| format!("{name}, case {index}: {error}");
        // A scene refuses a negative weight; the same point has a positive one.
        let positive =
            |light: &Light| if light.w < 0.0 { Light::homogeneous(light.to_array().map(|c| -c)) } else { *light };
        let lights: Vec<Light> = lights.iter().map(positive).collect();
        let mut scene = with_mesh(gpu, 4200 + index as u64, shape)?;
        put_lights(&mut scene, &lights)?;
        for _ in 0..3 {
            scene.insert(gpu)?;
        }
        let mut kept = Vec::new();
        for frame in 0..4 {
            sum.add(check(gpu, &mut scene, &mut kept).map_err(what)?);
            if frame % 2 == 0 {
                scene.move_lights()?;
                scene.move_casters()?;
            } else {
                // Lights of the case take other bits.
                let turned: Vec<Light> = lights.iter().cycle().skip(frame).take(lights.len()).copied().collect();
                put_lights(&mut scene, &turned)?;
            }
        }
    }
    println!("{sum:?}");
    let is_vacuous = sum.faces == 0 || sum.edges == 0 || sum.unlisted == 0 || sum.spared.contains(&0);
    if is_vacuous { Err("not as meant".to_owned()) } else { Ok(()) }
}

/// Cached decisions on clusters follow the order in which frames are submitted.
fn late() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let encoder = || gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    for seed in 4301..if is_long() { 4401 } else { 4311 } {
        println!("seed {seed}");
        let mut scene = with_mesh(gpu, seed, shapes::blob(12, 0.3, seed as u32))?;
        for _ in 0..9 {
            scene.add_light()?;
        }
        for number in 0..8 {
            let what = |error: String| format!("frame {number}: {error}");
            match scene.random.below(4) {
                0 => drop(scene.encode(&mut encoder())?),
                1 => {
                    let mut first = encoder();
                    let frame = scene.encode(&mut first)?;
                    let (results, content) = (frame.results().map_err(text)?, scene.content.clone());
                    scene.move_lights()?;
                    let mut second = encoder();
                    let later = scene.encode(&mut second)?;
                    gpu.queue.submit([second.finish()]);
                    check_frame(&scene.content, &later, &Found::read(gpu, &later)?).map_err(what)?;
                    gpu.queue.submit([first.finish()]);
                    check_frame(&content, &frame, &Found::of(gpu, &results)?).map_err(what)?;
                }
                2 => scene.insert(gpu)?,
                _ => {}
            }
            let frame = gpu.submit(|encoder| scene.encode(encoder))?;
            check_frame(&scene.content, &frame, &Found::read(gpu, &frame)?).map_err(what)?;
            scene.move_lights()?;
            scene.move_casters()?;
        }
    }
    Ok(())
}

/// Casters behind a sphere come and go, so that its words lie a cluster apart from frame to frame, while its masks stay. The
/// light turns round. The first cluster of an axis then has what the last of the axis before had.
fn shifted() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut scene, mut frames) = (with_mesh(gpu, 4501, shapes::sphere(20))?, 0);
    scene.set_all_lights()?;
    let directions = [[1.0, 0.01, 0.02], [0.01, 1.0, 0.02], [0.02, 0.01, 1.0]];
    put_lights(&mut scene, &[Light::directional(directions[0])])?;
    for casters in [9, 7, 5, 3, 1, 3, 5, 7, 9, 3, 9, 1] {
        while scene.content.casters.len() > casters {
            let own = scene.content.casters.pop().ok_or("no caster")?;
            scene.scene.remove(own.handle).map_err(text)?;
        }
        while scene.content.casters.len() < casters {
            scene.insert_as(0, Placed::Rigid(IDENTITY), CasterPositions::Rigid(IDENTITY.into()))?;
        }
        scene.set_all_lights()?;
        for direction in directions {
            let sign = if frames % 2 == 0 { 1.0 } else { -1.0 };
            put_lights(&mut scene, &[Light::directional(direction.map(|c| sign * c))])?;
            frames += 1;
            let what = |error: String| format!("frame {frames}, {casters} casters: {error}");
            let frame = gpu.submit(|encoder| scene.encode(encoder))?;
            check_frame(&scene.content, &frame, &Found::read(gpu, &frame)?).map_err(what)?;
        }
    }
    Ok(())
}

/// Four times the faces of a sphere leave about twice as many to test.
fn smooth() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut tested = Vec::new();
    for size in [32, 64] {
        let shape = shapes::sphere(size);
        let count = shape.faces.len();
        let mut scene = with_mesh(gpu, 4401, shape)?;
        scene.content.casters[0].lights = rimline::gpu::LightMask::ALL;
        scene.set_all_lights()?;
        put_lights(&mut scene, &[Light::point([3.0, 2.0, 1.0])])?;
        let listed = check(gpu, &mut scene, &mut Vec::new())?;
        same("faces in all", &[listed.spared[0] as usize + 64 * listed.faces >= count], &[true])?;
        tested.push(count as f64 - f64::from(listed.spared[0]));
        println!("{count} faces, spared {:?}", listed.spared);
    }
    let growth = tested[1] / tested[0];
    if growth < 2.6 { Ok(()) } else { Err(format!("{growth} times as many faces are tested")) }
}
