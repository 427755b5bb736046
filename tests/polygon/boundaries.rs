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
            let (found, is_general) = boundary.orientation(light.to_array());
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
    if decided < 2 * count as usize {
        return Err(format!("close pairs decide {decided} only"));
    }
    if seen.len() < 6 || seen.values().any(|&count| count < 12) {
        Err(format!("too few of a kind: {seen:?}"))
    } else {
        Ok(())
    }
}

fn loops(loops: &[&[[f32; 3]]]) -> Boundary {
    let mut set = PolygonSet::default();
    set.push_points(&loops.iter().map(|points| points.to_vec()).collect::<Vec<_>>());
    placed(&set).expect("no triangle").0
}

const ABOVE: Light = Light::point([0.3, 0.2, 5.0]);
const BELOW: Light = Light::point([0.3, 0.2, -5.0]);

fn seen(boundary: &Boundary, light: Light) -> Orientation {
    boundary.orientation(light.to_array()).0
}

fn square(size: f32, height: f32) -> [[f32; 3]; 4] {
    [[-size, -size, height], [size, -size, height], [size, size, height], [-size, size, height]]
}

fn reversed<const N: usize>(mut points: [[f32; 3]; N]) -> [[f32; 3]; N] {
    points.reverse();
    points
}

/// The side that lights above and below see, then what others see.
#[test]
fn cases_worked_by_hand() {
    use Orientation::{BackFacing as Back, FrontFacing as Front, InPlane, Twisted};
    let [small, large, raised] = [square(1.0, 0.0), square(2.0, 0.0), square(1.0, 1.0)];
    let [a, b, c, d] = small;
    let at = |angle: f32| [angle.to_radians().cos(), angle.to_radians().sin(), 0.0];
    let flat = |points: &[[f32; 2]]| loops(&[&points.iter().map(|&[x, y]| [x, y, 0.0]).collect::<Vec<_>>()]);
    let lobes = |corners: &[u32]| {
        let positions = vec![[0.0; 3], [2.0, -1.0, 0.0], [2.0, 1.0, 0.0], [-2.0, 1.0, 0.0], [-2.0, -1.0, 0.0]];
        let mut set = PolygonSet { positions, ..Default::default() };
        set.push(&[corners.to_vec()]);
        placed(&set).expect("a polygon").0
    };
    let plain = loops(&[&small]);
    // From some sides it is twisted (Bergeron's figure 7).
    let bent = loops(&[&[[-1.0, -1.0, 1.0], [1.0, -1.0, -1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, -1.0]]]);
    let comb =
        [[0.0, 0.0], [3.0, 0.0], [6.0, 0.0], [6.0, 2.0], [4.0, 2.0], [4.0, 1.0], [2.0, 1.0], [2.0, 2.0], [0.0, 2.0]];
    for (name, boundary, expected) in [
        ("a square", &plain, [Front, Back]),
        ("a bow tie", &loops(&[&[a, b, d, c]]), [Twisted; 2]),
        ("not planar", &bent, [Front, Back]),
        ("a hole", &loops(&[&large, &reversed(small)]), [Front, Back]),
        ("winding number 2", &loops(&[&large, &small]), [Twisted; 2]),
        ("a hole around it", &loops(&[&small, &reversed(large)]), [Back, Front]),
        // All ends of edges have winding numbers 0 and 1 beside them.
        ("two triangles", &loops(&[&[90.0, 210.0, 330.0].map(at), &[270.0, 30.0, 150.0].map(at)]), [Twisted; 2]),
        ("a star", &loops(&[&[0.0, 144.0, 288.0, 72.0, 216.0].map(at)]), [Twisted; 2]),
        // A vertex that is an ordinary corner, twice.
        ("two lobes", &lobes(&[0, 1, 2, 0, 3, 4]), [Front, Back]),
        ("two lobes against each other", &lobes(&[0, 1, 2, 0, 4, 3]), [Twisted; 2]),
        ("corners in line", &flat(&comb), [Front, Back]),
        // Touching in space counts as twisted.
        ("out and back", &flat(&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), [Twisted; 2]),
        ("a corner on an edge", &flat(&[[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [2.0, 0.0], [0.0, 2.0]]), [Twisted; 2]),
        ("two corners at one place", &loops(&[&[a, a, b, c, d]]), [Front, Back]),
    ] {
        assert_eq!([seen(boundary, ABOVE), seen(boundary, BELOW)], expected, "{name}");
    }
    // A hole in another plane leaves the outer loop as the light goes aside.
    let lifted = loops(&[&large, &reversed(raised)]);
    for (name, boundary, light, expected) in [
        ("in the plane", &plain, Light::point([9.0, 2.0, 0.0]), InPlane),
        ("on an edge", &plain, Light::point([1.0, 0.0, 0.0]), InPlane),
        ("along the plane", &plain, Light::directional([1.0, 2.0, 0.0]), InPlane),
        ("beside what is bent", &bent, Light::point([9.0, 0.5, 0.0]), Twisted),
        ("within its hull", &bent, Light::point([0.0; 3]), Twisted),
        ("a lifted hole", &lifted, ABOVE, Front),
        ("a lifted hole, across", &lifted, Light::directional([1.5, 0.0, 1.0]), Twisted),
        ("a lifted hole, beside", &lifted, Light::directional([4.0, 0.0, 1.0]), Twisted),
    ] {
        assert_eq!(seen(boundary, light), expected, "{name}");
    }
}

/// Opposite directions are not the same: a fence around the light that fits no half-space, and its halves.
#[test]
fn a_boundary_around_the_light_is_twisted() {
    let light = Light::point([0.0; 3]);
    let fence: Vec<[f32; 3]> = (0..8)
        .map(|corner| {
            let angle = corner as f32 * std::f32::consts::FRAC_PI_4;
            [angle.cos(), angle.sin(), if corner % 2 == 0 { 0.1 } else { -0.1 }]
        })
        .collect();
    assert!(!fits_half_space(&fence, light.to_array()));
    assert_eq!(seen(&loops(&[&fence]), light), Orientation::Twisted);
    assert_eq!(seen(&loops(&[&fence]), Light::point([0.0, 0.0, 1.0])), Orientation::FrontFacing);
    assert!(fits_half_space(&fence[..4], light.to_array()));
}

/// Edges on opposite sides of the light have lines of sight in common, but no direction.
#[test]
fn opposite_directions_do_not_cross() {
    let light = [0.0, 0.0, 0.0, 1.0];
    let across = [[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0]];
    let along = [[0.0, -2.0, 2.0], [0.0, 2.0, 2.0]];
    let opposite = along.map(|point| point.map(|c: f32| -c));
    assert!(edge_pair(across, along, light).meets && edge_pair(along, across, light).meets);
    assert!(!edge_pair(across, opposite, light).meets && !edge_pair(opposite, across, light).meets);
    let beside = along.map(|[x, y, z]| [x + 2.5, y, z]);
    assert!(!edge_pair(across, beside, light).meets);
}

#[test]
fn edges_in_line_meet_where_they_overlap() {
    let on_line = |from: f32, to: f32| [[from, 2.0 * from, 0.0], [to, 2.0 * to, 0.0]];
    for (other, meets) in [
        (on_line(1.0, 2.0), true),
        (on_line(2.0, 1.0), true),
        (on_line(-1.0, 4.0), true),
        (on_line(2.0, 5.0), true),
        (on_line(4.0, 5.0), false),
        (on_line(-1.0, -2.0), false),
        // With an end in common.
        (on_line(3.0, 4.0), false),
        (on_line(3.0, 1.0), true),
        (on_line(0.0, 5.0), true),
        (on_line(3.0, 0.0), true),
    ] {
        let edge = on_line(0.0, 3.0);
        assert_eq!(edge_pair(edge, other, [1.0, 2.0, 3.0, 1.0]).meets, meets, "{other:?}");
        assert_eq!(edge_pair(other, edge, [1.0, 2.0, 3.0, 1.0]).meets, meets, "{other:?}");
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
        assert_eq!(loops(&[&ring]).orientation(light), expected, "seed {seed}, {count} corners");
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
        let facing = |corners: &[[f32; 3]]| {
            let area: f64 = corners
                .iter()
                .zip(corners.iter().cycle().skip(1))
                .map(|(p, q)| f64::from(p[0]) * f64::from(q[1]) - f64::from(p[1]) * f64::from(q[0]))
                .sum();
            if area > 0.0 {
                [Orientation::FrontFacing, Orientation::BackFacing]
            } else {
                [Orientation::BackFacing, Orientation::FrontFacing]
            }
        };
        let (boundary, expected) = (loops(&[&corners]), facing(&corners));
        assert_eq!([seen(&boundary, ABOVE), seen(&boundary, BELOW)], expected, "{name}");
        assert_eq!(seen(&boundary, Light::directional([0.1, 0.2, 1.0])), expected[0], "{name}");
        assert_eq!(seen(&boundary, Light::directional([0.1, 0.2, 0.0])), Orientation::InPlane, "{name}");
        let mut crossed = corners;
        crossed.swap(CORNERS / 3, CORNERS / 2);
        assert_eq!(seen(&loops(&[&crossed]), ABOVE), Orientation::Twisted, "{name}");
    }
}
