//! Trees of boxes around the triangles that may hide a line, or around lines.

use rimline::cpu::Threads;

use crate::cover::Triangle;
use crate::frame::{Bounds, Frame, Part};
use crate::parallel::ranges;
use crate::world::World;

/// A triangle or line, and where it may hide something.
#[derive(Clone, Copy)]
pub(crate) struct Item<T> {
    low: [f32; 2],
    high: [f32; 2],
    depths: [f32; 2],
    what: T,
}

impl<T> Item<T> {
    fn new(Bounds { low, high, near, far }: Bounds, what: T) -> Self {
        Self { low, high, depths: [near, far], what }
    }
}

/// A box around the items of a node, or of a leaf.
#[derive(Clone, Copy)]
struct Node {
    low: [f32; 2],
    high: [f32; 2],
    /// The nearest and the farthest.
    depths: [f32; 2],
}

/// Nodes lie in the order of a walk that takes the left child first, so a node with n leaves has its right child 2·⌊n/2⌋ nodes
/// later. Each leaf has [`LEAF`] items, the last one may have fewer.
pub(crate) struct Tree<T> {
    nodes: Vec<Node>,
    items: Vec<Item<T>>,
}

const LEAF: usize = 4;
/// With fewer items a thread of its own is not worth its cost.
const LEAST: usize = 1 << 14;
/// Faces at a time.
const RUN: usize = 1 << 14;

impl Tree<Triangle> {
    /// Of the triangles that may hide a point of the lines in these cells.
    pub(crate) fn of_triangles(world: &World<'_>, frame: &Frame, lines: &Cells, threads: Threads) -> Self {
        let mut items = Vec::new();
        let around = ranges(threads, world.positions.len(), RUN, |range| {
            world.positions[range].iter().map(|&position| frame.bounds_of_vertex(position)).collect::<Vec<_>>()
        });
        let around = around.concat();
        for placed in &world.placed {
            let mesh = &*placed.object.mesh;
            let polygons = mesh.polygons().map(rimline::mesh::Polygons::triangle_polygons);
            let found = ranges(threads, mesh.faces().len(), RUN, |range| {
                let item = |face: usize| {
                    let corners = mesh.faces()[face].map(|vertex| vertex + placed.first_vertex);
                    let [a, b, c] = corners.map(|vertex| around[vertex as usize]);
                    let around = a.join(b).join(c);
                    if around.is_behind_eye() || !lines.may_be_behind(&around) || is_degenerate(corners) {
                        return None;
                    }
                    let positions = corners.map(|vertex| world.positions[vertex as usize]);
                    let polygon = polygons.as_ref().map_or(Triangle::ALONE, |of| placed.first_face + of[face]);
                    let side = world.facing(positions);
                    (side != 0).then(|| Item::new(around, Triangle::new(corners, polygon, side > 0)))
                };
                range.filter_map(item).collect::<Vec<_>>()
            });
            items.extend(found.into_iter().flatten());
        }
        Self::new(items, threads)
    }
}

impl Tree<u32> {
    /// Of the parts of lines, by their numbers.
    pub(crate) fn of_parts(frame: &Frame, parts: &[Option<Part>], threads: Threads) -> Self {
        let item = |(what, part): (u32, &Option<Part>)| Some(Item::new(frame.bounds_of_part(part.as_ref()?), what));
        Self::new((0..).zip(parts).filter_map(item).collect(), threads)
    }

    /// Of triangles, by their numbers below `count`.
    pub(crate) fn of_boxes(
        frame: &Frame,
        count: u32,
        threads: Threads,
        triangle: impl Fn(u32) -> [[f32; 3]; 3] + Sync,
    ) -> Self {
        let found = ranges(threads, count as usize, RUN, |range| {
            let item = |what: usize| {
                let around = frame.bounds_of_triangle(triangle(what as u32));
                (!around.is_behind_eye()).then(|| Item::new(around, what as u32))
            };
            range.filter_map(item).collect::<Vec<_>>()
        });
        Self::new(found.concat(), threads)
    }
}

impl<T: Copy + Send + Sync> Tree<T> {
    fn new(mut items: Vec<Item<T>>, threads: Threads) -> Self {
        let leaves = items.len().div_ceil(LEAF);
        let mut nodes = vec![Node { low: [0.0; 2], high: [0.0; 2], depths: [0.0; 2] }; (2 * leaves).saturating_sub(1)];
        if leaves > 0 {
            build(&mut items, &mut nodes, threads.count());
        }
        Self { nodes, items }
    }

    /// Calls `found` for each triangle that may hide a point of a line, or each line that may coincide with it.
    pub(crate) fn visit(&self, line: &Reach, mut found: impl FnMut(T)) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack = [(0, 0, 0); 64];
        stack[0] = (0, 0, self.items.len().div_ceil(LEAF));
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let (node, first, leaves) = stack[count];
            let Node { low, high, depths } = self.nodes[node];
            if !line.meets(low, high, depths) {
                continue;
            }
            if leaves == 1 {
                let items = &self.items[LEAF * first..(LEAF * (first + 1)).min(self.items.len())];
                let met = items.iter().filter(|item| line.meets(item.low, item.high, item.depths));
                met.for_each(|item| found(item.what));
                continue;
            }
            let left = leaves / 2;
            stack[count] = (node + 2 * left, first + left, leaves - left);
            stack[count + 1] = (node + 1, first, left);
            count += 2;
        }
    }
}

fn is_degenerate([a, b, c]: [u32; 3]) -> bool {
    a == b || b == c || c == a
}

/// Orders the items and fills the nodes above them.
fn build<T: Copy + Send + Sync>(items: &mut [Item<T>], nodes: &mut [Node], threads: usize) {
    let around = |items: &[Item<T>]| {
        let start =
            Node { low: [f32::INFINITY; 2], high: [f32::NEG_INFINITY; 2], depths: [f32::INFINITY, f32::NEG_INFINITY] };
        items.iter().fold(start, |node, item| Node {
            low: [0, 1].map(|axis| node.low[axis].min(item.low[axis])),
            high: [0, 1].map(|axis| node.high[axis].max(item.high[axis])),
            depths: [node.depths[0].min(item.depths[0]), node.depths[1].max(item.depths[1])],
        })
    };
    nodes[0] = around(items);
    let leaves = items.len().div_ceil(LEAF);
    if leaves == 1 {
        return;
    }
    let middle = |item: &Item<T>, axis: usize| item.low[axis] + item.high[axis];
    let spread = |axis: usize| {
        let finite = items.iter().map(|item| middle(item, axis)).filter(|c| c.is_finite());
        let [low, high] = finite.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], c| [low.min(c), high.max(c)]);
        high - low
    };
    let axis = usize::from(spread(1) > spread(0));
    let left = leaves / 2;
    items.select_nth_unstable_by(LEAF * left, |one, other| middle(one, axis).total_cmp(&middle(other, axis)));
    let (before, after) = items.split_at_mut(LEAF * left);
    let (nodes_before, nodes_after) = nodes[1..].split_at_mut(2 * left - 1);
    if threads > 1 && after.len() > LEAST {
        std::thread::scope(|scope| {
            scope.spawn(|| build(before, nodes_before, threads / 2));
            build(after, nodes_after, threads - threads / 2);
        });
    } else {
        build(before, nodes_before, 1);
        build(after, nodes_after, 1);
    }
}

/// What boxes a line or a triangle may meet.
pub(crate) struct Reach {
    bounds: Bounds,
    /// A unit vector across the line, and a point of it.
    across: [f32; 2],
    at: [f32; 2],
}

impl Reach {
    pub(crate) fn new(frame: &Frame, part: &Part) -> Self {
        let [a, b] = part.page;
        let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
        let length = (dx * dx + dy * dy).sqrt();
        let bounds = Bounds { near: f32::NEG_INFINITY, ..frame.bounds_of_part(part) };
        Self { bounds, across: [(-dy / length) as f32, (dx / length) as f32], at: frame.on_page(a) }
    }

    /// All that a triangle may meet.
    pub(crate) fn of_triangle(frame: &Frame, corners: [[f32; 3]; 3]) -> Self {
        Self { bounds: frame.bounds_of_triangle(corners), across: [0.0; 2], at: [0.0; 2] }
    }

    fn meets(&self, low: [f32; 2], high: [f32; 2], [near, far]: [f32; 2]) -> bool {
        let own = &self.bounds;
        if near > own.far
            || far < own.near
            || (0..2).any(|axis| low[axis] > own.high[axis] || high[axis] < own.low[axis])
        {
            return false;
        }
        let half = [0, 1].map(|axis| 0.5 * (high[axis] - low[axis]));
        let from = [0, 1].map(|axis| 0.5 * (high[axis] + low[axis]) - self.at[axis]);
        let [nx, ny] = self.across;
        let reach = nx.abs() * half[0] + ny.abs() * half[1];
        // Coordinates are within −1 to 2 or cut off there; a NaN of boxes without end is not apart.
        let error = 1e-5 * (1.0 + half[0] + half[1] + from[0].abs() + from[1].abs());
        let is_apart = (nx * from[0] + ny * from[1]).abs() > reach + error;
        !is_apart
    }
}

/// The cells of the page that lines pass, each with the depth of its farthest line.
pub(crate) struct Cells {
    far: Vec<f32>,
}

/// Cells along a side of the page.
const SIDE: usize = 512;

impl Cells {
    pub(crate) fn new(frame: &Frame, parts: &[Option<Part>]) -> Self {
        let mut far = vec![f32::NEG_INFINITY; SIDE * SIDE];
        for part in parts.iter().flatten() {
            let bounds = frame.bounds_of_part(part);
            let reach = Reach::new(frame, part);
            let [columns, rows] = [0, 1].map(|axis| cells(bounds.low[axis], bounds.high[axis]));
            for row in rows {
                // The columns that the line passes in this row.
                let border = |row: usize| row as f32 / SIDE as f32;
                let columns = reach.columns([border(row), border(row + 1)], columns.clone());
                for cell in &mut far[SIDE * row..][columns] {
                    *cell = cell.max(bounds.far);
                }
            }
        }
        Self { far }
    }

    fn may_be_behind(&self, &Bounds { low, high, near, .. }: &Bounds) -> bool {
        if (0..2).any(|axis| high[axis] < -1e-3 || low[axis] > 1.001) {
            return false;
        }
        let [columns, rows] = [0, 1].map(|axis| cells(low[axis], high[axis]));
        if columns.len() * rows.len() > 256 {
            return true;
        }
        rows.into_iter().any(|row| self.far[SIDE * row..][columns.clone()].iter().any(|&far| far >= near))
    }
}

/// The cells from one coordinate to another.
fn cells(low: f32, high: f32) -> std::ops::Range<usize> {
    let cell = |c: f32| (c * SIDE as f32).clamp(0.0, (SIDE - 1) as f32) as usize;
    cell(low)..cell(high) + 1
}

impl Reach {
    /// Those of `columns` that the line passes between two heights, and perhaps one more at each end.
    fn columns(&self, heights: [f32; 2], columns: std::ops::Range<usize>) -> std::ops::Range<usize> {
        let [nx, ny] = self.across;
        if columns.len() <= 2 || nx.abs() < 1e-3 {
            return columns;
        }
        let at = heights.map(|height| self.at[0] - (height - self.at[1]) * ny / nx);
        let error = 1e-3 + 2.0 / SIDE as f32;
        let own = cells(at[0].min(at[1]) - error, at[0].max(at[1]) + error);
        own.start.max(columns.start)..own.end.min(columns.end)
    }
}
