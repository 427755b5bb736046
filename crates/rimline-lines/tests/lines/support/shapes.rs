//! Models made by code.

use rimline::Mesh;
use rimline::mesh::{PolygonLoops, Weld};

use super::Random;

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

/// A torus around the y axis, as quadrilaterals of vertices in a grid.
fn torus_quads(rings: u32, segments: u32) -> (Vec<[f32; 3]>, Vec<[u32; 4]>) {
    let angle = |at: u32, of: u32| at as f32 / of as f32 * std::f32::consts::TAU;
    let (mut positions, mut quads) = (Vec::new(), Vec::new());
    for (ring, v) in (0..rings).flat_map(|ring| (0..segments).map(move |segment| (ring, segment))) {
        let (around, about) = (angle(ring, rings), angle(v, segments));
        let radius = 1.0 + 0.4 * about.cos();
        positions.push([radius * around.cos(), 0.4 * about.sin(), radius * around.sin()]);
        let (here, there, w) = (ring * segments, (ring + 1) % rings * segments, (v + 1) % segments);
        quads.push([here + v, here + w, there + w, there + v]);
    }
    (positions, quads)
}

pub(crate) fn torus(rings: u32, segments: u32) -> Shape {
    let (positions, quads) = torus_quads(rings, segments);
    let faces: Vec<_> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    shape(positions, &faces)
}

/// A torus of quadrilaterals whose corners are moved at random, so that none is planar.
pub(crate) fn bumpy_torus(rings: u32, segments: u32, bump: f32) -> Shape {
    let (mut positions, quads) = torus_quads(rings, segments);
    let mut random = Random::new(5);
    positions.iter_mut().flatten().for_each(|c| *c += random.between(-bump, bump));
    polygons(positions, &quads.iter().map(|quad| quad.to_vec()).collect::<Vec<_>>())
}

/// A ball of meridians and parallels.
pub(crate) fn ball(meridians: u32, parallels: u32) -> Shape {
    let angle = |at: u32, of: u32| at as f32 / of as f32 * std::f32::consts::PI;
    let mut positions = vec![[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    let mut faces = Vec::new();
    for (around, down) in (0..meridians).flat_map(|around| (1..parallels).map(move |down| (around, down))) {
        let (u, v) = (angle(2 * around, meridians), angle(down, parallels));
        positions.push([v.sin() * u.cos(), v.sin() * u.sin(), v.cos()]);
    }
    let vertex = |around: u32, down: u32| match down {
        0 => 0,
        _ if down == parallels => 1,
        _ => 2 + around % meridians * (parallels - 1) + down - 1,
    };
    for (around, down) in (0..meridians).flat_map(|around| (0..parallels).map(move |down| (around, down))) {
        let [a, b] = [around, around + 1].map(|around| vertex(around, down));
        let [c, d] = [around, around + 1].map(|around| vertex(around, down + 1));
        faces.extend([[a, c, d], [a, d, b]].into_iter().filter(|&[a, b, c]| a != b && b != c && c != a));
    }
    shape(positions, &faces)
}

/// A mesh that takes each polygon as one face.
pub(crate) fn polygons(positions: Vec<[f32; 3]>, loops: &[Vec<u32>]) -> Shape {
    let (sizes, corners): (Vec<u32>, _) = (loops.iter().map(|one| one.len() as u32).collect(), loops.concat());
    let ones = vec![1; loops.len()];
    let given = PolygonLoops { polygon_loops: &ones, loop_sizes: &sizes, loop_corners: &corners };
    let mesh = Mesh::from_polygons_by_loop(&positions, given, Weld::Position).expect("good polygons");
    Shape { positions, mesh }
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
