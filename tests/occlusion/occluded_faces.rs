//! Occluded faces are occluded, point by point; and what must be found is found.

use std::ops::ControlFlow;

use rimline::cpu::{CpuError, OccludedFaces, OcclusionCaster, OcclusionOptions, Threads};
use rimline::mesh::Weld;
use rimline::{Light, LightError, Mesh};
use rimline_testkit::random::Random;
use rimline_testkit::shapes;

use crate::oracle::{Point, between, corner, hides, light, sign};
use crate::static_scenes::{Caster, StaticScene};

pub(crate) fn find(scene: &StaticScene, options: OcclusionOptions) -> OccludedFaces {
    OccludedFaces::find(scene.light, &casters(scene), options, |_, _| ControlFlow::Continue(())).expect("found")
}

pub(crate) fn casters(scene: &StaticScene) -> Vec<OcclusionCaster<'_>> {
    let casters = scene.casters.iter();
    casters.map(|caster| OcclusionCaster { mesh: &caster.mesh, positions: &caster.positions, version: None }).collect()
}

/// Asks for each occluded face whether points in it are occluded by faces that stay and that cast in any case.
fn check(scene: &StaticScene, occluded: &[Vec<u32>], random: &mut Random) -> Result<usize, String> {
    check_some(scene, occluded, random, usize::MAX)
}

/// The same of so many occluded faces at random.
pub(crate) fn check_some(
    scene: &StaticScene,
    occluded: &[Vec<u32>],
    random: &mut Random,
    most: usize,
) -> Result<usize, String> {
    let from = light(scene.light);
    let (mut hiders, mut occluded_faces): (Vec<[Point; 3]>, Vec<_>) = Default::default();
    for (number, caster) in scene.casters.iter().enumerate() {
        for (face, &[a, b, c]) in (0_u32..).zip(caster.mesh.faces()) {
            let corners = [a, b, c].map(|vertex| corner(caster.positions[vertex as usize]));
            let [a, b, c] = &corners;
            let side = sign([a, b, c, &from]);
            if occluded[number].contains(&face) {
                occluded_faces.push((number, face, corners));
            } else if side != 0 && !(caster.mesh.is_closed() && faces_light(caster, face as usize, scene.light)) {
                hiders.push(corners);
            }
        }
    }
    let all = occluded_faces.len();
    if most < all {
        occluded_faces = (0..most).map(|_| occluded_faces[random.below(all)].clone()).collect();
    }
    for (number, face, corners) in &occluded_faces {
        let mut weights = vec![[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [1, 1, 0], [0, 1, 1], [1, 0, 1]];
        weights.extend((0..5).map(|_| [(); 3].map(|()| 1 + random.below(1 << 20) as u32)));
        for weights in weights {
            let point = between(corners, weights);
            if !hiders.iter().any(|hider| hides(hider, &from, &point)) {
                return Err(format!("caster {number}, face {face}: the point {weights:?} is not occluded"));
            }
        }
    }
    Ok(all)
}

/// By the measure's oracle, whose sign convention is that of facing.
pub(crate) fn faces_light(caster: &Caster, face: usize, light: Light) -> bool {
    rimline_testkit::oracle::ExactFace::new(&caster.positions, caster.mesh.faces()[face])
        .is_some_and(|face| face.sign(light) > 0)
}

pub(crate) fn lists(scene: &StaticScene, found: &OccludedFaces) -> Vec<Vec<u32>> {
    (0..scene.casters.len()).map(|number| found.faces(number).to_vec()).collect()
}

#[test]
fn occluded_faces_are_occluded_in_random_scenes() {
    let (mut all, mut scenes, mut refuted, mut bounded) = (0, 0, 0, 0);
    for seed in 5000..5400 {
        let scene = StaticScene::random(seed);
        let mut random = Random::new(seed);
        let all_of_them = OcclusionOptions { leave_out_all: true, ..OcclusionOptions::default() };
        let found = find(&scene, all_of_them);
        let lists = lists(&scene, &found);
        let count = check(&scene, &lists, &mut random).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        assert_eq!(count, found.statistics().occluded, "seed {seed}");
        all += count;
        scenes += usize::from(count > 0);
        // Small bounds leave faces, and are right.
        let options = OcclusionOptions { max_nodes: random.below(40), max_steps: random.below(30), ..all_of_them };
        let less = find(&scene, options);
        let of_less = self::lists(&scene, &less);
        check(&scene, &of_less, &mut random).unwrap_or_else(|error| panic!("seed {seed}, {options:?}: {error}"));
        let statistics = less.statistics();
        assert!(statistics.nodes <= options.max_nodes, "seed {seed}: {statistics:?}");
        bounded += usize::from(statistics.undecided + statistics.without_room > 0);
        // A face that stays is added: then the comparison must fail, as a rule.
        let mut wrong = lists;
        let number = random.below(wrong.len());
        let face = random.below(scene.casters[number].mesh.faces().len()) as u32;
        if !wrong[number].contains(&face) {
            wrong[number].push(face);
            refuted += usize::from(check(&scene, &wrong, &mut random).is_err());
        }
    }
    println!("{all} occluded faces in {scenes} scenes; {bounded} searches met a bound; {refuted} wrong faces refuted");
    assert!(all > 2000 && scenes > 200 && bounded > 100 && refuted > 100, "{all} {scenes} {bounded} {refuted}");
}

fn wall_before(bodies: &[shapes::Shape], at: f32) -> StaticScene {
    let wall = vec![[-40.0, -40.0, at], [40.0, -40.0, at], [0.0, 60.0, at]];
    let of = |positions: Vec<[f32; 3]>, faces: &[[u32; 3]]| Caster {
        mesh: Mesh::new(&positions, faces, Weld::Position).expect("a mesh"),
        positions,
    };
    let mut casters = vec![of(wall, &[[0, 1, 2]])];
    casters.extend(bodies.iter().map(|body| of(body.positions.clone(), &body.faces)));
    StaticScene { casters, light: Light::point([0.0, 0.0, 10.0]) }
}

#[test]
fn all_behind_a_wall_is_occluded_and_nothing_before_it() {
    let bodies = [shapes::sphere(4), shapes::torus(9, 7, 2.0, 0.5), shapes::cube()];
    let behind = wall_before(&bodies, 5.0);
    let found = find(&behind, OcclusionOptions::default());
    for (number, body) in bodies.iter().enumerate() {
        assert_eq!(found.faces(number + 1).len(), body.faces.len(), "body {number}");
    }
    assert!(found.faces(0).is_empty());
    // The wall is behind the bodies, and no body covers it.
    let before = wall_before(&bodies[..1], -5.0);
    let found = find(&before, OcclusionOptions::default());
    assert!(found.faces(0).is_empty());
    // The front faces of a single sphere are before its other faces, so no face is occluded.
    assert!(found.faces(1).is_empty());
}

#[test]
fn two_faces_that_share_an_edge_hide_what_straddles_it() {
    let quad = vec![[-9.0, -9.0, 5.0], [9.0, -9.0, 5.0], [9.0, 9.0, 5.0], [-9.0, 9.0, 5.0]];
    let mesh =
        |positions: &[[f32; 3]], faces: &[[u32; 3]]| Mesh::new(positions, faces, Weld::Position).expect("a mesh");
    let small = vec![[-1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0]];
    let casters = vec![
        Caster { mesh: mesh(&quad, &[[0, 1, 2], [0, 2, 3]]), positions: quad },
        Caster { mesh: mesh(&small, &[[0, 1, 2]]), positions: small },
    ];
    let scene = StaticScene { casters, light: Light::point([0.25, 0.0, 10.0]) };
    let found = find(&scene, OcclusionOptions::default());
    assert_eq!(lists(&scene, &found), [vec![], vec![0]]);
}

#[test]
fn one_of_two_casters_at_one_position_stays() {
    let mut scene = wall_before(&[], 5.0);
    let again = Caster { mesh: scene.casters[0].mesh.clone(), positions: scene.casters[0].positions.clone() };
    scene.casters.push(again);
    let found = find(&scene, OcclusionOptions::default());
    assert_eq!(found.statistics().occluded, 1);
}

#[test]
fn searches_can_be_cancelled_and_say_what_is_wrong() {
    let scene = wall_before(&[shapes::sphere(16)], 5.0);
    let (options, mut calls) = (OcclusionOptions { threads: Threads::ONE, ..OcclusionOptions::default() }, Vec::new());
    let ended = OccludedFaces::find(scene.light, &casters(&scene), options, |done, all| {
        calls.push((done, all));
        if done == 0 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    assert_eq!(ended, Err(CpuError::Cancelled));
    assert_eq!(calls.iter().map(|call| call.0).collect::<Vec<_>>(), [0, 256]);
    let several = OcclusionOptions { threads: Threads::new(3), ..options };
    let ended = OccludedFaces::find(scene.light, &casters(&scene), several, |_, _| ControlFlow::Break(()));
    assert_eq!(ended, Err(CpuError::Cancelled));
    let go_on = |_, _| ControlFlow::Continue(());
    let caster = &scene.casters[1];
    let short = [OcclusionCaster { mesh: &caster.mesh, positions: &caster.positions[1..], version: None }];
    let (given, needed) = (caster.positions.len() - 1, caster.mesh.vertex_count());
    let error = OccludedFaces::find(scene.light, &short, options, go_on);
    assert_eq!(error, Err(CpuError::TooFewCasterPositions { caster: 0, given, needed }));
    let error = OccludedFaces::find(Light::homogeneous([1.0, 0.0, 0.0, -1.0]), &[], options, go_on);
    assert_eq!(error, Err(CpuError::Light(LightError::NegativeWeight { index: 0, w: -1.0 })));
    // Points that are none take no part.
    let mut holed = caster.positions.clone();
    holed[0] = [f32::NAN; 3];
    let holed = [OcclusionCaster { mesh: &caster.mesh, positions: &holed, version: None }];
    let found = OccludedFaces::find(scene.light, &holed, options, go_on).expect("found");
    assert!(found.statistics().tried < caster.mesh.faces().len());
}

#[test]
fn faces_edge_on_to_the_light_are_occluded_only_where_others_hide_them() {
    let of = |positions: Vec<[f32; 3]>, faces: &[[u32; 3]]| Caster {
        mesh: Mesh::new(&positions, faces, Weld::Position).expect("a mesh"),
        positions,
    };
    let roof = |x: f32, y: f32| {
        let positions = vec![[-x, -y, 5.0], [x, -y, 5.0], [x, y, 5.0], [-x, y, 5.0]];
        of(positions, &[[0, 1, 2], [0, 2, 3]])
    };
    let cube = || of(shapes::cube().positions, &shapes::cube().faces);
    // The light is in the planes of the cube's four walls.
    let light = Light::directional([0.0, 0.0, 1.0]);
    let scene = StaticScene { casters: vec![roof(2.0, 2.0), cube()], light };
    let found = find(&scene, OcclusionOptions::default());
    assert_eq!(found.faces(1).len(), 12);
    assert_eq!([found.statistics().sides, found.statistics().sides_left], [8, 4]);
    // An edge of each of these is in the plane of a wall, and hides a part of it.
    let blade = vec![[1.0, -0.5, 5.0], [-3.0, 0.0, 5.0], [1.0, 0.5, 5.0]];
    let mut hiders = vec![roof(1.0, 0.5), roof(0.5, 1.0)];
    hiders.extend([[0, 1, 2], [1, 2, 0], [2, 0, 1]].map(|face| of(blade.clone(), &[face])));
    for (number, hider) in hiders.into_iter().enumerate() {
        let scene = StaticScene { casters: vec![hider, cube()], light };
        let found = find(&scene, OcclusionOptions { leave_out_all: true, ..OcclusionOptions::default() });
        let occluded = lists(&scene, &found);
        let count = check(&scene, &occluded, &mut Random::new(9)).unwrap_or_else(|error| panic!("{number}: {error}"));
        assert!(count < 4, "{number}: {occluded:?}");
    }
}
