//! The CPU reference of occluder counts: against brute force, and what must hold of any such count. A face that a point
//! names does not count for it.

use rimline::internals::cpu::{self, CpuError, Threads};
use rimline::mesh::NO_FACE;
use rimline::{Light, LightError, Mesh};
use rimline_testkit::random::Random;
use rimline_testkit::shadow_cases::{ShadowCase, centre, lattice, put_on_faces, shadow_cases};
use rimline_testkit::shapes::{self, Shape};
use rimline_testkit::{is_long, must_fail, same, shadow_oracle};

type Outcome = Result<(), String>;

fn depths(shape: &Shape, points: &[[f32; 3]], on_face: Option<&[u32]>, lights: &[Light]) -> Vec<i32> {
    let mesh = Mesh::from_faces(shape.positions.len(), shape.faces.clone()).expect("a mesh");
    cpu::shadow_depth_on_faces(&shape.positions, &mesh, points, on_face, lights, Threads::all()).expect("good lights")
}

#[test]
fn refused_arguments() {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh = Mesh::from_faces(3, vec![[0, 1, 2]]).expect("a mesh");
    let with = |positions: &[[f32; 3]], points: &[[f32; 3]], faces: Option<&[u32]>, lights: &[Light]| {
        cpu::shadow_depth_on_faces(positions, &mesh, points, faces, lights, Threads::ONE)
    };
    let refused = |lights: &[Light]| match with(&corners, &[[0.0; 3]], None, lights) {
        Err(CpuError::Light(error)) => error,
        found => panic!("a bad light: {found:?}"),
    };
    let good = Light::point([1.0, 2.0, 3.0]);
    assert_eq!(refused(&[good, Light::homogeneous([0.0; 4])]), LightError::Zero { index: 1 });
    let negative = refused(&[good, good, Light::homogeneous([1.0, 1.0, 1.0, -2.0])]);
    assert_eq!(negative, LightError::NegativeWeight { index: 2, w: -2.0 });
    assert!(matches!(refused(&[Light::point([f32::NAN; 3])]), LightError::NotFinite { index: 0, .. }));
    assert!(matches!(refused(&vec![good; 1025]), LightError::TooMany { count: 1025, .. }));
    let two = [[0.0; 3]; 2];
    for lights in [&[good][..], &[]] {
        for given in 0..3 {
            let few = CpuError::TooFewPositions { given, needed: 3 };
            assert_eq!(with(&corners[..given], &two, None, lights), Err(few), "{} lights", lights.len());
        }
    }
    let no_such = CpuError::NoSuchFace { point: 1, face: 1, faces: 1 };
    assert_eq!(with(&corners, &two, Some(&[NO_FACE, 1]), &[good]), Err(no_such), "a face behind the last");
    for given in [0, 1, 3] {
        let error = CpuError::FaceForEachPoint { given, points: 2 };
        assert_eq!(with(&corners, &two, Some(&vec![0; given]), &[good]), Err(error));
    }
    assert_eq!(
        with(&[corners, corners].concat(), &two, Some(&[0, NO_FACE]), &[good]),
        Ok(vec![0, 0]),
        "more positions"
    );
    assert_eq!(with(&corners, &two, None, &[]), Ok(Vec::new()), "no light");
    assert_eq!(with(&corners, &[], Some(&[]), &[good]), Ok(Vec::new()), "no point");
}

/// Half of the points lie on faces, and most name one.
#[test]
fn depths_are_those_of_brute_force() -> Outcome {
    let first = 161;
    println!("seeds from {first}");
    let (mut queries, mut deepest, mut changed) = (0, 0, 0);
    for seed in first..first + if is_long() { 6 } else { 1 } {
        let mut random = Random::new(seed);
        for ShadowCase { name, shape, mut points, lights } in shadow_cases(&mut random, 24, 6) {
            // The whole of a larger mesh is brute force's limit; some of its faces are a mesh, too.
            let few = Shape { faces: shape.faces.iter().copied().take(500).collect(), ..shape };
            let on_face = put_on_faces(&mut random, &few.positions, &few.faces, &mut points);
            let plain = shadow_oracle::shadow_depth(&few.positions, &few.faces, &points, &lights);
            let mut right = plain.clone();
            for ((depths, point), &face) in right.chunks_mut(lights.len()).zip(&points).zip(&on_face) {
                let face = few.faces.get(face as usize).into_iter().copied().collect::<Vec<_>>();
                let of_face = shadow_oracle::shadow_depth(&few.positions, &face, &[*point], &lights);
                depths.iter_mut().zip(of_face).for_each(|(depth, of_face)| *depth -= of_face.max(0));
            }
            let found = depths(&few, &points, None, &lights);
            same(&format!("{name}, seed {seed}"), &found, &plain)?;
            same(&format!("{name}, seed {seed}, on faces"), &depths(&few, &points, Some(&on_face), &lights), &right)?;
            // The order of faces, vertices and corners changes nothing, and faces that are there twice count twice.
            if name != "not finite" {
                let mut other = few.shuffled(seed);
                other.faces.iter_mut().step_by(2).for_each(|face| face.rotate_left(1));
                other.faces.iter_mut().step_by(3).for_each(|face| face.swap(0, 2));
                same(&format!("{name}, seed {seed}, shuffled"), &depths(&other, &points, None, &lights), &plain)?;
                other.faces.extend_from_within(..);
                let twice: Vec<i32> = plain.iter().map(|&depth| if depth < 0 { depth } else { 2 * depth }).collect();
                same(&format!("{name}, seed {seed}, twice"), &depths(&other, &points, None, &lights), &twice)?;
            }
            queries += 2 * found.len();
            deepest = deepest.max(found.iter().copied().max().unwrap_or(0));
            if right != plain {
                changed += 1;
                must_fail("no face named", &same(&name, &found, &right))?;
            }
        }
    }
    println!("{queries} queries, the deepest {deepest}, {changed} cases where faces matter");
    if deepest < 5 || changed <= 10 { Err("nothing was deep, or named faces do nothing".to_owned()) } else { Ok(()) }
}

/// A light in the zenith lights the faces of the upper half, although rounding moves their centres. Points that are lifted
/// off their faces have the same results.
#[test]
fn half_of_a_sphere_is_lit() {
    let shape = shapes::globe(48, 24);
    let corners = |face: &[u32; 3]| face.map(|vertex| shape.positions[vertex as usize]);
    let points: Vec<[f32; 3]> = shape.faces.iter().map(|face| centre(corners(face))).collect();
    let zenith = Light::directional([0.0, 0.0, 1.0]);
    let named: Vec<u32> = (0..points.len() as u32).collect();
    let lit = |found: &[i32]| found.iter().filter(|&&depth| depth == 0).count();
    let found = depths(&shape, &points, Some(&named), &[zenith]);
    assert_eq!((points.len(), lit(&found)), (2208, 1104));
    assert!(found.iter().zip(&points).all(|(&depth, point)| depth == i32::from(point[2] < 0.0)), "the upper half");
    let lifted: Vec<_> = points.iter().map(|&point| zenith.lift(point, 1e-4)).collect();
    assert_eq!(depths(&shape, &lifted, None, &[zenith]), found);
    let plain = depths(&shape, &points, None, &[zenith]);
    assert!(lit(&plain) < 1000, "negative control: {} lit", lit(&plain));
    assert_eq!(depths(&shape, &points, Some(&vec![NO_FACE; 2208]), &[zenith]), plain);
    let others: Vec<u32> = named.iter().map(|face| (face + 1104) % 2208).collect();
    assert!(lit(&depths(&shape, &points, Some(&others), &[zenith])) < 1104, "other faces");
}

/// Whole boxes, points and lights, where most segments tie. A box is convex, so that every count is known.
#[test]
fn ties_agree_with_topology() -> Outcome {
    let first = 71;
    println!("seeds from {first}");
    let mut seen = [0; 3];
    for seed in first..first + if is_long() { 400 } else { 20 } {
        let (case, corners) = lattice(&mut Random::new(seed), [1, 200, 20]);
        let [low, high] = corners[0];
        let strictly = |p: [f32; 3], w: f32| {
            // 1 inside, 0 on the surface, −1 outside.
            let axes = (0..3).map(|axis| {
                let (low, high) = (low[axis] as f32 * w, high[axis] as f32 * w);
                let inside = p[axis] > low && p[axis] < high;
                i32::from(inside) - i32::from(p[axis] < low || p[axis] > high)
            });
            axes.min().unwrap_or(0)
        };
        let found = depths(&case.shape, &case.points, None, &case.lights);
        for (query, depth) in found.iter().enumerate() {
            let (point, light) = (case.points[query / case.lights.len()], case.lights[query % case.lights.len()]);
            let light_side = if light.w == 0.0 { -1 } else { strictly(light.xyz, light.w) };
            let right = match [strictly(point, 1.0), light_side] {
                [1, 1] => *depth == 0,
                [1, -1] | [-1, 1] => *depth == 1,
                [-1, -1] => *depth == 0 || *depth == 2,
                _ => *depth <= 2,
            };
            if !right {
                return Err(format!("seed {seed}: {depth} from {point:?} to {light:?} for {low:?} … {high:?}"));
            }
            seen[*depth as usize] += 1;
        }
    }
    println!("depths 0, 1, 2: {seen:?}");
    if seen.iter().all(|&count| count > 1000) { Ok(()) } else { Err(format!("too few of a kind: {seen:?}")) }
}
