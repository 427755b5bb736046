//! Welding by distance against brute force: every pair compared in big integers, and sets joined one by one.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use num_bigint::BigInt;
use rimline::mesh::{PolygonLoops, Weld, WeldDistance};
use rimline::{Geometry, GeometryOptions, Influences, Mesh};
use rimline_testkit::random::Random;
use rimline_testkit::shadow_oracle::scaled;

/// A finite float in multiples of 2⁻¹⁴⁹.
fn integer(value: f32) -> BigInt {
    scaled(value, 149)
}

fn square_of_distance(a: [f32; 3], b: [f32; 3]) -> BigInt {
    let squares = (0..3).map(|axis| (integer(a[axis]) - integer(b[axis])).pow(2));
    squares.sum()
}

fn is_near(a: [f32; 3], b: [f32; 3], distance: f32) -> bool {
    let bits = |p: [f32; 3]| p.map(|c| if c == 0.0 { 0 } else { c.to_bits() });
    let are_finite = a.iter().chain(&b).all(|c| c.is_finite());
    if are_finite { square_of_distance(a, b) <= integer(distance).pow(2) } else { bits(a) == bits(b) }
}

/// For each vertex the vertex that its group takes. `may` says which pairs may be joined.
fn oracle(positions: &[[f32; 3]], distance: f32, may: impl Fn(usize, usize) -> bool) -> Vec<u32> {
    let mut set: Vec<usize> = (0..positions.len()).collect();
    for a in 0..positions.len() {
        for b in 0..a {
            if set[a] != set[b] && may(a, b) && is_near(positions[a], positions[b], distance) {
                let (from, to) = (set[a], set[b]);
                set.iter_mut().filter(|of| **of == from).for_each(|of| *of = to);
            }
        }
    }
    let before = |a: usize, b: usize| {
        let [p, q] = [positions[a], positions[b]];
        let numbers = p.partial_cmp(&q).unwrap_or(Ordering::Equal);
        let signs = p.map(f32::is_sign_positive).cmp(&q.map(f32::is_sign_positive));
        numbers.then(signs).then(a.cmp(&b)).is_lt()
    };
    let mut first: BTreeMap<usize, usize> = BTreeMap::new();
    for (v, &set) in set.iter().enumerate() {
        let of = first.entry(set).or_insert(v);
        if before(v, *of) {
            *of = v;
        }
    }
    set.iter().map(|set| first[set] as u32).collect()
}

fn by(distance: f32) -> WeldDistance {
    WeldDistance::new(distance).expect("a distance")
}

#[test]
fn what_is_no_distance_is_refused() {
    for bad in [-1.0, -f32::MIN_POSITIVE, f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert!(WeldDistance::new(bad).is_err(), "{bad}");
    }
    assert_eq!(WeldDistance::new(-0.0), WeldDistance::new(0.0));
}

/// The groups that a mesh makes, and how many are wide.
fn groups(positions: &[[f32; 3]], distance: f32) -> (Vec<u32>, usize) {
    let faces: Vec<[u32; 3]> = (0..positions.len() as u32).map(|v| [v; 3]).collect();
    let mesh = Mesh::new(positions, &faces, Weld::Distance(by(distance))).expect("a mesh");
    (mesh.faces().iter().map(|face| face[0]).collect(), mesh.weld_counts().wide)
}

fn wide(positions: &[[f32; 3]], groups: &[u32], distance: f32) -> usize {
    let mut boxes: BTreeMap<u32, [[f32; 3]; 2]> = BTreeMap::new();
    for (&group, &p) in groups.iter().zip(positions).filter(|(_, p)| p.iter().all(|c| c.is_finite())) {
        let [low, high] = boxes.entry(group).or_insert([p, p]);
        for axis in 0..3 {
            low[axis] = low[axis].min(p[axis]);
            high[axis] = high[axis].max(p[axis]);
        }
    }
    let limit: BigInt = (integer(distance) * 10_u32).pow(2);
    boxes.values().filter(|[low, high]| square_of_distance(*low, *high) > limit).count()
}

/// Clouds whose pairs are often exactly the distance apart or a float beside it, at any scale, with zeros of both signs.
fn cloud(random: &mut Random, seed: u64) -> (Vec<[f32; 3]>, f32) {
    let scale = [1.0, 2.0_f32.powi(-149), 2.0_f32.powi(-126), 2.0_f32.powi(120), 0.1, 2.0_f32.powi(-20)];
    let scale = scale[seed as usize % scale.len()];
    let side = [3.0, 8.0, 20.0, 60.0][random.below(4)];
    let distance = [0.0, 1.0, 2.0, 3.0, 5.0, 0.7, 7.0][random.below(7)] * scale;
    let chain_step = [1.0, 0.25][random.below(2)] * distance;
    let far = [0.0, 0.0, 1e4, 1e9][random.below(4)] * scale;
    let count = 2 + random.below(90);
    let mut positions = Vec::new();
    for _ in 0..count {
        let mut p = [(); 3].map(|()| (f64::from(random.between(0.0, side)).floor() as f32 - 1.0) * scale);
        if seed.is_multiple_of(5) {
            // A chain, which may be long.
            p = [positions.len() as f32 * chain_step, 0.0, 0.0];
        }
        match random.below(12) {
            0 => p = p.map(|c| -c),
            1 => p[random.below(3)] = -0.0,
            2 => p[0] = p[0].next_up(),
            3 => p[1] = p[1].next_down(),
            4 => p[2] += far,
            5 => p[random.below(3)] = [f32::INFINITY, f32::NAN, f32::NEG_INFINITY][random.below(3)],
            6 => p[0] = [f32::MAX, -f32::MAX, f32::MAX.next_down()][random.below(3)],
            // A least step beside a distance, which only integers see.
            7 => p[1 + random.below(2)] = f32::from_bits(1),
            _ => {}
        }
        positions.push(p);
    }
    (positions, distance)
}

#[test]
fn groups_are_the_components_of_near_pairs() {
    let (mut joined, mut wide_groups) = (0, 0);
    for seed in 0..if cfg!(debug_assertions) { 300 } else { 3000 } {
        let mut random = Random::new(seed);
        let (positions, distance) = cloud(&mut random, seed);
        let (found, found_wide) = groups(&positions, distance);
        let right = oracle(&positions, distance, |_, _| true);
        assert_eq!(found, right, "seed {seed}, distance {distance}");
        assert_eq!(found_wide, wide(&positions, &right, distance), "seed {seed}, distance {distance}");
        joined += (0..right.len()).filter(|&v| right[v] as usize != v).count();
        wide_groups += found_wide;
    }
    assert!(joined > 3000 && wide_groups > 5, "{joined} joined, {wide_groups} wide: too few to tell");
}

/// More vertices than are compared one by one, in cells that are near each other and not.
#[test]
fn crowded_cells_are_kept_apart() {
    let mut counts = [0, 0];
    for seed in 0..40 {
        let mut random = Random::new(500 + seed);
        let gap = random.between(0.5, 1.3);
        let tilt = random.between(-0.4, 0.4);
        let positions: Vec<[f32; 3]> = (0..240)
            .map(|v| {
                let [x, y, z] = [(); 3].map(|()| random.between(0.0, 0.3));
                let z = 0.1 * z + tilt * x;
                if v % 2 == 0 { [x, y, z] } else { [x + gap * tilt * 0.1, y, z + gap] }
            })
            .collect();
        let (found, _) = groups(&positions, 1.0);
        assert_eq!(found, oracle(&positions, 1.0, |_, _| true), "seed {seed}");
        counts[usize::from(found[0] == found[1])] += 1;
    }
    assert!(counts.iter().all(|&count| count > 4), "apart and together: {counts:?}");
}

/// A pair is joined only where both follow the same bone and offset, unless it is asked for.
#[test]
fn data_keeps_vertices_apart_unless_it_is_said_otherwise() {
    let (mut apart, mut collapsed) = (0, 0);
    for seed in 0..80 {
        let mut random = Random::new(1300 + seed);
        let (positions, distance) = cloud(&mut random, 0);
        let count = positions.len();
        let joints: Vec<u32> = positions.iter().map(|_| random.below(2) as u32).collect();
        let offsets: Vec<[f32; 3]> = positions.iter().map(|_| [random.below(2) as f32, 0.0, 0.0]).collect();
        let influences = Influences::new((0..=count as u32).collect(), joints.clone(), vec![1.0; count]);
        let faces: Vec<[u32; 3]> = (0..60).map(|_| [(); 3].map(|()| random.below(count) as u32)).collect();
        let options = GeometryOptions {
            influences: Some(influences.expect("good influences")),
            morph_targets: vec![offsets.clone()],
            ..GeometryOptions::default()
        };
        let geometry = Geometry::new(positions.clone(), faces.clone(), options).expect("a geometry");
        let all = oracle(&positions, distance, |_, _| true);
        let by_data = oracle(&positions, distance, |a, b| joints[a] == joints[b] && offsets[a] == offsets[b]);
        let kept = |groups: &[u32]| (0..count as u32).filter(|&v| groups[v as usize] == v).collect::<Vec<_>>();
        for (weld, groups) in [(by(distance), &by_data), (by(distance).across_data(), &all)] {
            let (welded, counts) = geometry.welded(Weld::Distance(weld));
            let kept_here = kept(groups);
            assert_eq!(welded.source_vertices(), kept_here, "seed {seed}");
            let bits = |p: [f32; 3]| p.map(f32::to_bits);
            assert!(
                welded.positions().iter().zip(&kept_here).all(|(&p, &v)| bits(p) == bits(positions[v as usize])),
                "seed {seed}: a group takes its vertex's position"
            );
            let new = |v: u32| kept_here.binary_search(&groups[v as usize]).expect("a kept vertex") as u32;
            assert_eq!(welded.faces(), faces.iter().map(|face| face.map(new)).collect::<Vec<_>>(), "seed {seed}");
            let bones: Vec<u32> = kept_here.iter().map(|&v| joints[v as usize]).collect();
            assert_eq!(welded.influences().expect("bones").joints(), bones, "seed {seed}");
            let is_degenerate = |[a, b, c]: [u32; 3]| a == b || b == c || c == a;
            let fell = faces.iter().filter(|&&face| !is_degenerate(face) && is_degenerate(face.map(new))).count();
            let expected = (fell, kept_here.len(), kept_here.len() - kept(&all).len());
            assert_eq!((counts.collapsed, counts.after, counts.apart), expected, "seed {seed}");
            (apart, collapsed) = (apart + counts.apart, collapsed + counts.collapsed);
        }
    }
    assert!(apart > 100 && collapsed > 100, "{apart} apart, {collapsed} collapsed: too few to tell");
}

#[test]
fn a_polygon_may_collapse() {
    let positions = [
        [0.0; 3],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.001, 0.0, 0.0],
        [1.001, 1.0, 0.0],
        [2.0, 0.5, 0.0],
    ];
    let polygons = PolygonLoops {
        polygon_loops: &[1, 1, 1],
        loop_sizes: &[4, 4, 3],
        loop_corners: &[0, 1, 2, 3, 1, 4, 5, 2, 4, 6, 5],
    };
    // Cut into triangles, the first polygon has a diagonal, too.
    let makers = [Mesh::from_polygons_by_loop, Mesh::from_polygons];
    for (make, consistent) in makers.into_iter().zip([1, 2]) {
        let mesh = make(&positions, polygons, Weld::Distance(by(0.01))).expect("a mesh");
        assert_eq!((mesh.weld_counts().collapsed, mesh.degenerate_faces(), mesh.weld_counts().after), (1, 1, 5));
        assert_eq!(mesh.edges().counts().consistent, consistent, "the sliver between the others is gone");
    }
}

/// Two sheets across each other, a little more than the distance apart, whose points are so near each other that no box
/// tells them apart: each point of one is nearly the distance from each of the other.
fn sheets(count: usize) -> Vec<[f32; 3]> {
    let mut random = Random::new(7);
    let side = 3e-3 * (count as f32 / 1e5).sqrt().min(1.0);
    (0..count)
        .map(|v| {
            let [x, y] = [(); 2].map(|()| random.between(0.0, side));
            let rough = random.between(0.0, 1e-5);
            // Across (2, 3, 6) / 7.
            let [a, b] = [[3.0, -2.0, 0.0], [6.0, 0.0, -2.0]];
            let up = if v % 2 == 0 { -rough } else { 1.000_001 + rough };
            let normal = [2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0];
            [0, 1, 2].map(|axis| a[axis] * x * 0.2 + b[axis] * y * 0.1 + normal[axis] * up)
        })
        .collect()
}

/// With every pair compared these take minutes.
#[test]
fn hostile_clouds_weld_in_time() {
    let count = 200_000;
    let mut random = Random::new(11);
    let ball: Vec<[f32; 3]> = (0..count)
        .map(|v| {
            let d = random.direction();
            if v % 2 == 0 { d.map(|c| c * 1.02) } else { d.map(|c| c * 0.019 * random.between(0.0, 1.0)) }
        })
        .collect();
    let circle: Vec<[f32; 3]> = (0..count)
        .map(|v| {
            let turn = random.between(0.0, std::f32::consts::TAU);
            if v % 2 == 0 {
                [1.000_001 * turn.cos(), 1.000_001 * turn.sin(), 0.0]
            } else {
                [0.0, 0.0, 1e-3 * (turn - 3.0)]
            }
        })
        .collect();
    // All pairs of a point of the centre and one of the circle are less than 2⁻⁴⁶ more than the distance apart.
    let square = |c: f32| f64::from(c).powi(2);
    let centre: Vec<[f32; 3]> = (0..count as u32)
        .map(|v| {
            if v % 2 == 0 {
                return [v % 128, v / 128 % 128, v / 16_384].map(f32::from_bits);
            }
            let x = random.between(0.83, 0.99);
            let y = (1.0 - square(x)).sqrt() as f32;
            let y = if square(x) + square(y) < 1.0 { y } else { y.next_down() };
            let rest = 1.0 - square(x) - square(y);
            let z = rest.sqrt() as f32;
            [x, y, if square(z) > rest { z } else { z.next_up() }]
        })
        .collect();
    // Black fields of a board, and white ones at the distance from it.
    let board: Vec<[f32; 3]> = (0..40_000_u32)
        .map(|v| {
            let [y, z] = [v % 200, v / 200];
            let step = 2.0_f32.powi(-30);
            [((y + z) % 2) as f32, y as f32 * step, z as f32 * step]
        })
        .collect();
    let same = vec![[1.0, 2.0, 3.0]; count];
    let line: Vec<[f32; 3]> = (0..count).map(|v| [v as f32, 0.0, 0.0]).collect();
    for (name, cloud, distance, most) in [
        ("sheets", sheets(count), 1.0, 2),
        ("a ball in a sphere", ball, 1.0, count),
        ("a circle about a line", circle, 1.0, count),
        ("a circle about its centre", centre, 1.0, 2),
        ("a board", board, 1.0, 2),
        ("one position", same, 1e-3, 1),
        ("a chain of ties", line.clone(), 1.0, 1),
        ("a chain just apart", line, 1.0_f32.next_down(), count),
    ] {
        let (groups, _) = groups(&cloud, distance);
        let kept = groups.iter().enumerate().filter(|&(v, &group)| v == group as usize).count();
        let least = match name {
            "a chain just apart" => count,
            "a circle about its centre" | "a board" => 2,
            _ => 1,
        };
        assert!((least..=most).contains(&kept), "{name}: {kept} groups");
    }
}
