//! Drawings against pictures of rays: visible lines lie where a picture of the faces has an edge, and no edge of it is without one.

use std::ops::ControlFlow;

use rimline_lines::{LineOptions, Object, Span, View, draw};

use crate::support::shapes::{Shape, cuboid, moved, torus};

/// Pixels along a side.
const SIDE: usize = 160;
/// The page from −REACH to REACH.
const REACH: f64 = 2.2;
const PIXEL: f64 = 2.0 * REACH / SIDE as f64;

/// The first hit of a pixel's ray: its depth, and the normal there.
type Hit = Option<(f64, [f64; 3])>;

fn dot(u: [f64; 3], v: [f64; 3]) -> f64 {
    u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
}

/// The nearest faces at the middles of all pixels, of an orthographic view.
fn picture(shapes: &[Shape], view: &View) -> Vec<Hit> {
    let mut picture: Vec<Hit> = vec![None; SIDE * SIDE];
    for Shape { positions, mesh } in shapes {
        for face in mesh.faces() {
            let points = face.map(|vertex| positions[vertex as usize].map(f64::from));
            let [[ax, ay], [bx, by], [cx, cy]] = points.map(|point| view.page(point));
            let depths = points.map(|point| view.depth(point));
            let [u, v] = [points[1], points[2]].map(|p| [0, 1, 2].map(|axis| p[axis] - points[0][axis]));
            let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let normal = n.map(|c| c / dot(n, n).sqrt());
            let area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
            let pixels = |low: f64, high: f64| pixel(low)..(pixel(high) + 1).min(SIDE);
            for row in pixels(ay.min(by).min(cy), ay.max(by).max(cy)) {
                for column in pixels(ax.min(bx).min(cx), ax.max(bx).max(cx)) {
                    let [x, y] = [column, row].map(|at| (at as f64 + 0.5) * PIXEL - REACH);
                    let s = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area;
                    let t = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area;
                    let depth = depths[0] + s * (depths[1] - depths[0]) + t * (depths[2] - depths[0]);
                    let at = &mut picture[row * SIDE + column];
                    if s >= 0.0 && t >= 0.0 && s + t <= 1.0 && at.is_none_or(|(nearest, _)| depth < nearest) {
                        *at = Some((depth, normal));
                    }
                }
            }
        }
    }
    picture
}

fn pixel(c: f64) -> usize {
    (((c + REACH) / PIXEL).floor().max(0.0) as usize).min(SIDE - 1)
}

/// Whether two pixels beside each other have an edge between them: a face and none, a jump in depth, or faces at an angle.
fn is_edge(one: Hit, other: Hit, steepest: f64, least_cosine: f64) -> bool {
    match (one, other) {
        (None, None) => false,
        (Some((depth, normal)), Some((other_depth, other_normal))) => {
            (depth - other_depth).abs() > steepest * PIXEL || dot(normal, other_normal).abs() < least_cosine
        }
        _ => true,
    }
}

/// How far a point of the page is from a span.
fn distance(span: &Span, [x, y]: [f64; 2]) -> f64 {
    let [[ax, ay], [bx, by]] = span.page;
    let (dx, dy) = (bx - ax, by - ay);
    let along = (((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
    (x - ax - along * dx).hypot(y - ay - along * dy)
}

/// The visible spans of a drawing with an edge of the picture beside each of their points, and how many points have none. Then
/// the edges of the picture, and how many of them are farther than two pixels from all those spans.
fn compare(picture: &[Hit], visible: &[&Span]) -> [usize; 4] {
    let [mut points, mut stray, mut edges, mut missing] = [0; 4];
    let at = |column: usize, row: usize| picture[row.min(SIDE - 1) * SIDE + column.min(SIDE - 1)];
    for span in visible {
        for step in 0..8 {
            let share = (f64::from(step) + 0.5) / 8.0;
            let [column, row] =
                [0, 1].map(|axis| pixel(span.page[0][axis] + share * (span.page[1][axis] - span.page[0][axis])));
            let mut near =
                (0..25).map(|near| (column + near % 5, row + near / 5)).map(|(x, y)| (x.max(2) - 2, y.max(2) - 2));
            let here = at(column, row);
            points += 1;
            // Where an outline of a smooth surface ends, the surface is seen from its side, and nothing jumps yet.
            let is_grazing =
                |(column, row): (usize, usize)| at(column, row).is_none_or(|(_, n)| dot(n, VIEW).abs() < 0.4);
            stray += usize::from(!near.any(|(x, y)| is_grazing((x, y)) || is_edge(here, at(x, y), 4.0, 0.9)));
        }
    }
    for (column, row) in (0..SIDE - 1).flat_map(|column| (0..SIDE - 1).map(move |row| (column, row))) {
        for (next_column, next_row) in [(column + 1, row), (column, row + 1)] {
            if is_edge(at(column, row), at(next_column, next_row), 20.0, 0.2) {
                let middle = [column + next_column, row + next_row].map(|sum| (0.5 * sum as f64 + 0.5) * PIXEL - REACH);
                edges += 1;
                missing += usize::from(!visible.iter().any(|span| distance(span, middle) < 2.0 * PIXEL));
            }
        }
    }
    [points, stray, edges, missing]
}

/// Towards the eye of the pictures, of length 1.
const VIEW: [f64; 3] = [6.0 / 7.0, 3.0 / 7.0, 2.0 / 7.0];

/// No visible line is where a picture has no edge, and no edge of it is farther than two pixels from a line.
#[test]
fn lines_are_where_pictures_have_edges() {
    let view = View::orthographic([6.0, 3.0, 2.0], [0.0, 0.0, 1.0]).expect("a view");
    let turned = moved(&cuboid([-0.7; 3], [0.7; 3]), |[x, y, z]| [0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y + 0.3 * z, z]);
    let models = [
        vec![torus(96, 48)],
        vec![torus(96, 48), moved(&torus(96, 48), |[x, y, z]| [x + 0.5, z, y])],
        vec![turned, cuboid([-0.3, -0.3, -1.5], [0.3, 0.3, 1.5])],
    ];
    for shapes in models {
        let objects: Vec<_> = shapes.iter().map(|shape| Object::new(&shape.mesh, &shape.positions)).collect();
        let options = LineOptions::default();
        let drawing = draw(&objects, &view, &options, |_, _| ControlFlow::Continue(())).expect("drawn");
        let picture = picture(&shapes, &view);
        let visible: Vec<_> = drawing.spans.iter().filter(|span| span.faces_in_front == 0).collect();
        let [points, stray, edges, missing] = compare(&picture, &visible);
        println!("{points} points of lines, {stray} stray; {edges} edges of the picture, {missing} without a line");
        assert!(points > 50 && stray == 0 && edges > 200 && missing == 0);
        // Hidden lines lie where there are no edges, and edges are missed without an outline.
        let hidden: Vec<_> = drawing.spans.iter().filter(|span| span.faces_in_front > 0).collect();
        let [_, stray, _, missing] = compare(&picture, &hidden);
        assert!(stray > 0 && missing > 0, "a control");
    }
}
