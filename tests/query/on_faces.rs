//! Points that name the face that they are on: that face does not count for them, and all else is as before.

use rimline::internals::cpu::{self, CpuError, Threads};
use rimline::mesh::NO_FACE;
use rimline::{Light, Mesh};
use rimline_testkit::random::Random;
use rimline_testkit::shadow_cases::{ShadowCase, centre, put_on_faces, shadow_cases};
use rimline_testkit::shapes::{self, Shape};
use rimline_testkit::{is_long, must_fail, same, shadow_oracle};

fn depths(shape: &Shape, points: &[[f32; 3]], on_face: Option<&[u32]>, lights: &[Light]) -> Vec<i32> {
    let mesh = Mesh::from_faces(shape.positions.len(), shape.faces.clone()).expect("a mesh");
    cpu::shadow_depth_on_faces(&shape.positions, &mesh, points, on_face, lights, Threads::all()).expect("good lights")
}

/// A light in the zenith lights the faces of the upper half, although rounding moves their centres. Points that are lifted
/// off their faces have the same results.
#[test]
fn half_of_a_sphere_is_lit() {
    let shape = shapes::globe(48, 24);
    let corners = |face: &[u32; 3]| face.map(|vertex| shape.positions[vertex as usize]);
    let points: Vec<[f32; 3]> = shape.faces.iter().map(|face| centre(corners(face))).collect();
    let zenith = Light::directional([0.0, 0.0, 1.0]);
    let named_faces: Vec<u32> = (0..points.len() as u32).collect();
    let lit = |found: &[i32]| found.iter().filter(|&&depth| depth == 0).count();
    let named = depths(&shape, &points, Some(&named_faces), &[zenith]);
    assert_eq!((points.len(), lit(&named)), (2208, 1104));
    assert!(named.iter().zip(&points).all(|(&depth, point)| depth == i32::from(point[2] < 0.0)), "the upper half");
    let lifted: Vec<_> = points.iter().map(|&point| zenith.lift(point, 1e-4)).collect();
    assert_eq!(depths(&shape, &lifted, None, &[zenith]), named);
    let plain = lit(&depths(&shape, &points, None, &[zenith]));
    println!("{plain} lit without");
    assert!(plain < 1000, "negative control: {plain} lit");
    assert_eq!(
        depths(&shape, &points, Some(&vec![NO_FACE; 2208]), &[zenith]),
        depths(&shape, &points, None, &[zenith])
    );
    let others: Vec<u32> = named_faces.iter().map(|face| (face + 1104) % 2208).collect();
    assert!(lit(&depths(&shape, &points, Some(&others), &[zenith])) < 1104, "other faces");
}

#[test]
fn depths_are_those_of_brute_force_without_the_face() -> Result<(), String> {
    let first = 161;
    println!("seeds from {first}");
    let (mut queries, mut changed) = (0, 0);
    for seed in first..first + if is_long() { 6 } else { 1 } {
        let mut random = Random::new(seed);
        for case in shadow_cases(&mut random, 24, 6) {
            let ShadowCase { name, shape, mut points, lights } = case;
            let few = Shape { faces: shape.faces.iter().copied().take(400).collect(), ..shape };
            let on_face = put_on_faces(&mut random, &few.positions, &few.faces, &mut points);
            let plain = shadow_oracle::shadow_depth(&few.positions, &few.faces, &points, &lights);
            let mut right = plain.clone();
            for ((depths, point), &face) in right.chunks_mut(lights.len()).zip(&points).zip(&on_face) {
                let face = few.faces.get(face as usize).into_iter().copied().collect::<Vec<_>>();
                let of_face = shadow_oracle::shadow_depth(&few.positions, &face, &[*point], &lights);
                depths.iter_mut().zip(of_face).for_each(|(depth, of_face)| *depth -= of_face.max(0));
            }
            let found = depths(&few, &points, Some(&on_face), &lights);
            same(&format!("{name}, seed {seed}"), &found, &right)?;
            queries += found.len();
            if right != plain {
                changed += 1;
                must_fail("no face named", &same(&name, &depths(&few, &points, None, &lights), &right))?;
            }
        }
    }
    println!("{queries} queries, {changed} cases where faces matter");
    if changed > 10 { Ok(()) } else { Err(format!("only {changed} cases where faces matter")) }
}

#[test]
fn faces_that_are_not_there_are_refused() {
    let shape = shapes::globe(4, 2);
    let mesh = Mesh::from_faces(shape.positions.len(), shape.faces.clone()).expect("a mesh");
    let light = [Light::directional([0.0, 0.0, 1.0])];
    let with = |points: &[[f32; 3]], faces: &[u32]| {
        cpu::shadow_depth_on_faces(&shape.positions, &mesh, points, Some(faces), &light, Threads::ONE)
    };
    assert_eq!(with(&[[0.0; 3]; 2], &[7, NO_FACE]), Ok(vec![1, 1]));
    assert_eq!(
        with(&[[0.0; 3]; 2], &[NO_FACE, 8]),
        Err(CpuError::NoSuchFace { point: 1, face: 8, faces: 8 }),
        "a face behind the last"
    );
    for given in [0, 1, 3] {
        let error = CpuError::FaceForEachPoint { given, points: 2 };
        assert_eq!(with(&[[0.0; 3]; 2], &vec![0; given]), Err(error));
    }
    assert_eq!(with(&[], &[]), Ok(Vec::new()));
}
