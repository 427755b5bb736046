//! Models made by code.

use rimline::Mesh;
use rimline::mesh::Weld;
use rimline_testkit::polygons::quad_torus;
use rimline_testkit::random::Random;
use rimline_testkit::shapes;

/// A mesh with its positions.
#[derive(Clone)]
pub(crate) struct Shape {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) mesh: Mesh,
}

pub(crate) fn shape(positions: Vec<[f32; 3]>, faces: &[[u32; 3]]) -> Shape {
    let mesh = Mesh::new(&positions, faces, Weld::Position).expect("good faces");
    Shape { positions, mesh }
}

/// The same at other positions.
pub(crate) fn moved(shape: &Shape, transform: impl Fn([f32; 3]) -> [f32; 3]) -> Shape {
    Shape { positions: shape.positions.iter().map(|&p| transform(p)).collect(), mesh: shape.mesh.clone() }
}

/// One of the testkit's.
pub(crate) fn of_shape(made: shapes::Shape) -> Shape {
    shape(made.positions, &made.faces)
}

pub(crate) fn torus(rings: u32, segments: u32) -> Shape {
    of_shape(shapes::torus(rings, segments, 1.0, 0.4))
}

/// A torus of quadrilaterals, none of which is planar.
pub(crate) fn bumpy_torus(rings: u32, segments: u32, bump: f32) -> Shape {
    let set = quad_torus(&mut Random::new(5), rings, segments, bump);
    Shape { mesh: set.mesh(Weld::Position).expect("good polygons"), positions: set.positions }
}

/// A box of triangles.
pub(crate) fn cuboid(low: [f32; 3], high: [f32; 3]) -> Shape {
    let positions =
        (0..8).map(|at| [0, 1, 2].map(|axis| if at >> axis & 1 == 0 { low[axis] } else { high[axis] })).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5_u32]];
    let faces: Vec<_> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    shape(positions, &faces)
}

/// Faces over vertices of a small lattice: they touch, overlap and pierce each other, and lie in planes and lines.
pub(crate) fn lattice_soup(random: &mut Random, vertices: usize, faces: usize, reach: usize) -> Shape {
    let mut positions = Vec::new();
    for _ in 0..vertices {
        positions.push([0; 3].map(|_| random.below(reach) as f32));
    }
    let faces: Vec<[u32; 3]> = (0..faces).map(|_| [0; 3].map(|_| random.below(vertices) as u32)).collect();
    shape(positions, &faces)
}

/// Faces over random vertices.
pub(crate) fn soup(random: &mut Random, vertices: usize, faces: usize) -> Shape {
    let positions = (0..vertices).map(|_| [0; 3].map(|_| random.between(-1.0, 1.0))).collect();
    let faces: Vec<[u32; 3]> = (0..faces).map(|_| [0; 3].map(|_| random.below(vertices) as u32)).collect();
    shape(positions, &faces)
}
