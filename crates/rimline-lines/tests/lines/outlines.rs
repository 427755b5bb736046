//! Outlines and their areas.

use std::f64::consts::TAU;

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::overlay::FloatOverlay;
use rimline_lines::{Fault, LineOptions, Object, Outlines, View, outlines};
use rimline_testkit::random::Random;

use crate::support::shapes::{Shape, bumpy_torus, cuboid, moved, shape, soup, torus};

fn outlined(shapes: &[Shape], view: &View) -> Outlines {
    let objects: Vec<_> = shapes.iter().map(|shape| Object::new(&shape.mesh, &shape.positions)).collect();
    outlines(&objects, view, &LineOptions::default()).expect("outlined")
}

/// The area of all triangles of the page, united one by one.
fn area_of_triangles(shapes: &[Shape], view: &View) -> f64 {
    let mut triangles = Vec::new();
    for Shape { positions, mesh } in shapes {
        for face in mesh.faces() {
            let mut points = face.map(|vertex| view.page(positions[vertex as usize].map(f64::from))).to_vec();
            let [[ax, ay], [bx, by], [cx, cy]] = [points[0], points[1], points[2]];
            if (bx - ax) * (cy - ay) < (cx - ax) * (by - ay) {
                points.reverse();
            }
            triangles.push(points);
        }
    }
    let shapes = FloatOverlay::<[f64; 2]>::with_subj(&triangles).overlay(OverlayRule::Subject, FillRule::NonZero);
    let area = |points: &Vec<[f64; 2]>| -> f64 {
        let next = points.iter().cycle().skip(1);
        points.iter().zip(next).map(|([x, y], [u, v])| 0.5 * (x * v - u * y)).sum()
    };
    shapes.iter().flatten().map(area).sum()
}

/// A torus from above is a ring, and overlaps count once.
#[test]
fn areas_of_known_shapes() {
    let above = View::orthographic([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]).expect("a view");
    let found = outlined(&[torus(48, 24)], &above);
    let ring = |radius: f64| 0.5 * 48.0 * (TAU / 48.0).sin() * radius * radius;
    let [polygon] = &*found.all.polygons else { panic!("{found:?}") };
    assert_eq!((polygon.holes.len(), found.objects.len()), (1, 1));
    assert!((found.all.area - (ring(1.4) - ring(0.6))).abs() < 1e-5, "{}", found.all.area);
    let unit = cuboid([0.0; 3], [1.0; 3]);
    let beside = moved(&unit, |[x, y, z]| [x + 0.5, y, z]);
    let found = outlined(&[unit.clone(), unit, beside], &above);
    assert!(found.objects.iter().all(|outline| (outline.area - 1.0).abs() < 1e-8), "{found:?}");
    assert!((found.all.area - 1.5).abs() < 1e-8 && found.all.polygons.len() == 1, "{found:?}");
}

/// Outlines have the area of all triangles together: closed meshes and open ones, polygons that are not planar, any faces.
#[test]
fn areas_are_those_of_all_triangles() {
    let mut random = Random::new(6);
    let open = shape(vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 1.0, -0.5]], &[[0, 1, 2], [0, 3, 2]]);
    let tori = [torus(20, 12), moved(&torus(20, 12), |[x, y, z]| [x + 1.0, z, y])];
    let models = [vec![open], tori.to_vec(), vec![bumpy_torus(12, 8, 0.1)], vec![soup(&mut random, 20, 30)]];
    for shapes in models {
        for view in [
            View::orthographic([3.0, 2.0, 1.0], [0.0, 0.0, 1.0]).expect("a view"),
            View::perspective([6.0, 4.0, 5.0], [0.0; 3], [0.0, 0.0, 1.0]).expect("a view"),
        ] {
            let (found, expected) = (outlined(&shapes, &view).all.area, area_of_triangles(&shapes, &view));
            assert!((found - expected).abs() < 1e-6 * expected, "{found} is not {expected}");
        }
    }
}

/// An object around the eye has no outline, and others have.
#[test]
fn objects_around_the_eye_have_none() {
    let view = View::perspective([0.5; 3], [5.0, 0.5, 0.5], [0.0, 0.0, 1.0]).expect("a view");
    let found = outlined(&[cuboid([0.0; 3], [1.0; 3]), cuboid([3.0, 0.0, 0.0], [4.0, 1.0, 1.0])], &view);
    assert_eq!((found.left_out[0].object, found.left_out[0].fault), (0, Fault::TooNear));
    assert!(found.objects[0].polygons.is_empty() && (found.all.area - 0.16).abs() < 1e-8, "{found:?}");
}
