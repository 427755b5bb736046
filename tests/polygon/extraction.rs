//! Extraction of polygon meshes: masks against sums over faces, and against triangles where polygons are planar.

use std::collections::BTreeMap;

use rimline::internals::cpu::{self, Boundary, EdgeMasks, Extraction, Orientation, PolygonMasks, Threads};
use rimline::mesh::{EdgeKind, Weld};
use rimline::{Light, Mesh, Predicate};
use rimline_testkit::must_fail;
use rimline_testkit::polygons::{PolygonSet, quad_box, quad_torus, random_polygon};
use rimline_testkit::random::Random;

use crate::lights::lights_for;

type Outcome = Result<(), String>;

fn extracted(set: &PolygonSet, mesh: &Mesh, lights: &[Light]) -> Extraction {
    cpu::extract(&set.positions, mesh, lights, Predicate::Exact, Threads::ONE).expect("good lights")
}

/// A row a polygon of masks that have one a triangle.
fn of_polygons(mesh: &Mesh, masks: &[u32]) -> Vec<u32> {
    let polygons = mesh.polygons().expect("polygons");
    if mesh.faces().is_empty() {
        // No polygon has bits, in none of the planes of these tests.
        return vec![0; 3 * polygons.len()];
    }
    masks.chunks(mesh.faces().len()).flat_map(|plane| polygons.masks_of(plane)).collect()
}

fn bit(masks: &[u32], count: usize, item: usize, light: usize) -> bool {
    masks[light / 32 * count + item] >> (light % 32) & 1 != 0
}

/// For each pair of vertices, the lower one first, a sum over the edges between them, counted upwards.
type Sums = BTreeMap<[u32; 2], i64>;

fn add(sums: &mut Sums, [a, b]: [u32; 2], value: i64) {
    *sums.entry([a.min(b), a.max(b)]).or_default() += if a < b { value } else { -value };
}

/// Sums over the edges of faces: 1 for each face that faces the light, −1 for each other, 0 for a twisted one.
fn sums_of_faces(mesh: &Mesh, facing: &[u32], twisted: &[u32], light: usize) -> Sums {
    let polygons = mesh.polygons().expect("polygons");
    let mut sums = Sums::new();
    for polygon in 0..polygons.len() {
        let is_set = |masks: &[u32]| bit(masks, polygons.len(), polygon, light);
        let side = match (is_set(facing), is_set(twisted)) {
            (_, true) => 0,
            (true, _) => 1,
            (false, _) => -1,
        };
        polygons.boundary(polygon).iter().for_each(|&edge| add(&mut sums, edge, side));
    }
    sums
}

/// The same from silhouette and winding masks. A record with two faces that count has twice the weight.
fn sums_of_records(mesh: &Mesh, masks: &[EdgeMasks], twisted: &[u32], light: usize) -> Sums {
    let mut sums = Sums::new();
    let plane = &masks[light / 32 * mesh.edges().len()..][..mesh.edges().len()];
    for (edge, masks) in mesh.edges().iter().zip(plane) {
        let counts = |face: u32| i64::from(!bit(twisted, mesh.face_count(), face as usize, light));
        let weight = counts(edge.face_0) + edge.face_1.map_or(0, counts);
        let is_set = |mask: u32| mask >> (light % 32) & 1 != 0;
        let sign = if is_set(masks.winding) { 1 } else { -1 };
        add(&mut sums, edge.vertices, if is_set(masks.silhouette) { sign * weight } else { 0 });
    }
    sums
}

/// The number of edges that begin at a vertex equals the number that end there, by their multiplicities.
fn is_closed(sums: &Sums) -> bool {
    let mut balance = BTreeMap::<u32, i64>::new();
    for (&[a, b], count) in sums {
        *balance.entry(a).or_default() += count;
        *balance.entry(b).or_default() -= count;
    }
    balance.values().all(|&sum| sum == 0)
}

fn check_edges(mesh: &Mesh, found: &Extraction, lights: usize) -> Outcome {
    let [facing, twisted] = [&found.facing, &found.twisted].map(|masks| of_polygons(mesh, masks));
    for light in 0..lights {
        let expected = sums_of_faces(mesh, &facing, &twisted, light);
        let sums = sums_of_records(mesh, &found.masks, &twisted, light);
        if sums != expected {
            return Err(format!("light {light}: {sums:?}, expected {expected:?}"));
        }
        if !is_closed(&sums) {
            return Err(format!("light {light}: an open loop"));
        }
    }
    Ok(())
}

/// Closed bodies of quadrilaterals that are not planar.
#[test]
fn bodies_of_nonplanar_quadrilaterals_close() -> Outcome {
    let mut twisted_pairs = 0;
    for seed in 0..24 {
        let mut random = Random::new(seed);
        let bump = [0.0, 0.01, 0.1, 0.3][random.below(4)];
        let set = quad_torus(&mut random, 12, 8, bump);
        let mesh = set.mesh(Weld::Position).map_err(|error| error.to_string())?;
        assert!(mesh.is_closed());
        let lights = lights_for(&mut random, &set.positions, 40);
        let mut found = extracted(&set, &mesh, &lights);
        check_edges(&mesh, &found, lights.len()).map_err(|error| format!("seed {seed}: {error}"))?;
        twisted_pairs += of_polygons(&mesh, &found.twisted).iter().map(|mask| mask.count_ones()).sum::<u32>();
        if let Some(mask) = found.twisted.iter_mut().find(|mask| **mask != 0 && bump > 0.0) {
            *mask &= *mask - 1;
            must_fail("a twisted polygon that counts", &check_edges(&mesh, &found, lights.len()))?;
        } else if let Some(masks) = found.masks.iter_mut().find(|masks| masks.silhouette != 0 && bump == 0.0) {
            masks.winding ^= masks.silhouette & masks.silhouette.wrapping_neg();
            must_fail("a winding bit", &check_edges(&mesh, &found, lights.len()))?;
        }
    }
    if twisted_pairs > 500 { Ok(()) } else { Err(format!("only {twisted_pairs} twisted")) }
}

/// Polygons over few vertices: edges of many faces, of one face on both sides, of either sense.
#[test]
fn soups_of_polygons_close() -> Outcome {
    let mut kinds = [0; 3];
    for seed in 0..150 {
        let mut random = Random::new(seed);
        let vertices = 5 + random.below(8);
        let mut set =
            PolygonSet { positions: (0..vertices).map(|_| random.direction()).collect(), ..Default::default() };
        for _ in 0..=random.below(12) {
            let corners = (0..3 + random.below(3)).map(|_| random.below(vertices) as u32);
            set.push(&[corners.collect()]);
        }
        let mesh = set.mesh(Weld::Position).map_err(|error| error.to_string())?;
        if mesh.polygons().is_none() {
            continue;
        }
        let lights = lights_for(&mut random, &set.positions, 33);
        let found = extracted(&set, &mesh, &lights);
        check_edges(&mesh, &found, lights.len()).map_err(|error| format!("seed {seed}: {error}"))?;
        mesh.edges().iter().for_each(|edge| kinds[edge.kind as usize] += 1);
    }
    assert!(kinds[EdgeKind::Inconsistent as usize] > 100 && kinds[EdgeKind::Consistent as usize] > 100, "{kinds:?}");
    Ok(())
}

/// Masks of many polygons and lights together equal the masks of each by itself.
#[test]
fn masks_are_those_of_each_boundary() -> Outcome {
    let mut seen = [0; 4];
    for seed in 0..60 {
        let mut random = Random::new(seed);
        let mut set = if seed % 3 == 0 { quad_torus(&mut random, 9, 7, 0.1) } else { PolygonSet::default() };
        (0..40).for_each(|_| set.append(&random_polygon(&mut random, 12).1));
        let mesh = set.mesh(Weld::Keep).map_err(|error| error.to_string())?;
        let count = [1, 2, 35][random.below(3)];
        let lights = lights_for(&mut random, &set.positions, count);
        let (masks, _) = polygon_masks(&set, &mesh, &lights);
        let polygons = mesh.polygons().ok_or("polygons")?;
        for (light, l) in lights.iter().enumerate() {
            for polygon in 0..polygons.len() {
                let boundary = Boundary::new(polygons.boundary(polygon), &set.positions).ok_or("finite")?;
                let masks = masks[light / 32 * polygons.len() + polygon];
                let found = [masks.facing, masks.twisted, masks.excluded].map(|mask| mask >> (light % 32) & 1 != 0);
                let right = boundary.orientation_by_pairs(l.to_array());
                seen[right as usize] += 1;
                let expected = match right {
                    Orientation::FrontFacing => [true, false, false],
                    Orientation::BackFacing => [false; 3],
                    // No boundary, no plane.
                    Orientation::InPlane => [false, false, !polygons.boundary(polygon).is_empty()],
                    Orientation::Twisted => [false, true, true],
                };
                if found != expected {
                    return Err(format!("seed {seed}, polygon {polygon}, {l:?}: {found:?}, but {right:?}"));
                }
            }
        }
    }
    if seen.iter().all(|&count| count > 200) { Ok(()) } else { Err(format!("too few of a kind: {seen:?}")) }
}

fn polygon_masks(set: &PolygonSet, mesh: &Mesh, lights: &[Light]) -> (Vec<PolygonMasks>, cpu::FacingStatistics) {
    cpu::polygon_facing(&set.positions, mesh.polygons().expect("polygons"), lights, Threads::ONE)
}

#[test]
fn polygons_that_are_not_finite_are_excluded() {
    let mut set = quad_box(1);
    set.positions[0][1] = f32::NAN;
    set.positions[23][2] = f32::INFINITY;
    let mesh = set.mesh(Weld::Keep).expect("a mesh");
    let lights = [Light::point([3.0, 4.0, 5.0]), Light::directional([1.0, 2.0, 3.0])];
    let (masks, statistics) = polygon_masks(&set, &mesh, &lights);
    assert_eq!(statistics.non_finite_faces, 2);
    for (polygon, masks) in masks.iter().enumerate() {
        let expected = if polygon == 0 || polygon == 5 { 0b11 } else { 0 };
        assert_eq!(
            (masks.excluded, masks.twisted, masks.facing & masks.excluded),
            (expected, 0, 0),
            "polygon {polygon}"
        );
    }
    let missing = cpu::polygon_facing(&[], mesh.polygons().expect("polygons"), &lights, Threads::ONE);
    assert_eq!(missing.1.non_finite_faces, 6);
}

#[test]
fn neither_threads_nor_earlier_memory_change_masks() {
    let mut random = Random::new(7);
    let set = quad_torus(&mut random, 96, 64, 0.02);
    let mesh = set.mesh(Weld::Keep).expect("a mesh");
    let lights = lights_for(&mut random, &set.positions, 34);
    let one = extracted(&set, &mesh, &lights);
    let mut again = one.clone();
    for threads in [2, 7] {
        again.update(&set.positions, &mesh, &lights, Predicate::Exact, Threads::new(threads)).expect("good lights");
        assert!(again == one, "{threads} threads");
    }
    // A mesh of triangles after it leaves no masks of polygons.
    let triangles = Mesh::from_faces(set.positions.len(), mesh.faces().to_vec()).expect("a mesh");
    again.update(&set.positions, &triangles, &lights, Predicate::Exact, Threads::ONE).expect("good lights");
    assert!(again.twisted.is_empty() && again.facing.len() == 2 * triangles.faces().len());
}
