//! Occluded faces are occluded, point by point; and what must be found is found.

use std::ops::ControlFlow;

use rimline::cpu::{CpuError, OccludedFaces, OcclusionCaster, OcclusionOptions, Threads};
use rimline::{Light, LightError};
use rimline_testkit::oracle::ExactFace;
use rimline_testkit::random::Random;
use rimline_testkit::shapes::{self, Shape};

use crate::oracle::{Point, between, corner, light, occludes, sign};
use crate::static_scenes::{Caster, StaticScene};

pub(crate) fn all_left_out() -> OcclusionOptions {
    OcclusionOptions { leave_out_all: true, ..OcclusionOptions::default() }
}

pub(crate) fn find(scene: &StaticScene, options: OcclusionOptions) -> OccludedFaces {
    OccludedFaces::find(scene.light, &casters(scene), options, |_, _| ControlFlow::Continue(())).expect("found")
}

pub(crate) fn casters(scene: &StaticScene) -> Vec<OcclusionCaster<'_>> {
    let casters = scene.casters.iter();
    casters.map(|caster| OcclusionCaster { mesh: &caster.mesh, positions: &caster.positions, version: None }).collect()
}

pub(crate) fn lists(scene: &StaticScene, found: &OccludedFaces) -> Vec<Vec<u32>> {
    (0..scene.casters.len()).map(|number| found.faces(number).to_vec()).collect()
}

/// Whether a triangle faces the light, by an oracle with the sign convention of facing.
pub(crate) fn faces_light(caster: &Caster, triangle: usize, light: Light) -> bool {
    ExactFace::new(&caster.positions, caster.mesh.faces()[triangle]).is_some_and(|face| face.sign(light) > 0)
}

/// The triangles of a face, and whether all their corners lie in one plane. A mesh of nothing but triangles has no
/// polygons.
pub(crate) fn triangles(caster: &Caster, face: usize) -> (std::ops::Range<usize>, bool) {
    let Some(polygons) = caster.mesh.polygons() else { return (face..face + 1, true) };
    let range = polygons.triangles(face);
    let all: Vec<[Point; 3]> = range.clone().map(|triangle| corners(caster, triangle)).collect();
    let is_planar = |[a, b, c]: &[Point; 3]| all.iter().flatten().all(|point| sign([a, b, c, point]) == 0);
    let is_planar = all.first().is_none_or(is_planar);
    (range, is_planar)
}

fn corners(caster: &Caster, triangle: usize) -> [Point; 3] {
    caster.mesh.faces()[triangle].map(|vertex| corner(caster.positions[vertex as usize]))
}

/// Asks for each occluded face, or for `most` triangles of them at random, whether points in it are occluded by planar
/// faces that stay and that cast in any case. Returns how many faces are occluded.
pub(crate) fn check(
    scene: &StaticScene,
    occluded: &[Vec<u32>],
    random: &mut Random,
    most: usize,
) -> Result<usize, String> {
    let from = light(scene.light);
    let (mut occluders, mut asked) = (Vec::new(), Vec::new());
    for (number, caster) in scene.casters.iter().enumerate() {
        for face in 0..caster.mesh.face_count() {
            let is_occluded = occluded[number].contains(&(face as u32));
            let (range, is_planar) = triangles(caster, face);
            if is_occluded && !is_planar {
                return Err(format!("caster {number}, face {face} is occluded and not planar"));
            }
            for triangle in range {
                if is_occluded {
                    asked.push((number, face, corners(caster, triangle)));
                } else if is_planar && !(caster.mesh.is_closed() && faces_light(caster, triangle, scene.light)) {
                    occluders.push(corners(caster, triangle));
                }
            }
        }
    }
    if most < asked.len() {
        asked = (0..most).map(|_| asked[random.below(asked.len())].clone()).collect();
    }
    for (number, face, corners) in &asked {
        let mut weights = vec![[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [1, 1, 0], [0, 1, 1], [1, 0, 1]];
        weights.extend((0..5).map(|_| [(); 3].map(|()| 1 + random.below(1 << 20) as u32)));
        for weights in weights {
            let point = between(corners, weights);
            if !occluders.iter().any(|occluder| occludes(occluder, &from, &point)) {
                return Err(format!("caster {number}, face {face}: the point {weights:?} is not occluded"));
            }
        }
    }
    Ok(occluded.iter().map(Vec::len).sum())
}

/// Checks what is found, and that a face that stays is refuted as a rule. Returns how many are occluded, and whether it was.
pub(crate) fn check_found(
    scene: &StaticScene,
    found: &OccludedFaces,
    random: &mut Random,
) -> Result<[usize; 2], String> {
    let mut lists = lists(scene, found);
    let count = check(scene, &lists, random, usize::MAX)?;
    assert_eq!(count, found.statistics().occluded);
    let number = random.below(lists.len());
    let face = random.below(scene.casters[number].mesh.face_count()) as u32;
    if lists[number].contains(&face) {
        return Ok([count, 0]);
    }
    lists[number].push(face);
    Ok([count, usize::from(check(scene, &lists, random, usize::MAX).is_err())])
}

#[test]
fn occluded_faces_are_occluded_in_random_scenes() {
    let (mut all, mut scenes, mut refuted, mut bounded) = (0, 0, 0, 0);
    for seed in 5000..5400 {
        let (scene, mut random) = (StaticScene::random(seed), Random::new(seed));
        let [count, is_refuted] = check_found(&scene, &find(&scene, all_left_out()), &mut random)
            .unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        (all, scenes, refuted) = (all + count, scenes + usize::from(count > 0), refuted + is_refuted);
        // Small bounds leave faces, and are right.
        let options = OcclusionOptions { max_nodes: random.below(40), max_steps: random.below(30), ..all_left_out() };
        let less = find(&scene, options);
        check(&scene, &lists(&scene, &less), &mut random, usize::MAX)
            .unwrap_or_else(|error| panic!("seed {seed}, {options:?}: {error}"));
        let statistics = less.statistics();
        assert!(statistics.nodes <= options.max_nodes, "seed {seed}: {statistics:?}");
        bounded += usize::from(statistics.undecided + statistics.without_room > 0);
    }
    println!("{all} occluded faces in {scenes} scenes; {bounded} searches met a bound; {refuted} wrong faces refuted");
    assert!(all > 2000 && scenes > 200 && bounded > 100 && refuted > 100, "{all} {scenes} {bounded} {refuted}");
}

/// A wall across the axis at this height.
fn wall(at: f32) -> Caster {
    let positions = vec![[-40.0, -40.0, at], [40.0, -40.0, at], [0.0, 60.0, at]];
    Caster::new(Shape { positions, faces: vec![[0, 1, 2]] })
}

fn roof(x: f32, y: f32) -> Caster {
    let positions = vec![[-x, -y, 5.0], [x, -y, 5.0], [x, y, 5.0], [-x, y, 5.0]];
    Caster::new(Shape { positions, faces: vec![[0, 1, 2], [0, 2, 3]] })
}

const LAMP: Light = Light::point([0.25, 0.0, 10.0]);

#[test]
fn faces_behind_walls_are_found_and_none_before_them() {
    let bodies = || [shapes::sphere(4), shapes::torus(9, 7, 2.0, 0.5), shapes::cube()].map(Caster::new);
    let small = Shape { positions: vec![[-1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0]], faces: vec![[0, 1, 2]] };
    let [sphere, torus, cube] = bodies().map(|body| body.mesh.faces().len());
    for (what, casters, expected) in [
        ("all behind a wall", [wall(5.0)].into_iter().chain(bodies()).collect(), vec![0, sphere, torus, cube]),
        ("a sphere before a wall", vec![wall(-5.0), Caster::new(shapes::sphere(4))], vec![0, 0]),
        ("a face across the edge of two", vec![roof(9.0, 9.0), Caster::new(small)], vec![0, 1]),
    ] {
        let scene = StaticScene { casters, light: LAMP };
        let found = find(&scene, OcclusionOptions::default());
        assert_eq!(lists(&scene, &found).iter().map(Vec::len).collect::<Vec<_>>(), expected, "{what}");
    }
    // One of two casters at one position stays.
    let scene = StaticScene { casters: vec![wall(5.0), wall(5.0)], light: LAMP };
    assert_eq!(find(&scene, OcclusionOptions::default()).statistics().occluded, 1);
}

#[test]
fn faces_that_the_tree_has_no_room_for_are_counted() {
    let scene = StaticScene { casters: vec![wall(5.0), wall(-5.0)], light: LAMP };
    // A wall takes three nodes.
    for (max_nodes, expected) in [(3, [3, 1, 0]), (2, [0, 0, 2]), (0, [0, 0, 2])] {
        let found = find(&scene, OcclusionOptions { max_nodes, ..OcclusionOptions::default() }).statistics();
        assert_eq!([found.nodes, found.occluded, found.without_room], expected, "{max_nodes} nodes");
    }
}

#[test]
fn faces_edge_on_to_the_light_are_occluded_only_where_others_occlude_them() {
    // The light is in the planes of the cube's four walls.
    let under = |occluder| StaticScene {
        casters: vec![occluder, Caster::new(shapes::cube())],
        light: Light::directional([0.0, 0.0, 1.0]),
    };
    let found = find(&under(roof(2.0, 2.0)), OcclusionOptions::default());
    assert_eq!(found.faces(1).len(), 12);
    assert_eq!([found.statistics().sides, found.statistics().sides_left], [8, 4]);
    // An edge of each of these is in the plane of a wall, and occludes a part of it.
    let positions = vec![[1.0, -0.5, 5.0], [-3.0, 0.0, 5.0], [1.0, 0.5, 5.0]];
    let blade = |face| Caster::new(Shape { positions: positions.clone(), faces: vec![face] });
    let blades = [[0, 1, 2], [1, 2, 0], [2, 0, 1]].map(blade);
    for occluder in [roof(1.0, 0.5), roof(0.5, 1.0)].into_iter().chain(blades) {
        let scene = under(occluder);
        let occluded = lists(&scene, &find(&scene, all_left_out()));
        let count = check(&scene, &occluded, &mut Random::new(9), usize::MAX).unwrap_or_else(|error| panic!("{error}"));
        assert!(count < 4, "{occluded:?}");
    }
}

#[test]
fn searches_can_be_cancelled_and_say_what_is_wrong() {
    let scene = StaticScene { casters: vec![wall(5.0), Caster::new(shapes::sphere(16))], light: LAMP };
    let (options, mut calls) = (OcclusionOptions { threads: Threads::ONE, ..OcclusionOptions::default() }, Vec::new());
    let ended = OccludedFaces::find(LAMP, &casters(&scene), options, |done, _| {
        calls.push(done);
        if done == 0 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    assert_eq!((ended, calls), (Err(CpuError::Cancelled), vec![0, 256]));
    let several = OcclusionOptions { threads: Threads::new(3), ..options };
    let ended = OccludedFaces::find(LAMP, &casters(&scene), several, |_, _| ControlFlow::Break(()));
    assert_eq!(ended, Err(CpuError::Cancelled));
    let go_on = |_, _| ControlFlow::Continue(());
    let Caster { mesh, positions } = &scene.casters[1];
    let short = [OcclusionCaster { mesh, positions: &positions[1..], version: None }];
    let (given, needed) = (positions.len() - 1, mesh.vertex_count());
    let error = OccludedFaces::find(LAMP, &short, options, go_on);
    assert_eq!(error, Err(CpuError::TooFewCasterPositions { caster: 0, given, needed }));
    let error = OccludedFaces::find(Light::homogeneous([1.0, 0.0, 0.0, -1.0]), &[], options, go_on);
    assert_eq!(error, Err(CpuError::Light(LightError::NegativeWeight { index: 0, w: -1.0 })));
    // Points that are none take no part.
    let mut holed = positions.clone();
    holed[0] = [f32::NAN; 3];
    let holed = [OcclusionCaster { mesh, positions: &holed, version: None }];
    let found = OccludedFaces::find(LAMP, &holed, options, go_on).expect("found");
    assert!(found.statistics().tried < mesh.faces().len());
}
