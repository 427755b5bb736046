//! Scenes of so many faces that cones of directions are searched one by one.

use std::ops::ControlFlow;

use rimline::Light;
use rimline::cpu::{OccludedFaces, OcclusionOptions, Threads};
use rimline_testkit::random::Random;
use rimline_testkit::shapes::{self, Shape};

use crate::occluded_faces::{all_left_out, casters, check, find, lists};
use crate::static_scenes::{Caster, StaticScene};

/// Towers around the light or under it.
fn towers(random: &mut Random, light: Light) -> StaticScene {
    let shape = shapes::cube();
    let tower = |_| {
        let high = random.between(1.0, 8.0);
        let at = [random.between(-30.0, 30.0), random.between(-30.0, 30.0), high];
        let position = |p: &[f32; 3]| [p[0] + at[0], p[1] + at[1], high * p[2] + at[2]];
        let positions: Vec<[f32; 3]> = shape.positions.iter().map(position).collect();
        Caster::new(Shape { positions, faces: shape.faces.clone() })
    };
    StaticScene { casters: (0..500).map(tower).collect(), light }
}

#[test]
fn occluded_faces_are_occluded_in_scenes_of_many_cones() {
    let lights = [
        Light::directional([1.0, 0.3, 0.4]),
        Light::directional([0.0, 0.0, 1.0]),
        Light::point([0.0, 0.0, 9.5]),
        Light::point([1e4, 3e3, 4e3]),
    ];
    let (mut occluded, mut refuted) = (0, 0);
    for (seed, light) in (8000..).zip(lights) {
        let mut random = Random::new(seed);
        let scene = towers(&mut random, light);
        let options = OcclusionOptions { threads: Threads::new(3), ..all_left_out() };
        let found = find(&scene, options);
        let mut faces = lists(&scene, &found);
        let count = check(&scene, &faces, &mut random, 40).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        assert_eq!(count, found.statistics().occluded, "seed {seed}");
        occluded += count;
        // So many threads find the same.
        assert_eq!(find(&scene, OcclusionOptions { threads: Threads::ONE, ..options }), found, "seed {seed}");
        // With faces that stay, the check must fail, as a rule.
        for (caster, faces) in scene.casters.iter().zip(&mut faces).take(50) {
            *faces = (0..caster.mesh.faces().len() as u32).collect();
        }
        refuted += usize::from(check(&scene, &faces, &mut random, 40).is_err());
    }
    println!("{occluded} occluded faces; {refuted} wrong lists refuted");
    assert!(occluded > 4000 && refuted > 2, "{occluded} {refuted}");
}

/// A wall in the plane that parts the cones, edge-on to the light, between faces of which none hides another.
#[test]
fn a_face_in_the_plane_between_cones_is_searched() {
    let flat = |x: i32| [[x as f32, 0.0, 0.0], [x as f32 + 0.25, 0.0, 0.0], [x as f32, 0.25, 0.0]];
    let wall = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let positions: Vec<[f32; 3]> = (-1050..=1050).flat_map(|x| if x == 0 { wall } else { flat(x) }).collect();
    let faces: Vec<[u32; 3]> = (0..2101).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
    let casters = vec![Caster::new(Shape { positions, faces })];
    let found = find(&StaticScene { casters, light: Light::directional([0.0, 0.0, 1.0]) }, all_left_out()).statistics();
    assert_eq!([found.tried, found.occluded, found.undecided], [2101, 0, 0]);
}

#[test]
fn progress_never_goes_back_and_has_one_end() {
    let light = Light::point([0.0, 0.0, 9.5]);
    let scene = towers(&mut Random::new(8010), light);
    let faces: usize = scene.casters.iter().map(|caster| caster.mesh.faces().len()).sum();
    for threads in [Threads::ONE, Threads::new(3)] {
        let options = OcclusionOptions { threads, ..OcclusionOptions::default() };
        let mut calls = Vec::new();
        let progress = |done, all| {
            calls.push((done, all));
            ControlFlow::Continue(())
        };
        OccludedFaces::find(light, &casters(&scene), options, progress).expect("found");
        let (last, end) = calls.last().copied().expect("a call");
        assert!(calls.is_sorted() && calls.iter().all(|&(_, all)| all == end), "{calls:?}");
        // Faces are in several cones.
        assert!(last == end && end > faces && calls.len() >= 500, "{last} of {end}, {faces} faces");
    }
}
