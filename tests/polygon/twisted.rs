//! The pieces of twisted outlines: their winding numbers against the parity of the triangles between light and points.

use std::collections::BTreeMap;

use rimline::Light;
use rimline::internals::cpu::{Outline, Piece, PieceEnd, Seen, cut_edges};
use rimline::mesh::Weld;
use rimline_testkit::polygons::{PolygonSet, edge_on_polygon, folded_polygon, outline_in_planes, random_polygon};
use rimline_testkit::random::Random;
use rimline_testkit::{is_long, must_fail, polygon_oracle, shadow_oracle};

use crate::lights::light_for;

type Outcome = Result<(), String>;
type Vector = [f64; 3];

fn cross(u: Vector, v: Vector) -> Vector {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

fn dot(u: Vector, v: Vector) -> f64 {
    u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
}

fn unit(v: Vector) -> Vector {
    let length = dot(v, v).sqrt();
    v.map(|c| c / length)
}

fn difference(p: Vector, q: Vector) -> Vector {
    [0, 1, 2].map(|axis| p[axis] - q[axis])
}

/// Whether a point is in a triangle, or next to it.
fn is_on(point: Vector, [a, b, c]: [Vector; 3]) -> bool {
    let normal = cross(difference(b, a), difference(c, a));
    let area = dot(normal, normal).sqrt();
    let height = dot(normal, difference(point, a)).abs();
    let is_within = [(a, b), (b, c), (c, a)]
        .iter()
        .all(|&(p, q)| dot(cross(difference(q, p), difference(point, p)), normal) > -1e-3 * area);
    area < 1e-6 || height < 1e-3 * area && is_within
}

/// A polygon, and a light.
struct Case {
    set: PolygonSet,
    light: Light,
    outline: Outline,
    edges: Vec<[[f32; 3]; 2]>,
    faces: Vec<[u32; 3]>,
}

impl Case {
    fn pieces(&self) -> Vec<Piece> {
        let triangles: Vec<_> = self.faces.iter().map(|face| face.map(|v| self.set.positions[v as usize])).collect();
        cut_edges(&self.outline, &triangles, self.light.to_array())
    }

    /// How far along the earlier of two edges they cross. Pieces of both end there: both are seen there, but how far along each
    /// rounding tells by itself, and anything does where they are seen in line.
    fn crossing(&self, pieces: &[Piece], edges: [usize; 2]) -> Vector {
        let [first, second] = [edges[0].min(edges[1]), edges[0].max(edges[1])];
        let of_first = pieces.iter().filter(|piece| piece.edge == first).flat_map(|piece| piece.ends);
        let found = of_first.into_iter().find_map(|end| match end {
            PieceEnd::Crossing { edge, at } if edge == second => Some(at),
            _ => None,
        });
        let [a, b] = self.outline.edges()[first].map(|p| p.map(f64::from));
        let at = found.expect("both edges are cut");
        [0, 1, 2].map(|axis| a[axis] + at * (b[axis] - a[axis]))
    }

    /// The ends of each piece, in the direction in which it runs.
    fn ends(&self, pieces: &[Piece]) -> Vec<[Vector; 2]> {
        let ends = |piece: &Piece| {
            let corners = self.outline.edges()[piece.edge].map(|p| p.map(f64::from));
            let place = |end: usize| match piece.ends[end] {
                PieceEnd::Corner => corners[end],
                PieceEnd::Touch(point) => point.map(f64::from),
                PieceEnd::Crossing { edge, .. } => self.crossing(pieces, [piece.edge, edge]),
            };
            if piece.is_turned { [place(1), place(0)] } else { [place(0), place(1)] }
        };
        pieces.iter().map(ends).collect()
    }

    /// At each corner, and at each crossing of two edges, equal numbers of pieces begin and end.
    fn check_closed(&self, pieces: &[Piece]) -> Outcome {
        let mut balance = BTreeMap::<String, i32>::new();
        for piece in pieces {
            let edge = self.outline.edges()[piece.edge];
            for end in 0..2 {
                let place = match piece.ends[end] {
                    PieceEnd::Corner => format!("{:?}", edge[end].map(|c| c + 0.0)),
                    PieceEnd::Touch(point) => format!("{:?}", point.map(|c| c + 0.0)),
                    PieceEnd::Crossing { edge, .. } => {
                        format!("the crossing of {} and {}", piece.edge.min(edge), piece.edge.max(edge))
                    }
                };
                *balance.entry(place).or_default() += if piece.is_turned == (end == 1) { 1 } else { -1 };
            }
        }
        match balance.into_iter().find(|&(_, sum)| sum != 0) {
            None => Ok(()),
            Some((place, sum)) => Err(format!("{sum} pieces too many begin at {place}")),
        }
    }

    /// Directions from a point light, or points of a plane across a light at infinity, one unit before it.
    fn seen(&self, point: Vector) -> Vector {
        let [x, y, z, w] = self.light.to_array().map(f64::from);
        if w != 0.0 {
            return [point[0] - x / w, point[1] - y / w, point[2] - z / w];
        }
        let l = unit([x, y, z]);
        let height = dot(point, l);
        [0, 1, 2].map(|axis| point[axis] - (height + 1.0) * l[axis])
    }

    /// Whether the light is on the polygon or next to it, where rounding tells what it sees.
    fn is_lit_from_within(&self) -> bool {
        let [x, y, z, w] = self.light.to_array().map(f64::from);
        let corners = |face: &[u32; 3]| face.map(|v| self.set.positions[v as usize].map(f64::from));
        w != 0.0 && self.faces.iter().any(|face| is_on([x / w, y / w, z / w], corners(face)))
    }

    /// A point far beyond all corners, as seen from the light.
    fn beyond(&self, random: &mut Random) -> [f32; 3] {
        let corner = self.set.positions[random.below(self.set.positions.len())];
        let other = self.set.positions[random.below(self.set.positions.len())];
        let part = random.between(-0.3, 1.3);
        let aim = [0, 1, 2].map(|axis| corner[axis] + part * (other[axis] - corner[axis]) + random.between(-0.2, 0.2));
        let [x, y, z, w] = self.light.to_array();
        if w == 0.0 {
            let length = (x * x + y * y + z * z).sqrt();
            return [aim[0] - 400.0 * x / length, aim[1] - 400.0 * y / length, aim[2] - 400.0 * z / length];
        }
        let from = [x / w, y / w, z / w];
        let direction = [0, 1, 2].map(|axis| aim[axis] - from[axis]);
        let length = direction.iter().map(|c| c * c).sum::<f32>().sqrt().max(1e-3);
        [0, 1, 2].map(|axis| from[axis] + 400.0 * direction[axis] / length)
    }

    /// The winding number of the pieces at `p` less that at `q`. `None` where rounding may decide.
    fn winding_from(&self, pieces: &[[Vector; 2]], q: [f32; 3], p: [f32; 3]) -> Option<i32> {
        let [q, p] = [q, p].map(|point| unit(self.seen(point.map(f64::from))));
        if dot(p, q) < -0.9 || dot(p, q) > 0.999_999 {
            return None;
        }
        let mut sum = 0;
        for piece in pieces {
            let [a, b] = piece.map(|end| unit(self.seen(end)));
            let [of_a, of_b] = [a, b].map(|end| dot(cross(q, p), end));
            let [of_q, of_p] = [q, p].map(|end| dot(cross(a, b), end));
            let is_near = |value: f64| value.abs() < 1e-6;
            if dot(cross(a, b), cross(a, b)) < 1e-16 {
                // It has no length, or next to none.
                continue;
            }
            if (is_near(of_a) || is_near(of_b) || is_near(of_q) || is_near(of_p)) && dot(a, p) > -0.5 {
                return None;
            }
            // Directions turn the other way round than points seen from the light.
            if of_a * of_b < 0.0 && of_q * of_p < 0.0 && of_a * of_p > 0.0 {
                sum += if of_p < 0.0 { 1 } else { -1 };
            }
        }
        Some(sum)
    }
}

fn case(random: &mut Random, most: usize) -> Option<(&'static str, Case)> {
    let (name, set) = if random.below(6) == 0 {
        let mut set = PolygonSet::default();
        set.push_points(&[folded_polygon(random)]);
        ("folded", set)
    } else {
        random_polygon(random, most)
    };
    let mesh = set.mesh(Weld::Position).expect("a mesh");
    let edges = mesh.polygons()?.outline(0);
    let light = light_for(random, &set.positions).1;
    if light.w < 0.0 || light.to_array() == [0.0; 4] {
        return None;
    }
    let outline = Outline::new(edges, &set.positions).expect("finite corners");
    let edges: Vec<_> = edges.iter().map(|edge| edge.map(|v| set.positions[v as usize])).collect();
    let faces = mesh.faces().to_vec();
    Some((name, Case { set, light, outline, edges, faces }))
}

/// Darkness is where an odd number of triangles lie between: the pieces' winding number is 1 there, and 0 elsewhere.
fn check(case: &Case, pieces: &[Piece], points: &[[f32; 3]]) -> Result<usize, String> {
    let depths = shadow_oracle::shadow_depth(&case.set.positions, &case.faces, points, &[case.light]);
    let ends = case.ends(pieces);
    let mut checked = 0;
    for (at, &point) in points.iter().enumerate().skip(1) {
        let Some(found) = case.winding_from(&ends, points[at - 1], point) else { continue };
        let expected = depths[at] % 2 - depths[at - 1] % 2;
        if found != expected {
            return Err(format!("{found} from {:?} to {point:?}, expected {expected}", points[at - 1]));
        }
        checked += 1;
    }
    Ok(checked)
}

#[test]
fn pieces_wind_once_around_what_is_dark() -> Outcome {
    let first = 202_000;
    let count = if is_long() { 30_000 } else { 400 };
    println!("seeds from {first}");
    let (mut checked, mut cut, mut around, mut touching, mut by_kind) = (0, 0, 0, 0, [0; 4]);
    for seed in first..first + count {
        let mut random = Random::new(seed);
        let most = [6, 8, 12, 24, 64][random.below(5)];
        let Some((name, case)) = case(&mut random, most) else { continue };
        let found = polygon_oracle::find(&case.edges, case.light);
        if found.seen == Seen::InPlane || case.is_lit_from_within() {
            continue;
        }
        touching += usize::from(found.touches);
        by_kind[found.seen as usize] += 1;
        let points: Vec<_> = (0..12).map(|_| case.beyond(&mut random)).collect();
        let mut pieces = case.pieces();
        let what = format!("seed {seed}, {name}, {:?}", case.light);
        case.check_closed(&pieces).map_err(|error| format!("{what}: {error}"))?;
        checked += check(&case, &pieces, &points).map_err(|error| format!("{what}: {error}"))?;
        cut += usize::from(pieces.len() > case.edges.len());
        // Around the light there is no winding number, but a parity all the same.
        around += usize::from(points.iter().all(|&p| polygon_oracle::winding_at(&case.edges, case.light, p).is_none()));
        // Edges that cancel may have corners of their own. Triangles with these may surround the light.
        let places: Vec<_> = case.outline.edges().iter().flatten().collect();
        let is_of_outline = |v: &u32| places.contains(&&case.set.positions[*v as usize]);
        let is_within = case.faces.iter().flatten().all(is_of_outline);
        for &point in points.iter().filter(|_| is_within) {
            let winding = polygon_oracle::winding_at(&case.edges, case.light, point);
            let depth = shadow_oracle::shadow_depth(&case.set.positions, &case.faces, &[point], &[case.light])[0];
            if winding.is_some_and(|winding| winding.rem_euclid(2) != depth % 2) {
                return Err(format!("{what}: the oracles differ at {point:?}: {winding:?}, {depth}"));
            }
        }
        if seed % 8 == 0 {
            for piece in &mut pieces {
                piece.is_turned = !piece.is_turned;
            }
            let ends = case.ends(&pieces);
            let is_any = |points: &[[f32; 3]]| {
                let depths = shadow_oracle::shadow_depth(&case.set.positions, &case.faces, points, &[case.light]);
                (1..points.len()).any(|at| {
                    (depths[at] - depths[at - 1]) % 2 != 0
                        && case.winding_from(&ends, points[at - 1], points[at]).is_some()
                })
            };
            if is_any(&points) {
                must_fail("turned pieces", &check(&case, &pieces, &points))?;
            }
        }
    }
    println!(
        "{checked} steps between points, {cut} outlines cut, {around} around the light, {touching} touch themselves, {by_kind:?}"
    );
    if checked > 5 * count as usize && cut > 60 && around > 5 && touching > 5 {
        Ok(())
    } else {
        Err(format!("too few: {checked} steps, {cut} cut, {around} around"))
    }
}

/// An outline that is not twisted is its own border, wound with or against it.
#[test]
fn simple_outlines_are_not_cut() {
    let mut seen = [0; 2];
    for seed in 0..400 {
        let mut random = Random::new(seed);
        let Some((name, case)) = case(&mut random, 16) else { continue };
        let found = case.outline.seen(case.light.to_array()).0;
        if !matches!(found, Seen::Facing | Seen::Averted) {
            continue;
        }
        seen[usize::from(found == Seen::Facing)] += 1;
        let pieces = case.pieces();
        assert_eq!(pieces.len(), case.outline.edges().len(), "seed {seed}, {name}");
        assert!(pieces.iter().all(|piece| piece.is_turned == (found == Seen::Averted)), "seed {seed}, {name}");
    }
    assert!(seen.iter().all(|&count| count > 20), "{seen:?}");
}

/// Bergeron's figure 7: the light sees a bow tie, whose two lobes are dark.
#[test]
fn a_bow_tie_has_two_lobes() {
    let mut set = PolygonSet::default();
    let corners = [[-1.0, -1.0, 0.1], [1.0, 1.0, 0.2], [1.0, -1.0, 0.3], [-1.0, 1.0, -0.2]];
    set.push_points(&[corners.to_vec()]);
    let mesh = set.mesh(Weld::Keep).expect("a mesh");
    let outline = Outline::new(mesh.polygons().expect("polygons").outline(0), &corners).expect("finite");
    let triangles: Vec<_> = mesh.faces().iter().map(|face| face.map(|v| corners[v as usize])).collect();
    let pieces = cut_edges(&outline, &triangles, [0.0, 0.0, 9.0, 1.0]);
    // The two diagonals are cut in the middle. Edge 1 runs down on the right, with the right lobe on its right.
    let is_turned: Vec<(usize, bool)> = pieces.iter().map(|piece| (piece.edge, piece.is_turned)).collect();
    assert_eq!(is_turned, [(0, false), (0, true), (1, true), (2, true), (2, false), (3, false)]);
    let crossings: Vec<_> = pieces
        .iter()
        .filter_map(|piece| match piece.ends[1] {
            PieceEnd::Crossing { edge, at } => Some((piece.edge, edge, (at * 10.0).round())),
            PieceEnd::Corner | PieceEnd::Touch(_) => None,
        })
        .collect();
    assert_eq!(crossings, [(0, 2, 5.0), (2, 0, 5.0)]);
}

/// Planar polygons that were turned, so that they are planar but for rounding, and lights in their planes but for rounding.
#[test]
fn outlines_seen_edge_on_but_for_rounding_close() -> Outcome {
    let first = 207_000;
    println!("seeds from {first}");
    let (mut twisted, mut cut, mut open) = (0, 0, 0);
    for seed in first..first + if is_long() { 30_000 } else { 1_000 } {
        let mut random = Random::new(seed);
        let (points, light) = edge_on_polygon(&mut random);
        let mut set = PolygonSet::default();
        set.push_points(&[points]);
        let mesh = set.mesh(Weld::Position).expect("a mesh");
        let outline = Outline::new(mesh.polygons().expect("polygons").outline(0), &set.positions).expect("finite");
        let light = Light::point(light);
        if outline.seen(light.to_array()).0 != Seen::Twisted {
            continue;
        }
        twisted += 1;
        let edges: Vec<_> = outline.edges().to_vec();
        let case = Case { light, outline, edges, faces: mesh.faces().to_vec(), set };
        let pieces = case.pieces();
        cut += pieces.len() - case.edges.len();
        open += usize::from(case.check_closed(&pieces).is_err());
    }
    println!("{twisted} twisted, {cut} cuts, {open} open");
    if twisted > 100 && open == 0 { Ok(()) } else { Err(format!("{open} of {twisted} are open")) }
}

/// Corners in planes with the light but for some, so that it sees edges in line. Turns are those of the moved light, and the order of
/// cuts is.
#[test]
fn outlines_in_planes_with_the_light_close() -> Outcome {
    let first = 700_000;
    let seeds = if is_long() { 10_000 } else { 120 };
    println!("seeds from {first}");
    let mut touching = [0; 2];
    for (planes, others) in [(1, 1), (1, 2), (1, 5), (2, 0), (2, 1), (3, 0), (3, 1)] {
        let (mut twisted, mut open) = (0, [0; 2]);
        for seed in first..first + seeds {
            let mut random = Random::new(seed);
            let (points, light) = outline_in_planes(&mut random, planes, others);
            let scale = if seed % 5 == 0 { (random.below(100) as f32 - 50.0).exp2() } else { 1.0 };
            let mut set = PolygonSet::default();
            set.push_points(&[points.into_iter().map(|point| point.map(|c| c * scale)).collect()]);
            let mesh = set.mesh(Weld::Position).expect("a mesh");
            let Some(polygons) = mesh.polygons() else { continue };
            let outline = Outline::new(polygons.outline(0), &set.positions).expect("finite");
            let [x, y, z, w] = light.to_array();
            let light = if w == 0.0 { light } else { Light::point([x, y, z].map(|c| c * scale)) };
            if outline.seen(light.to_array()).0 != Seen::Twisted {
                continue;
            }
            twisted += 1;
            let edges: Vec<_> = outline.edges().to_vec();
            let case = Case { light, outline, edges, faces: mesh.faces().to_vec(), set };
            let touches = polygon_oracle::find(&case.edges, light).touches;
            touching[usize::from(touches)] += 1;
            if let Err(error) = case.check_closed(&case.pieces()) {
                println!("{planes} planes, {others} others, seed {seed}, touches: {touches}: {error}");
                open[usize::from(touches)] += 1;
            }
        }
        println!("{planes} planes, {others} others: {twisted} twisted, {open:?} open");
        // Outlines that touch themselves in space, and have many edges through one point besides, need not close.
        if 4 * twisted < 3 * seeds || open[0] > 0 || planes == 1 && open[1] > 0 || 100 * open[1] > twisted {
            return Err(format!("{open:?} of {twisted} are open, of {planes} planes and {others} others"));
        }
    }
    println!("{touching:?} that do not touch themselves, and that do");
    if touching.iter().all(|&count| 4 * count > 3 * seeds) { Ok(()) } else { Err(format!("too few: {touching:?}")) }
}
