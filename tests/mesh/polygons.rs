//! Polygons: their edge records and triangles, against sums of edges.

use std::collections::BTreeMap;

use rimline::Mesh;
use rimline::mesh::{Edge, EdgeKind, MeshError, PolygonLoops, Weld};
use rimline_testkit::polygons::{PolygonSet, random_polygon};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail};

type Outcome = Result<(), String>;

/// For each pair of vertices, the lower one first, how often edges run upwards less how often they run downwards.
type Chain = BTreeMap<[u32; 2], i64>;

fn add(chain: &mut Chain, a: u32, b: u32) {
    if a != b {
        let sum = chain.entry([a.min(b), a.max(b)]).or_default();
        *sum += if a < b { 1 } else { -1 };
        if *sum == 0 {
            chain.remove(&[a.min(b), a.max(b)]);
        }
    }
}

fn chain_of_loops<'a>(loops: impl IntoIterator<Item = &'a [u32]>) -> Chain {
    let mut chain = Chain::new();
    for corners in loops {
        for at in 0..corners.len() {
            add(&mut chain, corners[at], corners[(at + 1) % corners.len()]);
        }
    }
    chain
}

/// The triangles and the boundary of every polygon have the edges that the loops have.
fn check_boundaries(mesh: &Mesh, triangles: &[[u32; 3]]) -> Outcome {
    let Some(polygons) = mesh.polygons() else { return Ok(()) };
    let mut next = 0;
    for polygon in 0..polygons.len() {
        let expected = chain_of_loops(polygons.loops(polygon));
        let mut boundary = Chain::new();
        polygons.boundary(polygon).iter().for_each(|&[a, b]| add(&mut boundary, a, b));
        if boundary != expected {
            return Err(format!("boundary {boundary:?} of polygon {polygon}, expected {expected:?}"));
        }
        let sizes: i64 = expected.values().map(|count| count.abs()).sum();
        if polygons.boundary(polygon).len() as i64 != sizes {
            return Err(format!("the boundary of polygon {polygon} has edges that cancel"));
        }
        let range = polygons.triangles(polygon);
        if range.start != next {
            return Err(format!("triangles of polygon {polygon} begin at {}, expected {next}", range.start));
        }
        next = range.end;
        let triangles = &triangles[range];
        if let Some(face) = triangles.iter().find(|[a, b, c]| a == b || b == c || c == a) {
            return Err(format!("polygon {polygon} has the triangle {face:?}"));
        }
        let found = chain_of_loops(triangles.iter().map(<[u32; 3]>::as_slice));
        if found != expected {
            return Err(format!(
                "the triangles of polygon {polygon} have the boundary {found:?}, expected {expected:?}"
            ));
        }
    }
    if next == mesh.faces().len() { Ok(()) } else { Err("triangles are left over".to_owned()) }
}

#[test]
fn triangles_have_the_boundaries() -> Outcome {
    let count = if is_long() { 200_000 } else { 6_000 };
    let mut names = BTreeMap::<&str, usize>::new();
    for seed in 0..count {
        let mut random = Random::new(seed);
        let (name, mut set) = random_polygon(&mut random, 64);
        let mut name = name;
        if seed % 16 == 15 {
            let spoilt = random.below(set.positions.len());
            set.positions[spoilt] = [[f32::NAN; 3], [f32::INFINITY; 3], [f32::MAX; 3], [1e-45; 3]][random.below(4)];
            name = "spoilt";
        }
        let weld = if random.below(2) == 0 { Weld::Position } else { Weld::Keep };
        let mesh = set.mesh(weld).map_err(|error| format!("seed {seed}, {name}: {error}"))?;
        *names.entry(name).or_default() += 1;
        check_boundaries(&mesh, mesh.faces()).map_err(|error| format!("seed {seed}, {name}: {error}"))?;
        let mut turned = mesh.faces().to_vec();
        if mesh.polygons().is_some() && !turned.is_empty() {
            let at = random.below(turned.len());
            turned[at].swap(0, 1);
            must_fail("a turned triangle", &check_boundaries(&mesh, &turned))?;
        }
    }
    assert!(names.len() == 11 && names.values().all(|&count| count > 100), "{names:?}");
    Ok(())
}

/// Twice the area of a loop, as a vector.
fn normal(positions: &[[f32; 3]], corners: &[u32]) -> [f64; 3] {
    let at = |i: usize| positions[corners[i % corners.len()] as usize].map(f64::from);
    let mut sum = [0.0; 3];
    for i in 0..corners.len() {
        let (p, q) = (at(i), at(i + 1));
        for axis in 0..3 {
            sum[axis] += p[(axis + 1) % 3] * q[(axis + 2) % 3] - p[(axis + 2) % 3] * q[(axis + 1) % 3];
        }
    }
    sum
}

/// The triangles of a planar polygon cover it: their areas, all of one sign, add up to that of its loops.
fn covers(set: &PolygonSet, mesh: &Mesh, tolerance: f64) -> Outcome {
    let length = |n: [f64; 3]| n.iter().map(|c| c * c).sum::<f64>().sqrt();
    let mut whole = [0.0; 3];
    for corners in set.polygons().concat() {
        let of_loop = normal(&set.positions, &corners);
        whole = std::array::from_fn(|axis| whole[axis] + of_loop[axis]);
    }
    let parts: Vec<_> = mesh.faces().iter().map(|face| normal(&set.positions, face)).collect();
    let sum: f64 = parts.iter().map(|part| length(*part)).sum();
    let is_turned = |part: &[f64; 3]| (0..3).map(|axis| part[axis] * whole[axis]).sum::<f64>() < -1e-6;
    if (sum / length(whole) - 1.0).abs() < tolerance && !parts.iter().any(is_turned) {
        return Ok(());
    }
    Err(format!("{sum} of {}, or a triangle is turned over", length(whole)))
}

#[test]
fn triangles_of_planar_polygons_cover_them() -> Outcome {
    let mut checked = 0;
    for seed in 0..3_000 {
        let (name, set) = random_polygon(&mut Random::new(seed), 40);
        let mesh = set.mesh(Weld::Keep).expect("a mesh");
        if ["convex", "concave", "staircase"].contains(&name) && mesh.polygons().is_some() {
            checked += 1;
            covers(&set, &mesh, 1e-4).map_err(|error| format!("seed {seed}, {name}: {error}"))?;
        }
    }
    assert!(checked > 400, "{checked}");
    // A plate with square holes on a grid, which stay open.
    for seed in 0..200 {
        let mut random = Random::new(seed);
        let slope = random.below(5) as f32 - 2.0;
        let square = |x: f32, y: f32, size: f32| {
            [[0.0, 0.0], [size, 0.0], [size, size], [0.0, size]].map(|[u, v]| [x + u, y + v, slope * (x + u)]).to_vec()
        };
        let mut loops = vec![square(0.0, 0.0, 10.0)];
        for (x, y) in (0..3).flat_map(|x| (0..3).map(move |y| (x as f32, y as f32))) {
            if random.below(2) == 0 {
                let mut hole = square(3.0 * x + 1.0, 3.0 * y + 1.0, 1.0 + random.below(2) as f32);
                hole.reverse();
                loops.push(hole);
            }
        }
        if random.below(2) == 0 {
            for points in &mut loops {
                points.reverse();
            }
        }
        let mut set = PolygonSet::default();
        set.push_points(&loops);
        let mesh = set.mesh(Weld::Keep).expect("a mesh");
        covers(&set, &mesh, 1e-12).map_err(|error| format!("holes, seed {seed}: {error}"))?;
        let mut filled = PolygonSet::default();
        filled.push_points(&loops[..1]);
        if loops.len() > 1 {
            must_fail("holes that are filled", &covers(&set, &filled.mesh(Weld::Keep).expect("a mesh"), 1e-12))?;
        }
    }
    Ok(())
}

/// Records hold the edges of all boundaries, each with its face and sense, in the order of faces.
#[test]
fn records_hold_the_boundaries() -> Outcome {
    for seed in 0..3_000 {
        let mut random = Random::new(seed);
        let vertices = 4 + random.below(12);
        let mut set =
            PolygonSet { positions: (0..vertices).map(|_| random.direction()).collect(), ..Default::default() };
        for _ in 0..=random.below(8) {
            let loops: Vec<Vec<u32>> = (0..=random.below(2))
                .map(|_| (0..3 + random.below(5)).map(|_| random.below(vertices) as u32).collect())
                .collect();
            set.push(&loops);
        }
        let mesh = set.mesh(Weld::Position).map_err(|error| error.to_string())?;
        let Some(polygons) = mesh.polygons() else { continue };
        check_boundaries(&mesh, mesh.faces()).map_err(|error| format!("seed {seed}: {error}"))?;
        let boundary = |polygon: usize| polygons.boundary(polygon).iter().map(move |&edge| (polygon as u32, edge));
        let mut expected: Vec<_> = (0..polygons.len()).flat_map(boundary).collect();
        let mut found = Vec::new();
        for Edge { vertices: [a, b], face_0, face_1, kind } in mesh.edges().iter() {
            found.push((face_0, [a, b]));
            found.extend(face_1.map(|face| (face, if kind == EdgeKind::Consistent { [b, a] } else { [a, b] })));
            assert_eq!(kind == EdgeKind::Boundary, face_1.is_none(), "seed {seed}");
        }
        found.sort_unstable();
        expected.sort_unstable();
        assert_eq!(found, expected, "seed {seed}");
        assert!(mesh.edges().iter().is_sorted_by_key(|edge| edge.face_0), "seed {seed}");
        // Opposite ones are paired first: so many records are consistent.
        let mut senses = BTreeMap::<[u32; 2], [usize; 2]>::new();
        for (_, [a, b]) in expected {
            senses.entry([a.min(b), a.max(b)]).or_default()[usize::from(a > b)] += 1;
        }
        let pairs: usize = senses.values().map(|[up, down]| up.min(down)).sum();
        let single: usize = senses.values().map(|[up, down]| up.abs_diff(*down) % 2).sum();
        let counts = mesh.edges().counts();
        assert_eq!((counts.consistent, counts.boundary), (pairs, single), "seed {seed}");
    }
    Ok(())
}

#[test]
fn polygons_of_three_corners_are_triangles() {
    for seed in 0..200 {
        let mut random = Random::new(seed);
        let vertices = 3 + random.below(9);
        let positions: Vec<[f32; 3]> = (0..vertices).map(|_| random.direction().map(f32::round)).collect();
        let faces: Vec<[u32; 3]> =
            (0..=random.below(9)).map(|_| [(); 3].map(|()| random.below(vertices) as u32)).collect();
        let mut set = PolygonSet { positions: positions.clone(), ..Default::default() };
        for face in &faces {
            set.push(&[face.to_vec()]);
        }
        for weld in [Weld::Position, Weld::Keep] {
            assert_eq!(set.mesh(weld), Mesh::new(&positions, &faces, weld), "seed {seed}");
        }
        // With a quadrilateral beside them, the records between the triangles stay as they are.
        set.push_points(&[vec![[9.0; 3], [9.0, 8.0, 9.0], [8.0, 8.0, 9.0], [8.0, 9.0, 9.0]]]);
        let plain = Mesh::new(&positions, &faces, Weld::Position).expect("a mesh");
        let mixed = set.mesh(Weld::Position).expect("a mesh");
        assert_eq!(mixed.edges().len(), plain.edges().len() + 4, "seed {seed}");
        assert!(mixed.edges().iter().zip(plain.edges().iter()).all(|(one, other)| one == other), "seed {seed}");
        assert_eq!(mixed.degenerate_faces(), plain.degenerate_faces(), "seed {seed}");
    }
}

#[test]
fn what_is_wrong_is_named() {
    let positions = [[0.0; 3]; 4];
    let refused = |polygon_loops: &[u32], loop_sizes: &[u32], loop_corners: &[u32]| {
        let given = PolygonLoops { polygon_loops, loop_sizes, loop_corners };
        Mesh::from_polygons_by_loop(&positions, given, Weld::Keep).expect_err("a bad polygon")
    };
    assert_eq!(refused(&[1, 0], &[3], &[0, 1, 2]), MeshError::PolygonWithoutLoops { polygon: 1 });
    assert_eq!(
        refused(&[2], &[3, 2], &[0, 1, 2, 3, 0]),
        MeshError::LoopTooSmall { polygon: 0, loop_index: 1, corners: 2 }
    );
    assert_eq!(
        refused(&[1, 2], &[3, 3], &[0, 1, 2, 3, 0, 1]),
        MeshError::MissingLoops { polygon: 1, loop_index: 1, loops: 2 }
    );
    assert_eq!(
        refused(&[1, 1], &[3, 4], &[0, 1, 2, 3, 0, 1]),
        MeshError::MissingCorners { polygon: 1, loop_index: 0, corners: 6 }
    );
    assert_eq!(refused(&[1], &[3, 3], &[0, 1, 2, 0, 1, 2]), MeshError::LoopsLeftOver { loops: 1 });
    assert_eq!(refused(&[1], &[3], &[0, 1, 2, 0]), MeshError::CornersLeftOver { corners: 1 });
    let error = refused(&[1, 2], &[3, 3, 4], &[0, 1, 2, 3, 2, 1, 0, 1, 4, 2]);
    assert_eq!(error, MeshError::CornerOutOfRange { polygon: 1, loop_index: 1, corner: 2, index: 4, vertices: 4 });
    assert_eq!(error.to_string(), "corner 2 of loop 1 of polygon 1 names vertex 4, but there are 4 vertices");
    let size = (1 << 24) + 1;
    assert_eq!(refused(&[1], &[size], &vec![0; size as usize]), MeshError::PolygonTooLarge { polygon: 0 });
    // Sizes that would overflow a sum.
    assert!(matches!(refused(&[2], &[3, u32::MAX], &[0, 1, 2]), MeshError::PolygonTooLarge { polygon: 0 }));
}

/// The triangles of polygons are those of the mesh that takes polygons whole, each polygon with at least one.
#[test]
fn polygons_are_cut_into_the_triangles_that_are_drawn() -> Outcome {
    let count = if is_long() { 40_000 } else { 4_000 };
    for seed in 0..count {
        let mut random = Random::new(seed);
        let mut set = PolygonSet::default();
        for _ in 0..=random.below(3) {
            let (_, other) = random_polygon(&mut random, 24);
            let first = set.positions.len() as u32;
            set.positions.extend(&other.positions);
            let moved = |loops: Vec<Vec<u32>>| -> Vec<Vec<u32>> {
                loops.iter().map(|corners| corners.iter().map(|v| v + first).collect()).collect()
            };
            other.polygons().into_iter().for_each(|loops| set.push(&moved(loops)));
        }
        let weld = if random.below(2) == 0 { Weld::Position } else { Weld::Keep };
        let whole = set.mesh(weld).expect("a mesh");
        let cut = Mesh::from_polygons(&set.positions, set.loops(), weld).expect("a mesh");
        let (triangles, _) = set.loops().triangulate(&set.positions, weld).expect("triangles");
        if cut.faces() != triangles || cut.polygons().is_some() || cut.weld_counts() != whole.weld_counts() {
            return Err(format!("seed {seed}: {:?}, but the triangles are {triangles:?}", cut.faces()));
        }
        let is_drawn = |face: &&[u32; 3]| face[0] != face[1] && face[1] != face[2] && face[2] != face[0];
        let drawn = |mesh: &Mesh| mesh.faces().iter().filter(is_drawn).copied().collect::<Vec<_>>();
        // No two random polygons have the same corners, so lists of triangles compare directly.
        if drawn(&cut) != drawn(&whole) {
            return Err(format!("seed {seed}: {:?}, but taken whole {:?}", cut.faces(), whole.faces()));
        }
        let without = whole.polygons().map_or(0, |all| (0..all.len()).filter(|&p| all.triangles(p).is_empty()).count());
        if cut.face_count() != whole.faces().len() + without {
            return Err(format!("seed {seed}: {} faces, and {without} polygons without a surface", cut.face_count()));
        }
    }
    Ok(())
}

#[test]
fn both_sides_of_a_polygon_have_the_same_triangles() {
    // Not planar; cut by the one diagonal it is another surface than by the other.
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.3], [1.0, 1.0, 0.0], [0.0, 1.0, 0.3], [0.5, 0.5, 1.0]];
    let one_way = |face: &[u32; 3], is_turned: bool| {
        let [a, b, c] = *face;
        let [a, b, c] = if is_turned { [a, c, b] } else { [a, b, c] };
        [[a, b, c], [b, c, a], [c, a, b]].into_iter().min()
    };
    for (corners, is_turned) in
        [([3, 2, 1, 0], true), ([2, 1, 0, 3], true), ([1, 2, 3, 0], false), ([0, 1, 2, 3], false), ([0, 3, 2, 1], true)]
    {
        let mut set = PolygonSet { positions: positions.clone(), ..Default::default() };
        set.push(&[vec![0, 1, 2, 3]]);
        set.push(&[vec![0, 1, 4, 2]]);
        set.push(&[corners.to_vec()]);
        let mesh = Mesh::from_polygons(&set.positions, set.loops(), Weld::Keep).expect("a mesh");
        let faces = mesh.faces();
        assert_eq!(faces.len(), 6);
        for (one, other) in faces[..2].iter().zip(&faces[4..]) {
            assert_eq!(one_way(one, false), one_way(other, is_turned), "{corners:?}: {faces:?}");
        }
    }
}
