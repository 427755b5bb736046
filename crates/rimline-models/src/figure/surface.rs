//! A field's zero surface as triangles: surface nets (Gibson 1998) on a grid, then vertices evened out over the surface.
//!
//! Quads between cells meet in pairs as long as no grid square has its corners inside and outside by turns; the field
//! is smooth at the grid's scale, and a test checks that the result is closed.

use glam::{IVec3, Vec3};

/// Distance of grid points in metres.
const CELL: f32 = 0.0125;
/// The box that the grid fills; the surface stays inside.
const LOW: Vec3 = Vec3::new(-0.675, -0.05, -0.225);
const POINTS: IVec3 = IVec3::new(109, 149, 37);
/// Rounds of evening out.
const ROUNDS: usize = 8;

/// Vertices and counter-clockwise triangles around where `field` is negative.
pub(super) fn polygonise(field: impl Fn(Vec3) -> f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let grid = Grid::sample(&field);
    let (mut vertices, cell_vertex) = grid.vertices();
    let quads = grid.quads(&cell_vertex);
    for _ in 0..ROUNDS {
        even_out(&field, &mut vertices, &quads);
    }
    let faces = quads.iter().flat_map(|&quad| split(&vertices, quad)).collect();
    (vertices, faces)
}

/// The field's direction of ascent.
pub(super) fn gradient(field: &impl Fn(Vec3) -> f32, point: Vec3) -> Vec3 {
    const STEP: f32 = 1e-3;
    let along = |axis: Vec3| (field(point + axis * STEP) - field(point - axis * STEP)) / (2.0 * STEP);
    Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z))
}

struct Grid(Vec<f32>);

impl Grid {
    fn sample(field: &impl Fn(Vec3) -> f32) -> Self {
        Self(points().map(|point| field(grid_position(point))).collect())
    }

    fn at(&self, point: IVec3) -> f32 {
        self.0[index(point)]
    }

    /// A vertex in each cell that the surface crosses, at the middle of its crossings with the cell's edges, and each
    /// cell's vertex.
    fn vertices(&self) -> (Vec<Vec3>, Vec<Option<u32>>) {
        let mut vertices = Vec::new();
        let cells = points().map(|cell| {
            if !(cell + 1).cmplt(POINTS).all() {
                return None;
            }
            let (mut sum, mut crossings) = (Vec3::ZERO, 0.0);
            for (from, to) in cell_edges(cell) {
                let (a, b) = (self.at(from), self.at(to));
                if (a < 0.0) != (b < 0.0) {
                    sum += grid_position(from).lerp(grid_position(to), a / (a - b));
                    crossings += 1.0;
                }
            }
            (crossings > 0.0).then(|| {
                vertices.push(sum / crossings);
                vertices.len() as u32 - 1
            })
        });
        let cells = cells.collect();
        (vertices, cells)
    }

    /// A quad around each grid edge that the surface crosses, between the vertices of the four cells at that edge.
    fn quads(&self, cell_vertex: &[Option<u32>]) -> Vec<[u32; 4]> {
        let mut quads = Vec::new();
        for point in points() {
            for axis in 0..3 {
                let [along, right, up] = [0, 1, 2].map(|turn| IVec3::AXES[(axis + turn) % 3]);
                let inner = (point + along).cmplt(POINTS).all() && (point - right - up).cmpge(IVec3::ZERO).all();
                if !inner || (self.at(point) < 0.0) == (self.at(point + along) < 0.0) {
                    continue;
                }
                let cells = [point, point - right, point - right - up, point - up];
                let corners = cells.map(|cell| cell_vertex[index(cell)]);
                if let [Some(a), Some(b), Some(c), Some(d)] = corners {
                    let outwards = self.at(point) < 0.0;
                    quads.push(if outwards { [a, b, c, d] } else { [d, c, b, a] });
                }
            }
        }
        quads
    }
}

/// Moves every vertex halfway to the middle of its neighbours, then back onto the surface.
fn even_out(field: &impl Fn(Vec3) -> f32, vertices: &mut [Vec3], quads: &[[u32; 4]]) {
    let mut sums = vec![(Vec3::ZERO, 0.0); vertices.len()];
    for quad in quads {
        for corner in 0..4 {
            let (from, to) = (quad[corner] as usize, quad[(corner + 1) % 4] as usize);
            sums[from].0 += vertices[to];
            sums[from].1 += 1.0;
        }
    }
    for (vertex, (sum, count)) in vertices.iter_mut().zip(sums) {
        *vertex = vertex.lerp(sum / count, 0.5);
        for _ in 0..2 {
            let slope = gradient(field, *vertex);
            *vertex -= slope * (field(*vertex) / slope.length_squared().max(0.1));
        }
    }
}

/// Two triangles, along the shorter diagonal.
fn split(vertices: &[Vec3], [a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    let length = |from: u32, to: u32| vertices[from as usize].distance_squared(vertices[to as usize]);
    if length(a, c) <= length(b, d) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
}

fn points() -> impl Iterator<Item = IVec3> {
    (0..POINTS.z).flat_map(|z| (0..POINTS.y).flat_map(move |y| (0..POINTS.x).map(move |x| IVec3::new(x, y, z))))
}

fn index(point: IVec3) -> usize {
    ((point.z * POINTS.y + point.y) * POINTS.x + point.x) as usize
}

fn grid_position(point: IVec3) -> Vec3 {
    LOW + point.as_vec3() * CELL
}

fn cell_edges(cell: IVec3) -> impl Iterator<Item = (IVec3, IVec3)> {
    (0..3).flat_map(move |axis| {
        let [along, right, up] = [0, 1, 2].map(|turn| IVec3::AXES[(axis + turn) % 3]);
        [cell, cell + right, cell + up, cell + right + up].map(|from| (from, from + along))
    })
}
