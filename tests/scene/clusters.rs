//! Clusters of rigid casters change no bit and no list, in any motion. The stages are `clusters` and `chunks`.

use rimline::Light;
use rimline::gpu::{SceneOptions, SceneStatistics};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::is_long;
use rimline_testkit::must_fail;
use rimline_testkit::random::Random;
use rimline_testkit::shapes::{self, Shape};

use crate::found::{Checked, check_frame, checked};
use crate::random_scene::{IDENTITY, RandomScene};
use crate::scenes::roomy;
use rimline_testkit::cluster_meshes::{self, Case};

pub(crate) const TESTS: &[Test] = &[
    ("clusters_change_no_bit", hostile),
    ("words_of_clusters_of_an_older_layout_are_not_believed", shifted),
    ("clusters_spare_most_faces_of_smooth_meshes", smooth),
];

/// A scene with one more mesh, and a caster of it in mesh space.
fn with_mesh(gpu: &Gpu, seed: u64, shape: Shape) -> Result<RandomScene, String> {
    let mut scene = RandomScene::filled(gpu, seed, SceneOptions { clusters_from: Some(1), ..roomy(40) }, [0, 0])?;
    let mesh = scene.add_mesh("clusters", shape)?;
    scene.insert_at(mesh, IDENTITY)?;
    Ok(scene)
}

fn put_lights(scene: &mut RandomScene, lights: &[Light]) -> Result<(), String> {
    for (index, &light) in lights.iter().enumerate().take(40) {
        if index < scene.content.lights.len() {
            scene.set_light(index, light)?;
        } else {
            scene.put_light(light)?;
        }
    }
    Ok(())
}

/// Smooth, flat, nearly flat, huge, tiny and spoilt meshes, with lights where a bound only just decides, in planes and on
/// vertices. Lights and casters move from frame to frame.
fn hostile() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let mut random = Random::new(4101);
    println!("seed 4101");
    let mut sum = [0; 4];
    for index in 0..if is_long() { 600 } else { 60 } {
        let Case { name, shape, lights } = cluster_meshes::case(&mut random, index);
        let what = |error: String| format!("{name}, case {index}: {error}");
        // A scene refuses a negative weight; the same point has a positive one.
        let positive =
            |light: &Light| if light.w < 0.0 { Light::homogeneous(light.to_array().map(|c| -c)) } else { *light };
        let lights: Vec<Light> = lights.iter().map(positive).collect();
        let mut scene = with_mesh(gpu, 4200 + index as u64, shape)?;
        put_lights(&mut scene, &lights)?;
        (0..3).try_for_each(|_| scene.insert(gpu))?;
        for frame in 0..4 {
            let Checked { frame: drawn, mut found } = checked(gpu, &mut scene).map_err(what)?;
            let SceneStatistics { faces, edges, untested_faces, untested_edges, .. } = found.statistics;
            sum.iter_mut().zip([faces, edges, untested_faces, untested_edges]).for_each(|(sum, count)| *sum += count);
            if let Some(face) = found.lit_face(&scene.content, &drawn).filter(|_| frame == 0) {
                found.groups[face.group].facing[face.slot] ^= face.bit;
                must_fail("a flipped facing bit", &check_frame(&scene.content, &drawn, &found))?;
            }
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
    if sum.contains(&0) { Err("too few of a kind".to_owned()) } else { Ok(()) }
}

/// Casters behind a sphere are added and removed, so that its words in the cache move by a cluster from frame to frame,
/// while its masks stay. The light turns around. The first cluster of an axis then has the words of the last cluster of
/// the axis before.
fn shifted() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let (mut scene, mut frames) = (with_mesh(gpu, 4501, shapes::sphere(20))?, 0);
    scene.set_all_lights()?;
    let directions = [[1.0, 0.01, 0.02], [0.01, 1.0, 0.02], [0.02, 0.01, 1.0]];
    put_lights(&mut scene, &[Light::directional(directions[0])])?;
    for casters in [9, 7, 5, 3, 1, 3, 5, 7, 9, 3, 9, 1] {
        while scene.content.casters.len() > casters {
            scene.remove_caster(scene.content.casters.len() - 1)?;
        }
        while scene.content.casters.len() < casters {
            scene.insert_at(0, IDENTITY)?;
        }
        scene.set_all_lights()?;
        for direction in directions {
            let sign = if frames % 2 == 0 { 1.0 } else { -1.0 };
            put_lights(&mut scene, &[Light::directional(direction.map(|c| sign * c))])?;
            frames += 1;
            checked(gpu, &mut scene).map_err(|error| format!("frame {frames}, {casters} casters: {error}"))?;
        }
    }
    Ok(())
}

/// Four times the faces of smooth meshes leave about twice as many to test, in any order.
fn smooth() -> Result<(), String> {
    let gpu = &*Gpu::shared()?;
    let make: [fn(u32) -> Shape; 3] =
        [shapes::sphere, |size| shapes::torus(2 * size, 2 * size, 1.0, 0.4), |size| shapes::sphere(size).shuffled(1)];
    for (number, make) in make.into_iter().enumerate() {
        let mut tested = Vec::new();
        for size in [32, 64] {
            let mut scene = with_mesh(gpu, 4401, make(size))?;
            scene.set_all_lights()?;
            put_lights(&mut scene, &[Light::point([3.0, 2.0, 1.0])])?;
            let SceneStatistics { faces, untested_faces, .. } = checked(gpu, &mut scene)?.found.statistics;
            println!("mesh {number}: {faces} faces tested, {untested_faces} not");
            tested.push(f64::from(faces));
        }
        let growth = tested[1] / tested[0];
        if growth >= 2.6 {
            return Err(format!("{growth} times as many faces of mesh {number} are tested"));
        }
    }
    Ok(())
}
