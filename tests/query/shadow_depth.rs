//! The CPU reference of occluder counts: against brute force, and what must hold of any such count.

use rimline::internals::cpu::{self, CpuError, Threads};
use rimline::{Light, LightError, Mesh};
use rimline_testkit::random::Random;
use rimline_testkit::shadow_cases::{ShadowCase, lattice, shadow_cases};
use rimline_testkit::shapes::Shape;
use rimline_testkit::{is_long, must_fail, same, shadow_oracle};

type Outcome = Result<(), String>;

fn depths(shape: &Shape, points: &[[f32; 3]], lights: &[Light]) -> Vec<i32> {
    let mesh = Mesh::from_faces(shape.positions.len(), shape.faces.clone()).expect("a mesh");
    cpu::shadow_depth(&shape.positions, &mesh, points, lights, Threads::all()).expect("good lights")
}

fn case_depths(case: &ShadowCase) -> Vec<i32> {
    depths(&case.shape, &case.points, &case.lights)
}

#[test]
fn refused_arguments() {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh = Mesh::from_faces(3, vec![[0, 1, 2]]).expect("a mesh");
    let with = |positions: &[[f32; 3]], lights: &[Light]| {
        cpu::shadow_depth(positions, &mesh, &[[0.0; 3]], lights, Threads::ONE)
    };
    let refused = |lights: &[Light]| match with(&corners, lights) {
        Err(CpuError::Light(error)) => error,
        found => panic!("a bad light: {found:?}"),
    };
    let good = Light::point([1.0, 2.0, 3.0]);
    assert_eq!(refused(&[good, Light::homogeneous([0.0; 4])]), LightError::Zero { index: 1 });
    let negative = refused(&[good, good, Light::homogeneous([1.0, 1.0, 1.0, -2.0])]);
    assert_eq!(negative, LightError::NegativeWeight { index: 2, w: -2.0 });
    assert!(matches!(refused(&[Light::point([f32::NAN; 3])]), LightError::NotFinite { index: 0, .. }));
    assert!(matches!(refused(&vec![good; 1025]), LightError::TooMany { count: 1025, .. }));
    for given in 0..3 {
        let few = CpuError::TooFewPositions { given, needed: 3 };
        assert_eq!(with(&corners[..given], &[good]), Err(few));
        assert_eq!(with(&corners[..given], &[]), Err(few), "without lights, too");
    }
    assert_eq!(with(&[corners, corners].concat(), &[good]), Ok(vec![0]), "more than needed");
    assert_eq!(with(&corners, &[]), Ok(Vec::new()), "no light");
    assert_eq!(cpu::shadow_depth(&corners, &mesh, &[], &[good], Threads::ONE), Ok(Vec::new()), "no point");
}

#[test]
fn depths_are_those_of_brute_force() -> Outcome {
    let first = 61;
    println!("seeds from {first}");
    let (mut queries, mut deepest) = (0, 0);
    let (rounds, counts) = if is_long() { (4, [24, 8]) } else { (1, [12, 6]) };
    for seed in first..first + rounds {
        let mut random = Random::new(seed);
        for case in shadow_cases(&mut random, counts[0], counts[1]) {
            let ShadowCase { name, shape, points, lights } = &case;
            // The whole of a larger mesh is brute force's limit; some of its faces are a mesh, too.
            let few = Shape { faces: shape.faces.iter().copied().take(600).collect(), ..shape.clone() };
            let mut found = depths(&few, points, lights);
            let right = shadow_oracle::shadow_depth(&few.positions, &few.faces, points, lights);
            same(&format!("{name}, seed {seed}"), &found, &right)?;
            queries += found.len();
            deepest = deepest.max(found.iter().copied().max().unwrap_or(0));
            let middle = found.len() / 2;
            found[middle] += 1;
            must_fail("one more", &same(name, &found, &right))?;
        }
    }
    println!("{queries} queries, the deepest {deepest}");
    if deepest < 5 { Err("nothing was deep".to_owned()) } else { Ok(()) }
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
        let found = case_depths(&case);
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

#[test]
fn the_order_of_faces_vertices_and_corners_changes_nothing() -> Outcome {
    let mut random = Random::new(91);
    let mut cases = vec![lattice(&mut random, [6, 100, 12]).0];
    cases.extend(shadow_cases(&mut random, 30, 6).into_iter().filter(|case| case.name != "not finite"));
    for case in cases {
        let expected = case_depths(&case);
        let shuffled = case.shape.shuffled(random.next_u64());
        same(&format!("{}, shuffled", case.name), &depths(&shuffled, &case.points, &case.lights), &expected)?;
        let turned = case.shape.faces.iter().map(|&[a, b, c]| match random.below(4) {
            0 => [b, c, a],
            1 => [c, a, b],
            2 => [c, b, a],
            _ => [a, b, c],
        });
        let turned = Shape { positions: case.shape.positions.clone(), faces: turned.collect() };
        same(&format!("{}, turned", case.name), &depths(&turned, &case.points, &case.lights), &expected)?;
        let twice = [case.shape.faces.clone(), case.shape.faces.clone()].concat();
        let twice = Shape { positions: case.shape.positions.clone(), faces: twice };
        let doubled: Vec<i32> = expected.iter().map(|&depth| if depth < 0 { depth } else { 2 * depth }).collect();
        same(&format!("{}, twice", case.name), &depths(&twice, &case.points, &case.lights), &doubled)?;
        let mut first_gone = case.shape.clone();
        first_gone.faces.drain(..case.shape.faces.len() / 2);
        if expected.iter().sum::<i32>() > 0 {
            let outcome = same(&case.name, &depths(&first_gone, &case.points, &case.lights), &expected);
            must_fail("half of the faces gone", &outcome)?;
        }
    }
    Ok(())
}
