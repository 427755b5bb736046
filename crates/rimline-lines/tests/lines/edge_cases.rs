//! Inputs at the border of what can be drawn, options, chains.

use std::collections::BTreeSet;
use std::ops::ControlFlow;

use rimline::cpu::Threads;
use rimline::mesh::Weld;
use rimline::{Light, Mesh, Predicate};
use rimline_lines::{Classes, Drawing, Fault, LineClass, LineOptions, LinesError, Object, PageBox, View, draw};
use rimline_testkit::random::Random;
use rimline_testkit::shapes::globe;

use crate::support::shapes::{Shape, cuboid, moved, of_shape, shape, soup, torus};

fn go_on(_: usize, _: usize) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn objects(shapes: &[Shape]) -> Vec<Object<'_>> {
    shapes.iter().map(|shape| Object::new(&shape.mesh, &shape.positions)).collect()
}

fn drawn(shapes: &[Shape], view: &View) -> Drawing {
    draw(&objects(shapes), view, &LineOptions::default(), go_on).expect("drawn")
}

fn aside() -> View {
    View::orthographic([3.0, 2.0, 1.0], [0.0, 0.0, 1.0]).expect("a view")
}

fn visible(drawing: &Drawing) -> usize {
    drawing.spans.iter().filter(|span| span.faces_in_front == 0).count()
}

/// A box shows nine of its edges: six around, three within.
#[test]
fn box_has_nine_visible_edges() {
    let drawing = drawn(&[cuboid([0.0; 3], [1.0; 3])], &aside());
    assert_eq!((drawing.spans.len(), visible(&drawing)), (12, 9));
    let outline = &drawing.chains[0];
    assert_eq!((outline.class, outline.is_closed, outline.spans.len()), (LineClass::Silhouette, true, 6));
    // From the front its outline is a square, each side of which is drawn once.
    let front = View::orthographic([0.0, -1.0, 0.0], [0.0, 0.0, 1.0]).expect("a view");
    let drawing = drawn(&[cuboid([0.0; 3], [1.0; 3])], &front);
    assert_eq!((drawing.spans.len(), visible(&drawing), drawing.chains.len()), (4, 4, 1));
    // So is that of a row of boxes behind each other, whose lines all lie on those four.
    let boxes: Vec<Shape> = (0..150_u16)
        .map(|number| 2.0 * f32::from(number))
        .map(|y| cuboid([0.0, y, 0.0], [1.0, y + 1.0, 1.0]))
        .collect();
    for boxes in [boxes.clone(), boxes.into_iter().rev().collect()] {
        let drawing = drawn(&boxes, &front);
        assert_eq!((drawing.spans.len(), visible(&drawing)), (4, 4));
    }
}

/// Nothing to draw is an empty drawing.
#[test]
fn empty_models_are_empty_drawings() {
    assert_eq!(drawn(&[], &aside()), Drawing::default());
    let point = shape(vec![[1.0; 3]; 3], &[[0, 1, 2]]);
    let drawing = drawn(&[point], &aside());
    assert!(drawing.spans.is_empty() && drawing.left_out[0].fault == Fault::NoFaces, "{drawing:?}");
    // Nor need it have positions.
    let mesh = Mesh::from_faces(3, vec![[0; 3]]).expect("a mesh");
    let drawing = drawn(&[Shape { positions: Vec::new(), mesh }], &aside());
    assert!(drawing.spans.is_empty() && drawing.left_out[0].fault == Fault::NoFaces, "{drawing:?}");
    // Three vertices at one point that are not welded.
    let positions = vec![[1.0; 3]; 3];
    let mesh = Mesh::new(&positions, &[[0, 1, 2]], Weld::Keep).expect("a mesh");
    let drawing = drawn(&[Shape { positions, mesh }], &aside());
    assert!(drawing.spans.is_empty() && drawing.left_out.is_empty(), "{drawing:?}");
    // Behind the eye.
    let behind = View::perspective([5.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 0.0, 1.0]).expect("a view");
    assert!(drawn(&[torus(8, 6)], &behind).spans.is_empty());
}

/// A face has three edges from both sides, and from its own plane the ones that are not behind others.
#[test]
fn single_face() {
    let face = || [shape(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]])];
    for eye in [[0.2, 0.3, 1.0], [0.2, 0.3, -1.0]] {
        let drawing = drawn(&face(), &View::orthographic(eye, [0.0, 1.0, 0.0]).expect("a view"));
        assert_eq!((drawing.spans.len(), visible(&drawing), drawing.chains[0].is_closed), (3, 3, true));
    }
    let in_plane = View::orthographic([1.0, 1.0, 0.0], [0.0, 0.0, 1.0]).expect("a view");
    let drawing = drawn(&face(), &in_plane);
    let bounds = drawing.bounds(0).expect("lines");
    let length: f64 = drawing.spans.iter().map(|span| (span.page[1][0] - span.page[0][0]).abs()).sum();
    assert!((length - (bounds.high[0] - bounds.low[0])).abs() < 1e-9, "drawn once: {drawing:?}");
}

/// A line is drawn beside an object so far away that points of the page are rounded by more than the line is high.
#[test]
fn objects_far_away_along_the_sight_are_drawn() {
    let near = vec![[0.0; 3], [0.5, 0.0015, 0.0], [0.25, 0.5, 0.0]];
    let far = vec![[0.0, 0.0, -1e12], [1.0, 0.0, -1e12], [0.0, 1.0, -1e12]];
    let view = View::orthographic([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]).expect("a view");
    let drawing = drawn(&[shape(near, &[[0, 1, 2]]), shape(far, &[[0, 1, 2]])], &view);
    assert_eq!((drawing.spans.len(), visible(&drawing)), (6, 6), "{drawing:?}");
}

/// A faulty object is named and left out, and the rest is drawn.
#[test]
fn faulty_objects_are_named() {
    let good = cuboid([0.0; 3], [1.0; 3]);
    let mut bad = cuboid([2.0; 3], [3.0; 3]);
    bad.positions[5][1] = f32::NAN;
    let short = Shape { positions: vec![[0.0; 3]], mesh: good.mesh.clone() };
    let shapes = [bad, good.clone(), short];
    let mut objects = objects(&shapes);
    objects[0].name = "bad".to_owned();
    // An edge that is marked twice is no fault.
    objects[1].marked = vec![[0, 7], [0, 1], [1, 0]];
    let drawing = draw(&objects, &aside(), &LineOptions::default(), go_on).expect("drawn");
    let faults = drawing.left_out.iter().map(|left_out| (left_out.object, &*left_out.name, left_out.fault));
    let expected = [
        (0, "bad", Fault::NotFinite { vertex: 5 }),
        (1, "", Fault::NoSuchEdge { vertices: [0, 7] }),
        (2, "", Fault::TooFewPositions { given: 1, needed: 8 }),
    ];
    assert_eq!(faults.collect::<Vec<_>>(), expected);
    assert!(drawing.spans.iter().all(|span| span.object == 1) && drawing.spans.len() == 12);
}

/// Options out of range are refused, and a caller may end the drawing.
#[test]
fn refusals() {
    let shapes = [torus(24, 14)];
    let all = LineOptions::default();
    let window = Some(PageBox { low: [0.0; 2], high: [1.0, 0.0] });
    for (options, error) in [
        (LineOptions { crease_degrees: f64::NAN, ..all }, "Crease {"),
        (LineOptions { crease_degrees: 181.0, ..all }, "Crease {"),
        (LineOptions { near: Some(0.0), ..all }, "Near {"),
        (LineOptions { window, ..all }, "Window {"),
    ] {
        let refused = draw(&objects(&shapes), &aside(), &options, go_on).expect_err("refused");
        assert!(format!("{refused:?}").starts_with(error), "{refused:?}");
    }
    let small = LineOptions { memory_limit: Some(1000), ..all };
    let refused = draw(&objects(&shapes), &aside(), &small, go_on);
    assert!(matches!(refused, Err(LinesError::Memory { limit: 1000, .. })), "{refused:?}");
    let cancelled = draw(&objects(&shapes), &aside(), &all, |_, _| ControlFlow::Break(()));
    assert_eq!(cancelled, Err(LinesError::Cancelled));
    assert_eq!(View::orthographic([0.0; 3], [0.0, 0.0, 1.0]), Err(LinesError::View));
    assert_eq!(View::orthographic([0.0, 0.0, 1.0], [0.0, 0.0, 2.0]), Err(LinesError::View));
    assert_eq!(View::perspective([1.0; 3], [1.0; 3], [0.0, 0.0, 1.0]), Err(LinesError::View));
}

/// The same drawing with any number of threads.
#[test]
fn threads_change_nothing() {
    let shapes =
        [torus(120, 80), moved(&torus(60, 40), |[x, y, z]| [x + 1.0, z, y]), soup(&mut Random::new(3), 40, 200)];
    let view = View::perspective([3.0, 4.0, 2.0], [0.0; 3], [0.0, 0.0, 1.0]).expect("a view");
    let with = |count| {
        let options = LineOptions { threads: Threads::new(count), crease_degrees: 5.0, ..LineOptions::default() };
        draw(&objects(&shapes), &view, &options, go_on).expect("drawn")
    };
    let one = with(1);
    assert!(one.spans.len() > 2000);
    assert!([2, 3, 8].into_iter().all(|count| with(count) == one));
}

/// Each class is drawn alone, and a class that is off leaves its lines to lower ones.
#[test]
fn classes() {
    let shapes = [cuboid([0.0; 3], [1.0; 3])];
    let with = |classes: Classes, degrees: f64, marked: &[[u32; 2]]| {
        let mut objects = objects(&shapes);
        objects[0].marked = marked.to_vec();
        let options = LineOptions { classes, crease_degrees: degrees, ..LineOptions::default() };
        draw(&objects, &aside(), &options, go_on).expect("drawn").spans.len()
    };
    let only = |class| Classes::NONE.with(class);
    assert_eq!(with(only(LineClass::Silhouette), 30.0, &[]), 6);
    // A box has right angles, exactly.
    assert_eq!(with(only(LineClass::Crease), 90.0, &[]), 12);
    assert_eq!(with(only(LineClass::Crease), 90.0_f64.next_up(), &[]), 0);
    assert_eq!(with(only(LineClass::Crease), 0.0, &[]), 18);
    assert_eq!(with(only(LineClass::Boundary), 30.0, &[]), 0);
    assert_eq!(with(only(LineClass::Marked), 30.0, &[[3, 0]]), 1);
    assert_eq!(with(Classes::NONE, 30.0, &[]), 0);
    // Three faces at one edge.
    let sheets = [shape(
        vec![[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0]],
        &[[0, 1, 2], [0, 1, 3], [0, 1, 4]],
    )];
    let options = LineOptions { classes: only(LineClass::NonManifold), ..LineOptions::default() };
    let drawing = draw(&objects(&sheets), &aside(), &options, go_on).expect("drawn");
    assert!(drawing.spans.iter().all(|span| span.edge == Some(0)) && !drawing.spans.is_empty(), "{drawing:?}");
    // Six boundaries, and an edge that two of the sheets make a silhouette or not.
    let view = View::orthographic([3.0, 2.5, 1.0], [0.0, 0.0, 1.0]).expect("a view");
    let edges: BTreeSet<_> = drawn(&sheets, &view).spans.iter().map(|span| span.edge).collect();
    assert_eq!(edges.len(), 7, "{edges:?}");
}

/// Silhouettes are those of the core, and close; a chain begins where the one before ends.
#[test]
fn silhouettes_close() {
    let shape = torus(60, 40);
    for view in [aside(), View::perspective([2.0, 1.0, 0.5], [0.0; 3], [0.0, 0.0, 1.0]).expect("a view")] {
        let shapes = [shape.clone()];
        let drawing = drawn(&shapes, &view);
        let eye: Light = view.eye();
        let found = rimline::cpu::extract(&shape.positions, &shape.mesh, &[eye], Predicate::Exact, Threads::ONE);
        let silhouette = found.expect("extracted").silhouette(&shape.mesh, 0);
        let mut records: Vec<u32> = drawing.spans.iter().filter_map(|span| span.edge).collect();
        records.sort_unstable();
        records.dedup();
        assert_eq!(records, silhouette.edges().iter().map(|edge| edge.record).collect::<Vec<_>>());
        for chain in &drawing.chains {
            let spans = &drawing.spans[chain.spans.clone()];
            assert!(
                spans.windows(2).all(|pair| pair[0].page[1] == pair[1].page[0] && pair[0].ends[1] == pair[1].ends[0])
            );
            assert_eq!(chain.is_closed, spans[0].ends[0] == spans[spans.len() - 1].ends[1]);
            assert!(spans.iter().all(|span| (span.faces_in_front > 0) == chain.is_hidden && span.class == chain.class));
        }
    }
    // All of a ball's outline is visible: one closed chain.
    let drawing = drawn(&[of_shape(globe(40, 20))], &aside());
    assert!(matches!(&*drawing.chains, [only] if only.is_closed && !only.is_hidden), "{:?}", drawing.chains);
    // The ball is on its left.
    let points = drawing.page_points(&drawing.chains[0]);
    let next = points.iter().cycle().skip(1);
    let area: f64 = points.iter().zip(next).map(|([x, y], [u, v])| 0.5 * (x * v - u * y)).sum();
    assert!((3.0..3.2).contains(&area), "{area}");
}

/// Two surfaces that pass through each other meet in closed lines, also where corners lie on edges; surfaces that touch do not.
#[test]
fn surfaces_meet() {
    let meetings = |shapes: &[Shape]| {
        let options = LineOptions { classes: Classes::NONE.with(LineClass::Intersection), ..LineOptions::default() };
        draw(&objects(shapes), &aside(), &options, go_on).expect("drawn")
    };
    let length = |drawing: &Drawing| -> f64 {
        let length = |[a, b]: [[f64; 3]; 2]| (0..3).map(|axis| (b[axis] - a[axis]).powi(2)).sum::<f64>().sqrt();
        drawing.spans.iter().map(|span| length(span.ends)).sum()
    };
    let column = |low: f32, high: f32| [cuboid([0.0; 3], [1.0; 3]), cuboid([low, low, -1.0], [high, high, 2.0])];
    // The diagonals of the box pass the column's corners, or do not.
    for (low, high) in [(0.25, 0.75), (0.25, 0.625)] {
        let drawing = meetings(&column(low, high));
        assert!((length(&drawing) - 8.0 * f64::from(high - low)).abs() < 1e-9, "{}", length(&drawing));
        assert!(drawing.spans.iter().all(|span| span.faces.iter().all(Option::is_some) && span.edge.is_none()));
    }
    // A box on another one.
    assert!(meetings(&[cuboid([0.0; 3], [1.0; 3]), cuboid([0.25, 0.25, 1.0], [0.75, 0.75, 2.0])]).spans.is_empty());
    assert!(meetings(&[torus(24, 14)]).spans.is_empty());
    let rings = [torus(60, 40), moved(&torus(60, 40), |[x, y, z]| [x + 0.5, z, y])];
    let drawing = meetings(&rings);
    let counts = [drawing.chains.len(), drawing.spans.len()];
    assert!(counts[0] < 20 && counts[1] > 100, "{counts:?} chains and spans");
    // A wall passes through an edge of the floor, in one object and in two.
    let floor = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.5, 0.0], [-1.0, 0.5, 0.0]];
    let wall = [[0.0, -2.0, -1.0], [0.0, 3.0, -1.0], [0.0, 0.5, 2.0]];
    // Another one has an edge there, which has a half of it.
    let with_edge = [[0.0, 0.5, 0.0], [0.0, 1.5, 0.0], [0.0, 1.0, 1.0], [0.0, 1.0, -1.0]];
    for (wall, faces, expected) in
        [(&wall[..], &[[0_u32, 1, 2]][..], 1.0), (&with_edge[..], &[[0, 1, 2], [1, 0, 3]][..], 0.5)]
    {
        let floor_faces = [[0, 2, 1], [0, 1, 3]];
        let moved = faces.iter().map(|face| face.map(|corner| corner + 4));
        let all: Vec<[u32; 3]> = floor_faces.into_iter().chain(moved).collect();
        let both = shape([&floor[..], wall].concat(), &all);
        for shapes in [vec![both], vec![shape(floor.to_vec(), &floor_faces), shape(wall.to_vec(), faces)]] {
            let length = length(&meetings(&shapes));
            assert!((length - expected).abs() < 1e-9, "{length}, expected {expected}");
        }
    }
    // Neighbours that are not welded.
    let [p, q] = [[0.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    let positions = vec![p, q, [1.0, 0.5, 0.0], p, q, [-1.0, 0.5, 0.0]];
    let mesh = Mesh::new(&positions, &[[0, 2, 1], [3, 4, 5]], Weld::Keep).expect("a mesh");
    assert!(meetings(&[Shape { positions, mesh }]).spans.is_empty());
    // A face without an area takes no line of others away, though its vertex, which no other face has, is NaN.
    let ends =
        [[0.0, 0.0, 0.5], [1.0, 0.0, 0.5], [0.4, 1.0, 0.5], [0.5, 0.25, 0.0], [0.5, 0.25, 1.0], [0.5, 0.75, 0.4]];
    for (corner, axis) in (0..8_u8).flat_map(|corner| [0, 1, 2].map(|axis| (corner, axis))) {
        let point = [0, 1, 2].map(|axis| f32::from(corner >> axis & 1));
        let mut crossed = shape([&ends[..], &[point]].concat(), &[[0, 1, 2], [3, 4, 5], [6; 3]]);
        crossed.positions[6][axis] = f32::NAN;
        let length = length(&meetings(&[crossed]));
        assert!((length - 5.0 / 12.0).abs() < 1e-6, "corner {corner}, axis {axis}: {length}");
    }
}

/// A mesh whose faces are there twice is drawn as if they were there once, both ways around, in one object and in two.
#[test]
fn doubled_faces_are_drawn_as_one() {
    let torus = torus(24, 14);
    let turned = |&[a, b, c]: &[u32; 3]| [a, c, b];
    let options = LineOptions { crease_degrees: 25.0, ..LineOptions::default() };
    let lines = |shapes: &[Shape]| {
        let drawing = draw(&objects(shapes), &aside(), &options, go_on).expect("drawn");
        let visible = drawing.spans.iter().filter(|span| span.faces_in_front == 0);
        let mut lines: Vec<_> = visible
            .map(|span| {
                let mut ends = span.page.map(|end| end.map(|c| (c * 1e6).round() as i64));
                ends.sort_unstable();
                (span.class, ends)
            })
            .collect();
        lines.sort_unstable();
        lines
    };
    let once = lines(std::slice::from_ref(&torus));
    assert!(once.len() > 60 && once.iter().any(|(class, _)| *class == LineClass::Crease));
    let faces = torus.mesh.faces();
    let twice = [faces.to_vec(), faces.to_vec()].concat();
    let two_sided = [faces.to_vec(), faces.iter().map(turned).collect()].concat();
    for faces in [twice, two_sided] {
        assert_eq!(lines(&[shape(torus.positions.clone(), &faces)]), once);
    }
    assert_eq!(lines(&[torus.clone(), torus.clone()]), once);
    // A third face that stands on the surface is one of three half-planes.
    let [a, b, _] = faces[0];
    let mut positions = torus.positions.clone();
    positions.push([0.0, 9.0, 0.0]);
    let faces = [faces.to_vec(), faces.to_vec(), vec![[a, b, positions.len() as u32 - 1]]].concat();
    assert!(lines(&[shape(positions, &faces)]).iter().any(|(class, _)| *class == LineClass::NonManifold));
}

/// Edges of faces that are there both ways around are those of one surface, also where the eye sees faces edge-on.
#[test]
fn doubled_faces_edge_on() {
    let Shape { positions, mesh } = cuboid([0.0; 3], [1.0; 3]);
    let turned = mesh.faces().iter().map(|&[a, b, c]| [a, c, b]);
    let faces: Vec<_> = mesh.faces().iter().copied().chain(turned).collect();
    let front = View::orthographic([0.0, -1.0, 0.0], [0.0, 0.0, 1.0]).expect("a view");
    let drawing = drawn(&[shape(positions, &faces)], &front);
    let outline = drawing.spans.iter().filter(|span| span.class == LineClass::Silhouette && span.faces_in_front == 0);
    assert_eq!((drawing.spans.len(), outline.count()), (4, 4), "{drawing:?}");
}

/// Lines end at the window and at the near plane.
#[test]
fn windows_cut_lines() {
    let shapes = [torus(24, 14)];
    let window = PageBox { low: [-0.5, -0.25], high: [1.0, 0.5] };
    for view in [aside(), View::perspective([0.5, 0.1, 0.2], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]).expect("a view")] {
        let options = LineOptions { window: Some(window), crease_degrees: 1.0, ..LineOptions::default() };
        let drawing = draw(&objects(&shapes), &view, &options, go_on).expect("drawn");
        let bounds = drawing.bounds(u32::MAX).expect("lines");
        let is_within =
            |axis: usize| bounds.low[axis] > window.low[axis] - 1e-9 && bounds.high[axis] < window.high[axis] + 1e-9;
        assert!(is_within(0) && is_within(1), "{bounds:?}");
    }
}

/// Lines that reach behind the eye are cut, not lost, where the near plane is nearer than depths are rounded.
#[test]
fn near_planes_below_the_rounding_of_depths_cut_lines() {
    let shapes = [shape(vec![[-1.0, 0.3, -0.2], [3.0, 0.4, -0.1], [2.0, -0.5, -0.3]], &[[0, 1, 2]])];
    let view = View::perspective([0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]).expect("a view");
    for near in [1e-6, 1e-30, 1e-300] {
        let options = LineOptions { near: Some(near), ..LineOptions::default() };
        let drawing = draw(&objects(&shapes), &view, &options, go_on).expect("drawn");
        let edges: BTreeSet<_> = drawing.spans.iter().map(|span| span.edge).collect();
        assert_eq!(edges.len(), 3, "{near}: {drawing:?}");
        assert!(drawing.spans.iter().flat_map(|span| span.page).flatten().all(f64::is_finite), "{near}: {drawing:?}");
    }
}

/// A line that an edge crosses at next to no angle is cut where integers say: numbers in `f64` lose all but a few digits there.
#[test]
fn cuts_at_small_angles() {
    // Neighbours among Fibonacci's numbers make determinants of 1.
    let eye = [1_048_573.0, 1_048_571.0, 1_048_561.0];
    let above = |[x, y]: [f32; 2]| [x + eye[0], y + eye[1], eye[2]];
    let roof = [[0.0; 2], [2_178_309.0, 1_346_269.0], [-1_346_269.0, 2_178_309.0]].map(above);
    let [a, b] = [[1_347_256.0, 832_650.0, 0.0], [1_343_308.0, 830_210.0, 0.0_f32]];
    let below = vec![a, b, [a[0], a[1], -1e6]];
    let shapes = [shape(roof.to_vec(), &[[0, 1, 2]]), shape(below, &[[0, 1, 2]])];
    let drawing = drawn(&shapes, &View::orthographic(eye, [0.0, 0.0, 1.0]).expect("a view"));
    let edge = drawing.spans.iter().filter(|span| (span.object, span.edge) == (1, Some(0)));
    let hidden: Vec<_> = edge.filter(|span| span.faces_in_front == 1).collect();
    let [only] = &*hidden else { panic!("{drawing:?}") };
    let shares = only.ends.map(|end| (end[0] - f64::from(a[0])) / f64::from(b[0] - a[0]));
    let cut = shares[0].max(shares[1]);
    assert!((cut - 986.0 / 3948.0).abs() < 1e-8 && shares[0].min(shares[1]) == 0.0, "{shares:?}");
}
