//! Generated shapes are what their documentation says: counts, closedness, Euler characteristic, orientation.

use rimline::mesh::EdgeCounts;
use rimline_bench::shapes::{self, Shape};

/// The signed volume, by the divergence theorem: positive where faces are counter-clockwise, seen from outside.
fn volume(shape: &Shape) -> f64 {
    let at = |v: u32| shape.positions[v as usize].map(f64::from);
    let six: f64 = shape
        .faces
        .iter()
        .map(|&[a, b, c]| {
            let ([ax, ay, az], [bx, by, bz], [cx, cy, cz]) = (at(a), at(b), at(c));
            ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
        })
        .sum();
    six / 6.0
}

fn euler(shape: &Shape) -> i64 {
    let edges = shape.mesh().expect("a mesh").edges().len() as i64;
    shape.positions.len() as i64 - edges + shape.faces.len() as i64
}

fn assert_closed(name: &str, shape: &Shape, expected_euler: i64, expected_volume: f64, tolerance: f64) {
    let mesh = shape.mesh().expect("a mesh");
    assert!(mesh.is_closed(), "{name}: {:?}", mesh.edges().counts());
    assert_eq!(mesh.edges().len() * 2, shape.faces.len() * 3, "{name}");
    assert_eq!(mesh.degenerate_faces(), 0, "{name}");
    assert_eq!(euler(shape), expected_euler, "{name}");
    let volume = volume(shape);
    assert!((volume - expected_volume).abs() <= tolerance, "{name}: volume {volume}");
}

fn counts(shape: &Shape) -> EdgeCounts {
    shape.mesh().expect("a mesh").edges().counts()
}

#[test]
fn closed_shapes_are_closed_and_turned_outwards() {
    let pi = std::f64::consts::PI;
    assert_closed("cube", &shapes::cube(), 2, 8.0, 0.0);
    assert_closed("fan", &shapes::fan(1000), 2, pi / 3.0, 1e-4);
    assert_closed("octahedron", &shapes::sphere(1), 2, 4.0 / 3.0, 1e-6);
    assert_closed("sphere", &shapes::sphere(40), 2, 4.0 / 3.0 * pi, 0.01);
    let torus = shapes::torus(96, 64, 2.0, 0.5);
    assert_closed("torus", &torus, 0, 2.0 * pi * pi * 2.0 * 0.25, 0.05);
    for seed in 0..20 {
        let blob = shapes::blob(17, 0.9, seed);
        assert_closed("blob", &blob, 2, 5.0, 4.9);
    }
}

#[test]
fn counts_are_those_documented() {
    let torus = shapes::torus(1024, 512, 1.0, 0.25);
    assert_eq!(torus.faces.len(), 1_048_576);
    assert_eq!(shapes::sphere(9).faces.len(), 8 * 81);
    assert_eq!(shapes::fan(77).faces.len(), 154);
}

#[test]
fn open_shapes_have_the_records_documented() {
    let grid = shapes::plane_grid(7, 4);
    assert_eq!((grid.faces.len(), euler(&grid)), (56, 1));
    assert_eq!((counts(&grid).boundary, counts(&grid).inconsistent), (22, 0));
    let up = shapes::plane_grid(1, 1);
    let [a, b, c] = up.faces[0].map(|v| up.positions[v as usize]);
    assert!((b[2] - a[2]) * (c[0] - a[0]) - (b[0] - a[0]) * (c[2] - a[2]) > 0.0, "faces +Y");

    for (segments, strips) in [(3, 1), (50, 4), (51, 7)] {
        let strip = shapes::moebius(segments, strips);
        assert_eq!(strip.faces.len() as u32, 2 * segments * strips);
        assert_eq!(euler(&strip), 0);
        let counts = counts(&strip);
        assert_eq!(counts.boundary as u32, 2 * segments);
        assert_eq!(counts.inconsistent as u32, strips);
    }

    let sheets = shapes::three_sheets(6);
    assert_eq!(sheets.faces.len(), 36);
    // Each of the six edges on the line has a consistent and a boundary record; each sheet has its far side, two ends, and
    // inner edges of its own.
    let expected = EdgeCounts { consistent: 6 + 3 * (5 + 6), inconsistent: 0, boundary: 6 + 3 * (6 + 2) };
    assert_eq!(counts(&sheets), expected);
}

#[test]
fn sizes_out_of_range_are_clamped() {
    assert_eq!(shapes::torus(0, 1, 1.0, 0.5), shapes::torus(3, 3, 1.0, 0.5));
    assert_eq!(shapes::sphere(0), shapes::sphere(1));
    assert_eq!(shapes::plane_grid(0, 0), shapes::plane_grid(1, 1));
    assert_eq!(shapes::moebius(0, 0), shapes::moebius(3, 1));
    assert_eq!(shapes::three_sheets(0), shapes::three_sheets(1));
    assert_eq!(shapes::fan(2), shapes::fan(3));
    assert_eq!(shapes::blob(3, f32::NAN, 1), shapes::sphere(3));
    assert_eq!(shapes::blob(3, -1.0, 1), shapes::sphere(3));
    assert_eq!(shapes::blob(3, 7.0, 1), shapes::blob(3, 0.9, 1));
}

#[test]
fn blobs_keep_to_their_radii_and_differ_by_seed() {
    let blob = shapes::blob(30, 0.5, 3);
    let radii: Vec<f32> = blob.positions.iter().map(|[x, y, z]| (x * x + y * y + z * z).sqrt()).collect();
    assert!(radii.iter().all(|r| (0.499..=1.501).contains(r)));
    let spread = radii.iter().fold(0.0_f32, |most, r| most.max((r - 1.0).abs()));
    assert!(spread > 0.15, "lumps of {spread}");
    assert_ne!(blob, shapes::blob(30, 0.5, 4));
}

#[test]
fn shuffling_renumbers_and_keeps_the_surface() {
    let torus = shapes::torus(20, 10, 1.0, 0.25);
    let shuffled = torus.shuffled(5);
    assert_ne!(shuffled, torus);
    assert_eq!(shuffled, torus.shuffled(5));
    assert_closed("shuffled", &shuffled, 0, volume(&torus), 1e-9);
    let surface = |shape: &Shape| {
        let mut faces: Vec<_> =
            shape.faces.iter().map(|face| face.map(|v| shape.positions[v as usize].map(f32::to_bits))).collect();
        faces.sort_unstable();
        faces
    };
    assert_eq!(surface(&shuffled), surface(&torus));
}
