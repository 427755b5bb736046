//! The triangles that may hide lines, and where a line looks for them.

use rimline::cpu::Threads;

use crate::cover::Triangle;
use crate::frame::{Frame, Part};
use crate::parallel::ranges;
use crate::tree::{Box3, Row, Tree, bits};
use crate::world::World;

/// Faces or vertices at a time.
const RUN: usize = 1 << 14;

/// A tree of the triangles that may hide a point of these lines.
pub(crate) fn hiders(world: &World<'_>, frame: &Frame, parts: &[Option<Part>], threads: Threads) -> Tree<Triangle> {
    let cells = Cells::new(frame, parts);
    let around = ranges(threads, world.positions.len(), RUN, |range| {
        world.positions[range].iter().map(|&position| frame.bounds_of_vertex(position)).collect::<Vec<_>>()
    });
    let around = around.concat();
    let mut items = Vec::new();
    for placed in &world.placed {
        let mesh = &*placed.object.mesh;
        let polygons = mesh.polygons().map(rimline::mesh::Polygons::triangle_polygons);
        let found = ranges(threads, mesh.faces().len(), RUN, |range| {
            let item = |face: usize| {
                let corners = mesh.faces()[face].map(|vertex| vertex + placed.first_vertex);
                let [a, b, c] = corners.map(|vertex| around[vertex as usize]);
                let around = a.join(b).join(c);
                if !cells.may_be_behind(&around) || is_degenerate(corners) {
                    return None;
                }
                let positions = corners.map(|vertex| world.positions[vertex as usize]);
                let polygon = polygons.as_ref().map_or(Triangle::ALONE, |of| placed.first_face + of[face]);
                let side = world.facing(positions);
                (side != 0).then(|| (around, Triangle::new(corners, polygon, side > 0)))
            };
            range.filter_map(item).collect::<Vec<_>>()
        });
        items.extend(found.into_iter().flatten());
    }
    Tree::new(items.len(), (2, &Box3::UNIT), threads, |at| items[at])
}

fn is_degenerate([a, b, c]: [u32; 3]) -> bool {
    a == b || b == c || c == a
}

/// The boxes of the page that a line meets, and that are not behind it.
pub(crate) struct Reach {
    around: Box3,
    /// A unit vector across the line, and a point of it.
    across: [f32; 2],
    at: [f32; 2],
    /// A bound of the roundings of both, and of the line's own ends.
    error: f32,
}

impl Reach {
    pub(crate) fn new(frame: &Frame, part: &Part) -> Self {
        let [a, b] = part.page;
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let length = (dx * dx + dy * dy).sqrt();
        let (around, across) = (frame.bounds_of_part(part), [(-dy / length) as f32, (dx / length) as f32]);
        // Many times the roundings of `f32`.
        Self { around, across, at: frame.on_page(a), error: 1e-5 + 2.0 * frame.error_of_part(part) }
    }

    /// The same for boxes behind the line, too.
    pub(crate) fn at_all_depths(mut self) -> Self {
        self.around.high[2] = f32::INFINITY;
        self
    }

    /// A bit for each box of a row that the line meets.
    #[expect(clippy::needless_bitwise_bool, reason = "boxes are tested together, without branches")]
    pub(crate) fn meets(&self, Row { low, high }: &Row) -> u32 {
        let ([left, below, _], [right, above, far]) = (self.around.low, self.around.high);
        let ([nx, ny], [at_x, at_y]) = (self.across, self.at);
        bits(|at| {
            let (low_x, low_y, high_x, high_y) = (low[0][at], low[1][at], high[0][at], high[1][at]);
            let is_apart = (low[2][at] > far) | (low_x > right) | (low_y > above) | (high_x < left) | (high_y < below);
            let (half_x, half_y) = (0.5 * (high_x - low_x), 0.5 * (high_y - low_y));
            let (x, y) = (0.5 * (high_x + low_x) - at_x, 0.5 * (high_y + low_y) - at_y);
            let reach = nx.abs() * half_x + ny.abs() * half_y;
            // A NaN of boxes without end is not apart.
            let error = self.error + 1e-5 * (half_x + half_y + x.abs() + y.abs());
            let is_beside = (nx * x + ny * y).abs() > reach + error;
            !(is_apart | is_beside)
        })
    }

    /// The part of `columns` that the line passes between two heights, and perhaps a few more at each end.
    fn columns(&self, heights: [f32; 2], columns: std::ops::Range<usize>) -> std::ops::Range<usize> {
        let [nx, ny] = self.across;
        if columns.len() <= 2 || nx.abs() < 1e-3 {
            return columns;
        }
        let at = heights.map(|height| self.at[0] - (height - self.at[1]) * ny / nx);
        let error = 1e-3 + 2.0 / SIDE as f32 + self.error * (1.0 + (ny / nx).abs());
        let passed = cells(at[0].min(at[1]) - error, at[0].max(at[1]) + error);
        passed.start.max(columns.start)..passed.end.min(columns.end)
    }
}

/// The cells of the page that lines pass, each with the depth of its farthest line.
struct Cells {
    far: Vec<f32>,
    /// How far lines may lie off the page by roundings.
    error: f32,
}

/// Cells along a side of the page.
const SIDE: usize = 512;
/// A box of more cells is not looked up.
const MOST: usize = 256;

impl Cells {
    fn new(frame: &Frame, parts: &[Option<Part>]) -> Self {
        let (mut far, mut error) = (vec![f32::NEG_INFINITY; SIDE * SIDE], 1e-3_f32);
        for part in parts.iter().flatten() {
            let reach = Reach::new(frame, part);
            error = error.max(reach.error);
            let Box3 { low, high } = reach.around;
            let [columns, rows] = [0, 1].map(|axis| cells(low[axis], high[axis]));
            for row in rows {
                let border = |row: usize| row as f32 / SIDE as f32;
                let columns = reach.columns([border(row), border(row + 1)], columns.clone());
                for cell in &mut far[SIDE * row..][columns] {
                    *cell = cell.max(high[2]);
                }
            }
        }
        Self { far, error }
    }

    fn may_be_behind(&self, &Box3 { low, high }: &Box3) -> bool {
        // A box behind the eye has no depth.
        if high[2] == f32::NEG_INFINITY || (0..2).any(|axis| high[axis] < -self.error || low[axis] > 1.0 + self.error) {
            return false;
        }
        let [columns, rows] = [0, 1].map(|axis| cells(low[axis], high[axis]));
        if columns.len() * rows.len() > MOST {
            return true;
        }
        rows.into_iter().any(|row| self.far[SIDE * row..][columns.clone()].iter().any(|&far| far >= low[2]))
    }
}

/// The cells from one coordinate to another.
fn cells(low: f32, high: f32) -> std::ops::Range<usize> {
    let cell = |c: f32| (c * SIDE as f32).clamp(0.0, (SIDE - 1) as f32) as usize;
    cell(low)..cell(high) + 1
}
