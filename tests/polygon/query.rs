//! Shadow depths of polygons on the CPU: each polygon counts once where an odd number of its triangles lie between.

use rimline::Mesh;
use rimline::internals::cpu::{self, Threads};
use rimline_testkit::random::Random;
use rimline_testkit::shadow_cases::put_on_faces;
use rimline_testkit::{is_long, must_fail, same, shadow_oracle};

use crate::depths::DepthCase;

#[test]
fn a_polygon_counts_once_where_an_odd_number_of_its_triangles_lie_between() -> Result<(), String> {
    let first = 231_000;
    let count = if is_long() { 2000 } else { 40 };
    println!("seeds from {first}");
    let (mut queries, mut folds, mut deepest) = (0, 0, 0);
    for seed in first..first + count {
        let case = DepthCase::random(&mut Random::new(seed));
        let DepthCase { set, mesh, points, lights } = &case;
        // Every edge of its polygons is walked both ways.
        if mesh.faces().is_empty() {
            continue;
        }
        let mut expected = vec![0; points.len() * lights.len()];
        let polygons = mesh.polygons();
        let ranges = match polygons {
            Some(polygons) => (0..polygons.len()).map(|polygon| polygons.triangles(polygon)).collect(),
            None => (0..mesh.faces().len()).map(|face| face..face + 1).collect::<Vec<_>>(),
        };
        for range in ranges {
            let of_one = shadow_oracle::shadow_depth(&set.positions, &mesh.faces()[range], points, lights);
            expected.iter_mut().zip(of_one).for_each(|(sum, depth)| *sum += depth.rem_euclid(2));
        }
        let found = cpu::shadow_depth(&set.positions, mesh, points, lights, Threads::all())
            .map_err(|error| error.to_string())?;
        same(&format!("seed {seed}"), &found, &expected)?;
        queries += found.len();
        deepest = deepest.max(found.iter().copied().max().unwrap_or(0));
        // Triangles that are no polygons count each for itself.
        let triangles =
            Mesh::from_faces(set.positions.len(), mesh.faces().to_vec()).map_err(|error| error.to_string())?;
        let each = cpu::shadow_depth(&set.positions, &triangles, points, lights, Threads::all())
            .map_err(|error| error.to_string())?;
        if each != expected {
            folds += 1;
            must_fail("triangles", &same("triangles", &each, &expected))?;
        }
    }
    println!("{queries} depths, the deepest {deepest}; {folds} sets where triangles count otherwise");
    if folds * 2 > count && deepest > 3 { Ok(()) } else { Err("too few folds".to_owned()) }
}

/// The triangle that a point names does not count, and the others of its polygon do.
#[test]
fn the_triangle_that_a_point_is_on_does_not_count() -> Result<(), String> {
    let first = 235_000;
    let count = if is_long() { 600 } else { 16 };
    println!("seeds from {first}");
    let (mut changed, mut by_polygon) = (0, 0);
    for seed in first..first + count {
        let mut random = Random::new(seed);
        let DepthCase { set, mesh, mut points, lights } = DepthCase::random(&mut random);
        let Some(polygons) = mesh.polygons().filter(|_| !mesh.faces().is_empty()) else { continue };
        let on_face = put_on_faces(&mut random, &set.positions, mesh.faces(), &mut points);
        let mut expected = vec![0; points.len() * lights.len()];
        let mut without_polygon = expected.clone();
        for range in (0..polygons.len()).map(|polygon| polygons.triangles(polygon)) {
            for (at, (point, &face)) in points.iter().zip(&on_face).enumerate() {
                let is_of_polygon = range.contains(&(face as usize));
                let others: Vec<_> =
                    range.clone().filter(|&other| other != face as usize).map(|other| mesh.faces()[other]).collect();
                let of_one = shadow_oracle::shadow_depth(&set.positions, &others, &[*point], &lights);
                for (light, depth) in of_one.into_iter().enumerate() {
                    expected[at * lights.len() + light] += depth.rem_euclid(2);
                    without_polygon[at * lights.len() + light] += if is_of_polygon { 0 } else { depth.rem_euclid(2) };
                }
            }
        }
        let found = cpu::shadow_depth_on_faces(&set.positions, &mesh, &points, Some(&on_face), &lights, Threads::all())
            .map_err(|error| error.to_string())?;
        same(&format!("seed {seed}"), &found, &expected)?;
        let plain = cpu::shadow_depth(&set.positions, &mesh, &points, &lights, Threads::all())
            .map_err(|error| error.to_string())?;
        if plain != expected {
            changed += 1;
            must_fail("no face named", &same("no face named", &plain, &expected))?;
        }
        by_polygon += usize::from(without_polygon != expected);
    }
    println!("{changed} sets where the triangle matters, {by_polygon} where the rest of its polygon does");
    if changed > 5 && by_polygon > 5 { Ok(()) } else { Err("too few sets where it matters".to_owned()) }
}
