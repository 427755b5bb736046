//! How lights see boundaries: against winding numbers in big integers.

use std::collections::BTreeMap;

use rimline::Light;
use rimline::internals::cpu::{Boundary, Orientation, edge_pair, fits_half_space, polygon_turns};
use rimline::mesh::Weld;
use rimline_testkit::polygons::{PolygonSet, random_polygon};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, polygon_oracle};

use crate::lights::light_for;

type Outcome = Result<(), String>;

/// The boundary of the set's only polygon, as pairs of positions. `None` for a triangle.
fn placed(set: &PolygonSet) -> Option<(Boundary, Vec<[[f32; 3]; 2]>)> {
    let mesh = set.mesh(Weld::Position).expect("a mesh");
    let edges = mesh.polygons()?.boundary(0);
    let boundary = Boundary::new(edges, &set.positions).expect("finite corners");
    Some((boundary, edges.iter().map(|edge| edge.map(|v| set.positions[v as usize])).collect()))
}

/// The two agree. Only where the boundary touches itself in space may it be twisted and yet have a side.
fn compare(found: Orientation, right: polygon_oracle::Found) -> Outcome {
    if found == right.orientation
        || found == Orientation::Twisted && right.touches && right.orientation != Orientation::InPlane
    {
        Ok(())
    } else {
        Err(format!("{found:?}, but the oracle found {right:?}"))
    }
}

#[test]
fn boundaries_are_seen_as_their_winding_numbers_say() -> Outcome {
    let first = 101_000;
    let count = if is_long() { 60_000 } else { 1_000 };
    println!("seeds from {first}");
    let mut seen = BTreeMap::<String, usize>::new();
    let mut by_light = BTreeMap::<(&str, &str), usize>::new();
    let mut decided = 0;
    for seed in first..first + count {
        let mut random = Random::new(seed);
        // Large ones are the oracle's limit.
        let most = [6, 6, 12, 12, 12, 24, 24, 64][random.below(8)];
        let (name, set) = random_polygon(&mut random, most);
        let Some((boundary, edges)) = placed(&set) else { continue };
        for _ in 0..3 {
            let (of_light, light) = light_for(&mut random, &set.positions);
            if light.to_array() == [0.0; 4] {
                continue;
            }
            let (found, is_general) = boundary.decide(light.to_array());
            let right = polygon_oracle::find(&edges, light);
            let what = format!("seed {seed}, {name}, light {of_light}: {light:?}");
            compare(found, right).map_err(|error| format!("{what}: {error}, {edges:?}"))?;
            let by_pairs = boundary.orientation_by_pairs(light.to_array());
            compare(by_pairs, right).map_err(|error| format!("{what}, by pairs: {error}"))?;
            let by_close_pairs = boundary.orientation_by_close_pairs(light.to_array());
            if by_close_pairs.is_some_and(|found| found != by_pairs) {
                return Err(format!("{what}: by close pairs {by_close_pairs:?}, by all pairs {by_pairs:?}"));
            }
            decided += usize::from(by_close_pairs.is_some());
            *seen.entry(format!("{found:?}, {}", if is_general { "by pairs" } else { "cheap" })).or_default() += 1;
            *by_light.entry((of_light, if right.touches { "touches" } else { "clean" })).or_default() += 1;
            let other = match found {
                Orientation::FrontFacing => Orientation::BackFacing,
                Orientation::BackFacing => Orientation::InPlane,
                Orientation::InPlane => Orientation::Twisted,
                Orientation::Twisted => Orientation::FrontFacing,
            };
            if right.orientation != other {
                must_fail("another side", &compare(other, right))?;
            }
        }
    }
    println!("{seen:#?}\n{by_light:#?}\nclose pairs decide {decided}");
    let pairs: usize = seen.values().sum();
    let are_enough = 3 * decided >= 2 * pairs && seen.len() >= 6 && seen.values().all(|&count| count >= 12);
    if are_enough { Ok(()) } else { Err(format!("too few of a kind: {seen:?}, {decided}")) }
}

fn loops(loops: &[&[[f32; 3]]]) -> Boundary {
    let mut set = PolygonSet::default();
    set.push_points(&loops.iter().map(|points| points.to_vec()).collect::<Vec<_>>());
    placed(&set).expect("no triangle").0
}

const ABOVE: Light = Light::point([0.3, 0.2, 5.0]);
const BELOW: Light = Light::point([0.3, 0.2, -5.0]);

fn seen(boundary: &Boundary, light: Light) -> Orientation {
    boundary.orientation(light)
}

/// The side that lights above and below see.
#[test]
fn cases_worked_by_hand() {
    use Orientation::{BackFacing as Back, FrontFacing as Front, InPlane, Twisted};
    let square = |size: f32, height: f32| {
        [[-size, -size, height], [size, -size, height], [size, size, height], [-size, size, height]]
    };
    let [[a, b, c, d], large, mut raised] = [square(1.0, 0.0), square(2.0, 0.0), square(1.0, 1.0)];
    raised.reverse();
    let at = |angle: f32| [angle.to_radians().cos(), angle.to_radians().sin(), 0.0];
    let plain = loops(&[&[a, b, c, d]]);
    let flat = |points: &[[f32; 2]]| loops(&[&points.iter().map(|&[x, y]| [x, y, 0.0]).collect::<Vec<_>>()]);
    // From some sides it is twisted (Bergeron's figure 7).
    let bent = loops(&[&[[-1.0, -1.0, 1.0], [1.0, -1.0, -1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, -1.0]]]);
    for (name, boundary, expected) in [
        ("a square", &plain, [Front, Back]),
        ("a bow tie", &loops(&[&[a, b, d, c]]), [Twisted; 2]),
        ("a hole", &loops(&[&large, &[d, c, b, a]]), [Front, Back]),
        ("a hole around it", &loops(&[&[a, b, c, d], &[large[3], large[2], large[1], large[0]]]), [Back, Front]),
        ("not planar", &bent, [Front, Back]),
        // Touching in space counts as twisted.
        ("out and back", &flat(&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), [Twisted; 2]),
        ("a corner on an edge", &flat(&[[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [2.0, 0.0], [0.0, 2.0]]), [Twisted; 2]),
        ("winding number 2", &loops(&[&large, &[a, b, c, d]]), [Twisted; 2]),
        // All ends of edges have winding numbers 0 and 1 beside them.
        ("two triangles", &loops(&[&[90.0, 210.0, 330.0].map(at), &[270.0, 30.0, 150.0].map(at)]), [Twisted; 2]),
        ("a star", &loops(&[&[0.0, 144.0, 288.0, 72.0, 216.0].map(at)]), [Twisted; 2]),
        ("two corners at one place", &loops(&[&[a, a, b, c, d]]), [Front, Back]),
    ] {
        assert_eq!([seen(boundary, ABOVE), seen(boundary, BELOW)], expected, "{name}");
    }
    let lifted = loops(&[&large, &raised]);
    // Around the light, opposite directions are not the same.
    let mut fence = [0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0].map(at);
    fence.iter_mut().zip([0.1, -0.1].into_iter().cycle()).for_each(|(corner, height)| corner[2] = height);
    assert!(!fits_half_space(&fence, [0.0, 0.0, 0.0, 1.0]) && fits_half_space(&fence[..4], [0.0, 0.0, 0.0, 1.0]));
    for (boundary, light, expected) in [
        (&plain, Light::point([1.0, 0.0, 0.0]), InPlane),
        (&bent, Light::point([9.0, 0.5, 0.0]), Twisted),
        (&bent, Light::point([0.0; 3]), Twisted),
        (&lifted, Light::directional([1.5, 0.0, 1.0]), Twisted),
        (&plain, Light::point([9.0, 2.0, 0.0]), InPlane),
        (&plain, Light::directional([1.0, 2.0, 0.0]), InPlane),
        (&lifted, ABOVE, Front),
        (&lifted, Light::directional([4.0, 0.0, 1.0]), Twisted),
        (&loops(&[&fence]), Light::point([0.0; 3]), Twisted),
        (&loops(&[&fence]), Light::point([0.0, 0.0, 1.0]), Front),
    ] {
        assert_eq!(seen(boundary, light), expected, "{light:?}");
    }
}

/// Edges on opposite sides of the light have lines of sight in common, but no direction. Edges in line meet where they overlap.
#[test]
fn pairs_of_edges_meet_as_seen_from_the_light() {
    let across = [[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
    let along = [[0.0, -2.0, 2.0], [0.0, 2.0, 2.0]];
    let in_line = |from: f32, to: f32| [[from, 2.0 * from, 0.0], [to, 2.0 * to, 0.0]];
    let (at_zero, beside) = ([0.0, 0.0, 0.0, 1.0], [1.0, 2.0, 3.0, 1.0]);
    for (edge, other, light, meets) in [
        (across, along, at_zero, true),
        (across, along.map(|point| point.map(|c: f32| -c)), at_zero, false),
        (across, along.map(|[x, y, z]| [x + 2.5, y, z]), at_zero, false),
        (in_line(0.0, 3.0), in_line(1.0, 2.0), beside, true),
        (in_line(0.0, 3.0), in_line(2.0, 1.0), beside, true),
        (in_line(0.0, 3.0), in_line(-1.0, 4.0), beside, true),
        (in_line(0.0, 3.0), in_line(2.0, 5.0), beside, true),
        (in_line(0.0, 3.0), in_line(4.0, 5.0), beside, false),
        (in_line(0.0, 3.0), in_line(-1.0, -2.0), beside, false),
        // With an end in common.
        (in_line(0.0, 3.0), in_line(3.0, 4.0), beside, false),
        (in_line(0.0, 3.0), in_line(3.0, 1.0), beside, true),
        (in_line(0.0, 3.0), in_line(0.0, 5.0), beside, true),
        (in_line(0.0, 3.0), in_line(3.0, 0.0), beside, true),
    ] {
        assert_eq!(edge_pair(edge, other, light).meets, meets, "{edge:?}, {other:?}");
        assert_eq!(edge_pair(other, edge, light).meets, meets, "{other:?}, {edge:?}");
    }
}

/// All pairs accept each loop that the cheap way accepts, for loops of all sizes. The cheap way accepts convex loops.
#[test]
fn convex_boundaries_take_the_cheap_way() {
    for seed in 0..400 {
        let mut random = Random::new(seed);
        let count = 5 + random.below(60);
        let turns = 1 + random.below(2);
        let ring: Vec<[f32; 3]> = (0..count)
            .map(|corner| {
                let angle = corner as f32 / count as f32 * std::f32::consts::TAU * turns as f32;
                [angle.cos(), angle.sin(), 1e-3 * random.between(-1.0, 1.0)]
            })
            .collect();
        let light = [0.1, -0.2, 3.0, 1.0];
        let by_turns = (turns == 1).then_some(Orientation::FrontFacing);
        assert_eq!(polygon_turns(&ring, light), by_turns, "seed {seed}, {count} corners");
        let expected = if turns == 1 { (Orientation::FrontFacing, false) } else { (Orientation::Twisted, true) };
        assert_eq!(loops(&[&ring]).decide(light), expected, "seed {seed}, {count} corners");
    }
}

/// Boundaries of many corners, which all pairs of edges take minutes for: a circle that rounding dents, a comb, a
/// spiral with bridges, each from above, from below and from beside.
#[test]
fn boundaries_of_many_corners_take_no_time() {
    const CORNERS: usize = 20_000;
    let turn = |at: f64| at * std::f64::consts::TAU;
    let circle: Vec<[f32; 3]> = (0..CORNERS)
        .map(|at| turn(at as f64 / CORNERS as f64).sin_cos())
        .map(|(sin, cos)| [cos as f32, sin as f32, 0.0])
        .collect();
    // Long teeth side by side, that lean.
    let comb = (0..CORNERS).map(|at| {
        let x = (at / 2) as f32 / CORNERS as f32;
        if at % 2 == 0 { [x, 0.0, 0.0] } else { [x + 0.3, 1.0, 0.0] }
    });
    let comb: Vec<[f32; 3]> =
        comb.chain([[2.0, 1.0, 0.0], [2.0, -1.0, 0.0], [-1.0, -1.0, 0.0], [-1.0, 0.0, 0.0]]).collect();
    let ring = |radius: f64, at: usize| {
        let (sin, cos) = turn(at as f64 * 40.0 / CORNERS as f64).sin_cos();
        [(radius * cos) as f32, (radius * sin) as f32, 0.0]
    };
    let arm = |at: usize, lead: f64| ring(0.2 + (at as f64 * 40.0 / CORNERS as f64 + lead) * 0.1, at);
    let out = (0..CORNERS / 2).map(|at| arm(at, 0.0));
    let spiral: Vec<[f32; 3]> = out.chain((0..CORNERS / 2).rev().map(|at| arm(at, -0.4))).collect();
    for (name, corners) in [("circle", circle), ("comb", comb), ("spiral", spiral)] {
        let next = corners.iter().cycle().skip(1);
        let area =
            |(p, q): (&[f32; 3], &[f32; 3])| f64::from(p[0]) * f64::from(q[1]) - f64::from(p[1]) * f64::from(q[0]);
        let mut expected = [Orientation::FrontFacing, Orientation::BackFacing];
        if corners.iter().zip(next).map(area).sum::<f64>() < 0.0 {
            expected.reverse();
        }
        let boundary = loops(&[&corners]);
        assert_eq!([seen(&boundary, ABOVE), seen(&boundary, BELOW)], expected, "{name}");
        assert_eq!(seen(&boundary, Light::directional([0.1, 0.2, 1.0])), expected[0], "{name}");
        assert_eq!(seen(&boundary, Light::directional([0.1, 0.2, 0.0])), Orientation::InPlane, "{name}");
        let mut crossed = corners;
        crossed.swap(CORNERS / 3, CORNERS / 2);
        assert_eq!(seen(&loops(&[&crossed]), ABOVE), Orientation::Twisted, "{name}");
    }
}

/// A plate with many holes: each hole's winding number leaves out edges beside its line.
#[test]
fn boundaries_of_many_holes() {
    const SIDE: usize = 40;
    let hole = |at: usize| {
        let (x, y) = ((at % SIDE) as f32, (at / SIDE) as f32);
        // Clockwise, and turned against the others.
        (0..6)
            .map(move |corner| (corner as f32 + 0.01 * at as f32).sin_cos())
            .map(move |(sin, cos)| [x + 0.3 * sin, y + 0.3 * cos, 0.0])
    };
    let far = SIDE as f32;
    let outer = vec![[-1.0, -1.0, 0.0], [far, -1.0, 0.0], [far, far, 0.0], [-1.0, far, 0.0]];
    let mut plate: Vec<Vec<[f32; 3]>> = vec![outer];
    plate.extend((0..SIDE * SIDE).map(|at| hole(at).collect()));
    let sides = |plate: &[Vec<[f32; 3]>]| {
        let (mut edges, mut positions) = (Vec::new(), Vec::new());
        for ring in plate {
            let (first, count) = (positions.len() as u32, ring.len() as u32);
            edges.extend((0..count).map(|at| [first + at, first + (at + 1) % count]));
            positions.extend_from_slice(ring);
        }
        let boundary = Boundary::new(&edges, &positions).expect("finite corners");
        [ABOVE, BELOW].map(|light| seen(&boundary, Light::point([19.0, 17.0, 9.0 * light.xyz[2]])))
    };
    assert_eq!(sides(&plate), [Orientation::FrontFacing, Orientation::BackFacing]);
    // A hole the other way around, one in another hole, and one across another.
    let mut reversed = plate.clone();
    reversed[SIDE].reverse();
    assert_eq!(sides(&reversed), [Orientation::Twisted; 2]);
    for shift in [[0.0, 0.0, 0.0], [0.25, 0.0, 0.0]] {
        let mut moved = plate.clone();
        let other = &plate[SIDE / 2];
        let middle = [(SIDE / 2 - 1) as f32, 0.0, 0.0];
        moved[7] = other.iter().map(|p| [0, 1, 2].map(|i| middle[i] + 0.5 * (p[i] - middle[i]) + shift[i])).collect();
        assert_eq!(sides(&moved), [Orientation::Twisted; 2], "{shift:?}");
    }
}
