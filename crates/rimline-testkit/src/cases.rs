//! Meshes of every topology, and positions at every scale.

use crate::shapes::{self, Shape};
use rimline::mesh::{PolygonLoops, Weld};
use rimline::{Light, Mesh};

use super::random::Random;

/// A named mesh with its positions.
pub type Case = (String, Vec<[f32; 3]>, Mesh);

/// A case of a shape whose equal positions are welded.
pub fn case(name: impl Into<String>, shape: Shape) -> Case {
    let mesh = Mesh::new(&shape.positions, &shape.faces, Weld::Position).expect("a shape is a mesh");
    (name.into(), shape.positions, mesh)
}

/// Shapes of every topology: closed, open, non-orientable, non-manifold, with faces that name a vertex twice.
pub fn topologies() -> Vec<Case> {
    let mut soup = shapes::torus(12, 9, 1.0, 0.4);
    let mut random = Random::new(7);
    for _ in 0..60 {
        soup.faces.push(std::array::from_fn(|_| random.below(24) as u32));
    }
    vec![
        case("torus", shapes::torus(40, 30, 1.0, 0.4)),
        case("blob", shapes::blob(4, 0.3, 1)),
        case("grid", shapes::plane_grid(17, 9)),
        case("moebius", shapes::moebius(40, 4)),
        case("three sheets", shapes::three_sheets(5)),
        case("soup", soup),
    ]
}

/// Three corners, of a triangle or of [`without_extent`].
pub const CORNERS: [[f32; 3]; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// Meshes whose only face has no extent, and so no edge: a face of one vertex; an edge walked both ways and a hole that is
/// its loop, each as triangles and then as a polygon.
pub fn without_extent() -> [Mesh; 5] {
    let walked_back = PolygonLoops { polygon_loops: &[1], loop_sizes: &[4], loop_corners: &[0, 1, 1, 0] };
    let filled = PolygonLoops { polygon_loops: &[2], loop_sizes: &[3, 3], loop_corners: &[0, 1, 2, 2, 1, 0] };
    [
        Mesh::from_faces(1, vec![[0; 3]]),
        Mesh::from_polygons(&CORNERS, walked_back, Weld::Keep),
        Mesh::from_polygons_by_loop(&CORNERS, walked_back, Weld::Keep),
        Mesh::from_polygons(&CORNERS, filled, Weld::Keep),
        Mesh::from_polygons_by_loop(&CORNERS, filled, Weld::Keep),
    ]
    .map(|mesh| mesh.expect("a face without extent is one"))
}

/// Faces over a few random vertices: most edges have many faces, some faces are duplicates, some degenerate.
pub fn random_soup(random: &mut Random) -> Shape {
    let vertices = 3 + random.below(20);
    let faces = 1 + random.below(200);
    let mut shape = Shape {
        positions: (0..vertices).map(|_| random.direction()).collect(),
        faces: (0..faces).map(|_| std::array::from_fn(|_| random.below(vertices) as u32)).collect(),
    };
    for _ in 0..random.below(8) {
        let face = shape.faces[random.below(faces)];
        let [a, b, c] = face;
        shape.faces.push(if random.below(2) == 0 { face } else { [c, b, a] });
    }
    shape
}

/// Positions and lights that are hard on f32: far from the origin, tiny, huge, flat and tilted with lights in its plane.
pub fn hard_positions(random: &mut Random) -> Vec<(String, Case, Vec<Light>)> {
    let mut found = Vec::new();
    for (name, scale, offset) in [
        ("unit", 1.0, 0.0),
        ("moved by 1e4", 1.0, 1e4),
        ("moved by 1e6", 1.0, 1e6),
        ("moved by 1e5", 1.0, 1e5),
        ("scaled by 1e-7", 1e-7, 0.0),
        ("scaled by 1e-15", 1e-15, 0.0),
        ("scaled by 1e-40", 1e-40, 0.0),
        ("scaled by 1e6", 1e6, 0.0),
        ("scaled by 9e11", 9e11, 0.0),
        ("scaled by 1e20", 1e20, 0.0),
    ] {
        for shape in [shapes::torus(20, 14, 0.7, 0.3), shapes::blob(9, 0.4, 3)] {
            let shape = shape.placed(|position| position.map(|c| c * scale + offset));
            let lights = (0..33)
                .map(|index| {
                    let near = random.direction().map(|c| c * random.between(0.1, 3.0) * scale + offset);
                    let w = random.between(0.2, 5.0);
                    match index % 4 {
                        0 => Light::directional(random.direction()),
                        1 => Light::homogeneous([near[0] * w, near[1] * w, near[2] * w, w]),
                        2 => Light::homogeneous([-near[0] * w, -near[1] * w, -near[2] * w, -w]),
                        _ => Light::point(near),
                    }
                })
                .collect();
            found.push((name.to_owned(), case(name, shape), lights));
        }
    }
    found.push(tilted_plate(random));
    found
}

/// A flat plate, tilted, with lights on it and in its plane: every bit hangs on the last digits.
fn tilted_plate(random: &mut Random) -> (String, Case, Vec<Light>) {
    let tilt = |[x, _, z]: [f32; 3]| [x + 0.1 * z, 0.3 * x - 0.7 * z, z - 0.2 * x];
    let plate = shapes::plane_grid(16, 16).placed(tilt);
    let lights = (0..33).map(|index| {
        let on_plane = tilt([random.between(-3.0, 3.0), 0.0, random.between(-3.0, 3.0)]);
        match index % 3 {
            0 => Light::directional(on_plane),
            1 => Light::homogeneous([on_plane[0] * 1.7, on_plane[1] * 1.7, on_plane[2] * 1.7, 1.7]),
            _ => Light::point(on_plane),
        }
    });
    let lights = lights.collect();
    ("tilted plate".to_owned(), case("tilted plate", plate), lights)
}
