//! Occluder counts of polygons on the CPU: each polygon counts once where an odd number of its triangles lie between.

use rimline::Mesh;
use rimline::internals::cpu::{self, Threads};
use rimline::mesh::NO_FACE;
use rimline_testkit::random::Random;
use rimline_testkit::shadow_cases::put_on_faces;
use rimline_testkit::{is_long, same, shadow_oracle};

use crate::depths::DepthCase;

/// Sums over ranges of faces of the parity of those between, but for the one that a point names.
fn expected(case: &DepthCase, ranges: &[std::ops::Range<usize>], on_face: &[u32]) -> Vec<i32> {
    let DepthCase { set, mesh, points, lights } = case;
    let mut sums = vec![0; points.len() * lights.len()];
    for range in ranges {
        let mut add = |points: &[[f32; 3]], first: usize, left_out: u32| {
            let others = range.clone().filter(|&face| face != left_out as usize).map(|face| mesh.faces()[face]);
            let depths = shadow_oracle::shadow_depth(&set.positions, &others.collect::<Vec<_>>(), points, lights);
            let sums = sums[first * lights.len()..].iter_mut();
            sums.zip(depths).for_each(|(sum, depth)| *sum += depth.rem_euclid(2));
        };
        if on_face.iter().all(|&face| face == NO_FACE) {
            add(points, 0, NO_FACE);
        } else {
            points.iter().zip(on_face).enumerate().for_each(|(at, (point, &face))| add(&[*point], at, face));
        }
    }
    sums
}

/// The triangle that a point names does not count, and the others of its polygon do.
#[test]
fn a_polygon_counts_once_where_an_odd_number_of_its_triangles_lie_between() -> Result<(), String> {
    let first = 231_000;
    let count = if is_long() { 2000 } else { 40 };
    println!("seeds from {first}");
    let (mut folds, mut deepest, mut changed) = (0_u64, 0, 0_u64);
    for seed in first..first + count {
        let mut random = Random::new(seed);
        let mut case = DepthCase::random(&mut random);
        // Every edge of its polygons is walked both ways.
        if case.mesh.faces().is_empty() {
            continue;
        }
        let mesh = case.mesh.clone();
        let ranges: Vec<_> = match mesh.polygons() {
            Some(polygons) => (0..polygons.len()).map(|polygon| polygons.triangles(polygon)).collect(),
            None => (0..mesh.faces().len()).map(|face| face..face + 1).collect(),
        };
        let check = |case: &DepthCase, on_face: &[u32], expected: &[i32]| {
            let DepthCase { set, mesh, points, lights } = case;
            let found = cpu::shadow_depth_on_faces(&set.positions, mesh, points, Some(on_face), lights, Threads::all());
            same(&format!("seed {seed}"), &found.map_err(|error| error.to_string())?, expected)
        };
        let mut on_face = vec![NO_FACE; case.points.len()];
        let plain = expected(&case, &ranges, &on_face);
        check(&case, &on_face, &plain)?;
        deepest = deepest.max(plain.iter().copied().max().unwrap_or(0));
        // Triangles that are no polygons count each for itself.
        case.mesh =
            Mesh::from_faces(case.set.positions.len(), mesh.faces().to_vec()).map_err(|error| error.to_string())?;
        folds += u64::from(check(&case, &on_face, &plain).is_err());
        case.mesh = mesh;
        // Fewer, since the oracle is asked anew for each point.
        if seed % 3 == 0 {
            let none = on_face;
            on_face = put_on_faces(&mut random, &case.set.positions, case.mesh.faces(), &mut case.points);
            let named = expected(&case, &ranges, &on_face);
            check(&case, &on_face, &named)?;
            changed += u64::from(check(&case, &none, &named).is_err());
        }
    }
    println!(
        "the deepest {deepest}; {folds} sets where triangles count otherwise, {changed} where the named one matters"
    );
    // Negative controls.
    if folds * 2 > count && deepest > 3 && changed > 5 { Ok(()) } else { Err("too few".to_owned()) }
}
