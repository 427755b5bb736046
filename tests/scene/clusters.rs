//! Clusters of rigid casters change no bit and no list, in any motion. The stages are `clusters` and `chunks`.

use rimline::Light;
use rimline::gpu::{SceneOptions, SceneStatistics};
use rimline_testkit::cluster_meshes::{self, Case};
use rimline_testkit::device::Gpu;
use rimline_testkit::harness::Test;
use rimline_testkit::shapes::{self, Shape};
use rimline_testkit::{IDENTITY, is_long, must_fail};

use crate::found::{Checked, check_frame, checked};
use crate::random_scene::RandomScene;
use crate::scenes::roomy;

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
    lights.iter().enumerate().take(40).try_for_each(|(index, &light)| {
        if index < scene.content.lights.len() { scene.set_light(index, light) } else { scene.put_light(light) }
    })
}

/// Smooth, flat, nearly flat, huge, tiny and spoilt meshes, with lights where a bound only just decides, in planes and on
/// vertices. Lights and casters move from frame to frame.
fn hostile() -> Result<(), String> {
    let (gpu, mut random) = Gpu::seeded(4101)?;
    let mut sum = [0; 4];
    for index in 0..if is_long() { 600 } else { 60 } {
        let Case { name, shape, mut lights } = cluster_meshes::case(&mut random, index);
        let what = |error: String| format!("{name}, case {index}: {error}");
        // A scene refuses a negative weight; the same point has a positive one.
        for light in lights.iter_mut().filter(|light| light.w < 0.0) {
            *light = Light::homogeneous(light.to_array().map(|c| -c));
        }
        let mut scene = with_mesh(&gpu, 4200 + index as u64, shape)?;
        put_lights(&mut scene, &lights)?;
        (0..3).try_for_each(|_| scene.insert(&gpu))?;
        for frame in 0..4 {
            let Checked { frame: drawn, mut found } = checked(&gpu, &mut scene).map_err(what)?;
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
                let count = lights.len().max(1);
                lights.rotate_left(frame % count);
                put_lights(&mut scene, &lights)?;
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
    let (mut scene, mut sign) = (with_mesh(gpu, 4501, shapes::sphere(20))?, 1.0);
    put_lights(&mut scene, &[Light::directional([1.0, 0.01, 0.02])])?;
    for casters in [9, 7, 5, 3, 1, 3, 5, 7, 9, 3, 9, 1] {
        while scene.content.casters.len() > casters {
            scene.remove_caster(scene.content.casters.len() - 1)?;
        }
        while scene.content.casters.len() < casters {
            scene.insert_at(0, IDENTITY)?;
        }
        scene.set_all_lights()?;
        for direction in [[1.0, 0.01, 0.02], [0.01, 1.0, 0.02], [0.02, 0.01, 1.0]] {
            put_lights(&mut scene, &[Light::directional(direction.map(|c| sign * c))])?;
            sign = -sign;
            checked(gpu, &mut scene).map_err(|error| format!("{casters} casters, {direction:?}: {error}"))?;
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
            tested.push(f64::from(checked(gpu, &mut scene)?.found.statistics.faces));
        }
        let growth = tested[1] / tested[0];
        println!("mesh {number}: {tested:?} faces tested");
        if growth >= 2.6 {
            return Err(format!("{growth} times as many faces of mesh {number} are tested"));
        }
    }
    Ok(())
}
