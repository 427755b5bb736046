//! Faces in front of random points of lines, against rays in big integers: docs/numerics/lines.md.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use rimline_lines::{Drawing, LineOptions, Object, View, draw};
use rimline_testkit::is_long;
use rimline_testkit::random::Random;

use crate::support::oracle::{Oracle, Point, SHARES};
use crate::support::shapes::{Shape, bumpy_torus, cuboid, lattice_soup, moved, soup, torus};

/// Points nearer to a cut than this share of their edge are set aside.
const TOLERANCE: f64 = 1e-6;

/// The nearest lines of perspective views, as a share of the model's size.
const NEAR: f32 = 1e-3;

/// The corners of the box around a model.
fn corners(shapes: &[Shape]) -> [[f32; 3]; 2] {
    let all = || shapes.iter().flat_map(|shape| &shape.positions);
    let least = [0, 1, 2].map(|axis| all().fold(f32::INFINITY, |least, p| least.min(p[axis])));
    let most = [0, 1, 2].map(|axis| all().fold(f32::NEG_INFINITY, |most, p| most.max(p[axis])));
    [least, most]
}

/// Half of the longest side of the box around a model.
fn size_of(shapes: &[Shape]) -> f32 {
    let [least, most] = corners(shapes);
    (0..3).map(|axis| 0.5 * most[axis] - 0.5 * least[axis]).fold(0.0, f32::max)
}

/// Where a span begins and ends along its edge, and its count.
type Counted = ([f64; 2], u32);

/// Results of comparing points.
#[derive(Debug, Default)]
struct Found {
    points: usize,
    wrong: usize,
    aside: usize,
    hidden: usize,
    /// Points of lines that coincide with another one, which is drawn there.
    coincide: usize,
}

/// Whether a line of the page passes a point, within a millionth of its length.
fn is_on([[ax, ay], [bx, by]]: [[f64; 2]; 2], [x, y]: [f64; 2]) -> bool {
    let (dx, dy) = (bx - ax, by - ay);
    let length = dx * dx + dy * dy;
    let (along, across) = ((x - ax) * dx + (y - ay) * dy, (x - ax) * dy - (y - ay) * dx);
    across.abs() < TOLERANCE * length && along > -TOLERANCE * length && along < (1.0 + TOLERANCE) * length
}

fn drawn(shapes: &[Shape], view: &View) -> Drawing {
    let objects: Vec<_> = shapes.iter().map(|shape| Object::new(&shape.mesh, &shape.positions)).collect();
    let near = Some(f64::from(NEAR * size_of(shapes)));
    let options = LineOptions { crease_degrees: 0.0, near, ..LineOptions::default() };
    draw(&objects, view, &options, |_, _| ControlFlow::Continue(())).expect("drawn")
}

fn oracle(shapes: &[Shape], view: &View) -> Oracle {
    let (mut positions, mut faces, mut polygons) = (Vec::new(), Vec::new(), 0);
    for Shape { positions: shape_positions, mesh } in shapes {
        let first = positions.len() as u32;
        positions.extend_from_slice(shape_positions);
        let of = mesh.polygons().map(rimline::mesh::Polygons::triangle_polygons);
        for (number, face) in mesh.faces().iter().enumerate() {
            let polygon = of.as_ref().map_or(number, |of| of[number] as usize);
            faces.push((face.map(|vertex| vertex + first), polygons + polygon));
        }
        polygons += mesh.face_count();
    }
    Oracle::new(&positions, &faces, view.eye().to_array())
}

/// Compares random points of all lines. `lie` is added to each count of the drawing.
fn compare(shapes: &[Shape], view: &View, points: usize, random: &mut Random, lie: u32) -> Found {
    let (drawing, oracle) = (drawn(shapes, view), oracle(shapes, view));
    // For each edge where its spans begin and end along it, with their counts.
    let mut edges: BTreeMap<(u32, u32), Vec<Counted>> = BTreeMap::new();
    let ends_of = |(object, edge): (u32, u32)| {
        let Shape { positions, mesh } = &shapes[object as usize];
        mesh.edges().get(edge as usize).expect("an edge").vertices.map(|vertex| positions[vertex as usize])
    };
    for span in &drawing.spans {
        let Some(edge) = span.edge else { continue };
        let key = (span.object, edge);
        let [a, b] = ends_of(key).map(|p| p.map(f64::from));
        let axis = (0..3).max_by(|&i, &j| (b[i] - a[i]).abs().total_cmp(&(b[j] - a[j]).abs())).expect("an axis");
        let mut ends = span.ends.map(|end| (end[axis] - a[axis]) / (b[axis] - a[axis]));
        ends.sort_by(f64::total_cmp);
        edges.entry(key).or_default().push((ends, span.faces_in_front));
    }
    let edges: Vec<_> = edges.into_iter().collect();
    let mut found = Found::default();
    for _ in 0..if edges.is_empty() { 0 } else { points } {
        let (key, spans) = &edges[random.below(edges.len())];
        let share = (random.next_u64() >> 24) as i64;
        let at = share as f64 / SHARES as f64;
        let exact = Point::on_edge(ends_of(*key), share);
        let [a, b] = ends_of(*key).map(|p| p.map(f64::from));
        let point = [0, 1, 2].map(|axis| a[axis] + at * (b[axis] - a[axis]));
        let is_near = |end: &f64| (end - at).abs() < TOLERANCE;
        let Some((_, count)) = spans.iter().find(|(ends, _)| ends[0] <= at && at <= ends[1]) else {
            let depth = view.depth(point);
            let expected = oracle.count(&exact, Some(point));
            let is_better = |count: u32| count == 0 || expected > 0;
            let mut others = drawing.spans.iter().filter(|span| is_better(span.faces_in_front));
            if others.any(|span| is_on(span.page, view.page(point))) {
                found.coincide += 1;
                continue;
            }
            let is_before = view.is_perspective() && depth < f64::from(NEAR * size_of(shapes)) * (1.0 + TOLERANCE);
            found.wrong += usize::from(!is_before);
            continue;
        };
        if spans.iter().any(|(ends, _)| ends.iter().any(is_near)) {
            found.aside += 1;
            continue;
        }
        let expected = oracle.count(&exact, (found.points % 16 != 0).then_some(point));
        found.points += 1;
        found.hidden += usize::from(expected > 0);
        if expected != count + lie {
            found.wrong += 1;
            if lie == 0 && found.wrong < 5 {
                println!("{key:?} {:?} at {at}: {expected} faces in front, drawn {count}; {spans:?}", ends_of(*key));
            }
        }
    }
    found
}

/// Compares a random point of each line where faces meet.
fn compare_meetings(shapes: &[Shape], view: &View, random: &mut Random) -> Found {
    let (drawing, oracle) = (drawn(shapes, view), oracle(shapes, view));
    let mut found = Found::default();
    for span in drawing.spans.iter().filter(|span| span.edge.is_none()) {
        let corners = span.faces.map(|face| {
            let face = face.expect("two faces");
            let Shape { positions, mesh } = &shapes[face.object as usize];
            mesh.faces()[face.face as usize].map(|vertex| positions[vertex as usize])
        });
        let [from, to] = &*Point::crossings(corners[0], corners[1]) else { panic!("faces that do not meet: {span:?}") };
        let axis = (0..3).max_by(|&i, &j| {
            let extent = |axis: usize| (span.ends[1][axis] - span.ends[0][axis]).abs();
            extent(i).total_cmp(&extent(j))
        });
        let axis = axis.expect("an axis");
        let [low, high] = [from, to].map(|end| end.double()[axis]);
        let along = f64::from(random.between(0.05, 0.95));
        let point = [0, 1, 2].map(|axis| span.ends[0][axis] + along * (span.ends[1][axis] - span.ends[0][axis]));
        if (span.ends[1][axis] - span.ends[0][axis]).abs() < TOLERANCE {
            found.aside += 1;
            continue;
        }
        let share = ((point[axis] - low) / (high - low) * SHARES as f64) as i64;
        let exact = Point::between(from, to, share);
        let distance = (0..3).map(|axis| (exact.double()[axis] - point[axis]).abs()).fold(0.0, f64::max);
        let expected = oracle.count(&exact, (found.points % 16 != 0).then_some(point));
        found.points += 1;
        found.hidden += usize::from(expected > 0);
        if expected != span.faces_in_front || distance > 1e-9 {
            found.wrong += 1;
            println!("{expected} faces in front, {distance} apart: {span:?}");
        }
    }
    found
}

/// Eyes around a model of this size about a point: beside it, along axes, in it, on one of its corners.
fn views(at: [f32; 3], size: f32, corner: [f32; 3]) -> Vec<View> {
    let from = |d: [f32; 3]| [0, 1, 2].map(|axis| at[axis] + size * d[axis]);
    let up = [0.1, 0.2, 1.0];
    vec![
        View::orthographic([3.0, 2.0, 1.0], up),
        View::orthographic([1.0, 0.0, 0.0], up),
        View::orthographic([0.0, -1.0, 0.0], up),
        View::orthographic([1.0, 1.0, 0.0], up),
        View::perspective(from([3.0, 2.0, 1.0]), at, up),
        View::perspective(from([0.0, 3.0, 0.0]), at, up),
        View::perspective(from([0.1, 0.2, 0.05]), from([2.0, 1.0, 0.0]), up),
        View::perspective(corner, at, up),
    ]
    .into_iter()
    .map(|view| view.expect("a view"))
    .collect()
}

fn models(random: &mut Random) -> Vec<(&'static str, Vec<Shape>)> {
    let unit = cuboid([0.0; 3], [1.0; 3]);
    let turn = |[x, y, z]: [f32; 3]| [x + 0.3 * y, y - 0.3 * x + 0.1 * z, z - 0.2 * y];
    let stacked = (0..8).map(|at| {
        let low = [at & 1, at >> 1 & 1, at >> 2].map(|c| c as f32);
        cuboid(low, low.map(|c| c + 1.0))
    });
    vec![
        ("torus", vec![torus(24, 14)]),
        ("two tori, one through the other", vec![torus(16, 9), moved(&torus(16, 9), |[x, y, z]| [x + 0.5, z, y])]),
        ("box", vec![unit.clone()]),
        ("boxes that pierce each other", vec![unit.clone(), moved(&unit, turn), cuboid([0.25; 3], [0.75, 0.75, 2.0])]),
        ("stacked boxes", stacked.collect()),
        ("one box twice", vec![unit.clone(), unit.clone()]),
        ("polygons that are not planar", vec![bumpy_torus(12, 8, 0.1)]),
        ("soup", vec![soup(random, 20, 60)]),
        ("lattice", vec![lattice_soup(random, 20, 40, 3), lattice_soup(random, 30, 60, 4)]),
        ("thin", vec![moved(&lattice_soup(random, 20, 40, 3), |[x, y, z]| [x, y, 1e-6 * z])]),
        ("far away", vec![moved(&torus(16, 9), |p| p.map(|c| c + 1e5))]),
        ("huge", vec![moved(&torus(16, 9), |p| p.map(|c| c * 1e30))]),
        ("tiny", vec![moved(&torus(16, 9), |p| p.map(|c| c * 1e-30))]),
        ("wide", vec![moved(&soup(random, 20, 40), |[x, y, z]| [x * 1e20, y, z * 1e-20])]),
    ]
}

/// Counts of faces in front of lines where faces meet are exact.
#[test]
fn counts_where_faces_meet_are_exact() {
    let mut random = Random::new(4);
    let mut points = 0;
    for (name, shapes) in models(&mut random) {
        let has_polygons = shapes.iter().any(|shape| shape.mesh.polygons().is_some());
        if has_polygons || ["far away", "huge", "tiny", "wide"].contains(&name) {
            continue;
        }
        for (number, view) in views([0.1; 3], size_of(&shapes), shapes[0].positions[0]).iter().enumerate() {
            let found = compare_meetings(&shapes, view, &mut random);
            println!("{name}, view {number}: {found:?}");
            assert_eq!(found.wrong, 0, "{name}, view {number}: {found:?}");
            points += found.points;
        }
    }
    assert!(points > 10_000, "{points}");
}

/// Counts of faces in front are exact between cuts.
#[test]
fn counts_are_exact() {
    let mut random = Random::new(1);
    let points = if is_long() { 10_500 } else { 600 };
    let mut total = Found::default();
    for (name, shapes) in models(&mut random) {
        let [least, most] = corners(&shapes);
        let middle = [0, 1, 2].map(|axis| 0.5 * least[axis] + 0.5 * most[axis]);
        for (number, view) in views(middle, size_of(&shapes), shapes[0].positions[0]).iter().enumerate() {
            let found = compare(&shapes, view, points, &mut random, 0);
            println!("{name}, view {number}: {found:?}");
            assert_eq!(found.wrong, 0, "{name}, view {number}: {found:?}");
            total.points += found.points;
            total.aside += found.aside;
            total.hidden += found.hidden;
            total.coincide += found.coincide;
        }
    }
    println!("{total:?}");
    // A wrong count does not go unnoticed.
    let view = View::orthographic([3.0, 2.0, 1.0], [0.0, 0.0, 1.0]).expect("a view");
    let found = compare(&[torus(24, 14)], &view, 50, &mut random, 1);
    assert!(found.points > 0 && found.points == found.wrong, "{found:?}");
    assert!(total.points > 90 * points && total.hidden > total.points / 5 && total.hidden < total.points, "{total:?}");
}
