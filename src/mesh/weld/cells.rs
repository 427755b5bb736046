//! Groups of vertices that are near each other: the connected components of pairs at most a distance apart.
//!
//! Vertices are sorted into cells so small that all of one cell are a pair. So components are those of cells, and cells are
//! joined where a pair of their vertices is near. docs/numerics/welding.md.

use std::cmp::Ordering;
use std::ops::Range;

use super::distance::WeldDistance;
use super::near::{Extent, FEW_PAIRS, Node, Tree, any_near, near};
use super::{Keys, bits, groups, same_bits};

/// Result of welding by distance.
pub(crate) struct NearGroups {
    /// For each vertex the vertex that its group takes: the first one by [`compare`], or the lowest of equal vertices that
    /// are not finite.
    pub(crate) groups: Vec<u32>,
    /// Groups whose box has a diagonal of more than [`WIDE`] times the distance.
    pub(crate) wide: usize,
}

/// Times the distance that a group may be wide without being counted as wide.
pub(crate) const WIDE: u32 = 10;

/// The groups of vertices of one class each. `class` is the same for vertices that may be joined. Vertices that are not
/// finite are joined if all their bits are the same, where −0 equals +0.
pub(crate) fn near_groups(positions: &[[f32; 3]], distance: WeldDistance, class: impl Fn(usize) -> u32) -> NearGroups {
    let is_finite = |v: &usize| positions[*v].iter().all(|c| c.is_finite());
    let finite = (0..positions.len()).filter(is_finite);
    let mut entries: Vec<Entry> =
        finite.map(|v| Entry { class: class(v), cell: cell(positions[v], distance), vertex: v as u32 }).collect();
    entries.sort_unstable_by(|a, b| {
        let order = a.key().cmp(&b.key());
        order.then_with(|| compare(positions, a.vertex, b.vertex))
    });
    let mut cells = Cells::new(&entries, positions);
    // Most cells are joined with their next neighbours, and need not be compared with those beyond.
    cells.join(1, distance);
    cells.join(2, distance);
    let mut groups = non_finite_groups(positions, &class);
    let mut found = vec![Group::EMPTY; cells.cells.len()];
    for (at, cell) in cells.cells.iter().enumerate() {
        let root = root(&mut cells.parents, at as u32) as usize;
        for entry in &entries[cell.entries.clone()] {
            found[root].take(positions, entry.vertex);
        }
    }
    for (at, cell) in cells.cells.iter().enumerate() {
        let root = root(&mut cells.parents, at as u32) as usize;
        for entry in &entries[cell.entries.clone()] {
            groups[entry.vertex as usize] = found[root].first;
        }
    }
    let is_far = |Extent { low, high }| !distance.reaches_times(WIDE, low, high);
    let is_wide = |group: &&Group| group.first != NONE && is_far(group.extent);
    NearGroups { groups, wide: found.iter().filter(is_wide).count() }
}

const NONE: u32 = u32::MAX;

/// The lowest of those with the same bits for vertices that are not finite. Others are yet to be found.
fn non_finite_groups(positions: &[[f32; 3]], class: impl Fn(usize) -> u32) -> Vec<u32> {
    if positions.iter().flatten().all(|c| c.is_finite()) {
        return vec![NONE; positions.len()];
    }
    let keys = Keys::new(4);
    let words = |v: usize| positions[v].map(bits).into_iter().chain([class(v)]);
    groups(
        positions.len(),
        |v| keys.hash(words(v)),
        |a, b| same_bits(positions[a], positions[b]) && class(a) == class(b),
    )
}

/// The order in which a group takes a position: by x, y and z, then −0 before +0, then by index.
fn compare(positions: &[[f32; 3]], a: u32, b: u32) -> Ordering {
    let [p, q] = [a, b].map(|v| positions[v as usize]);
    let numbers = p.partial_cmp(&q).unwrap_or(Ordering::Equal);
    let zeros = || p.iter().zip(&q).map(|(p, q)| p.total_cmp(q)).find(|order| order.is_ne());
    numbers.then_with(|| zeros().unwrap_or(Ordering::Equal)).then(a.cmp(&b))
}

/// A vertex in its cell.
struct Entry {
    class: u32,
    /// The index of the cell along z, y and x.
    cell: [i64; 3],
    vertex: u32,
}

impl Entry {
    fn key(&self) -> (u32, [i64; 3]) {
        (self.class, self.cell)
    }
}

/// The cell of a finite position, as z, y, x. Two positions of one cell are at most `distance` apart. Two whose cells are
/// more than two cells apart along an axis are farther apart than that.
fn cell([x, y, z]: [f32; 3], distance: WeldDistance) -> [i64; 3] {
    /// Up to here a quotient is off by less than 2⁻¹¹, whose double the share of the distance below leaves room for.
    const MOST: f64 = (1_u64 << 40) as f64;
    /// Less than 1/√3.
    const SHARE: f64 = 0.576;
    let side = f64::from(distance.get()) * SHARE;
    [z, y, x].map(|coordinate| {
        let quotient = f64::from(coordinate) / side;
        if quotient.abs() < MOST {
            return quotient.floor() as i64;
        }
        if coordinate == 0.0 {
            return 0;
        }
        // Neighbouring floats are farther apart than the distance here, so each has its own cell, four from the next: no
        // other is compared with it.
        let index = (1_i64 << 41) + 4 * i64::from(coordinate.to_bits() & !(1 << 31));
        if coordinate < 0.0 { -index } else { index }
    })
}

/// A cell with a vertex.
struct Cell {
    class: u32,
    index: [i64; 3],
    entries: Range<usize>,
    /// Its positions, each once, in [`Cells::points`]. A tree of the cell orders them anew.
    points: Range<usize>,
}

/// The cells in order, and which of them are joined.
#[expect(clippy::struct_field_names, reason = "they are the cells")]
struct Cells {
    cells: Vec<Cell>,
    points: Vec<[f32; 3]>,
    /// For each cell its tree, if the cell needed one.
    trees: Vec<Option<Tree>>,
    parents: Vec<u32>,
}

impl Cells {
    fn new(entries: &[Entry], positions: &[[f32; 3]]) -> Self {
        let (mut cells, mut first) = (Vec::new(), 0);
        let mut points: Vec<[f32; 3]> = Vec::with_capacity(entries.len());
        for entries in entries.chunk_by(|a, b| a.key() == b.key()) {
            let start = points.len();
            for entry in entries {
                // Equal positions of a cell follow each other.
                let point = positions[entry.vertex as usize];
                if points[start..].last() != Some(&point) {
                    points.push(point);
                }
            }
            let end = first + entries.len();
            let (class, index) = entries[0].key();
            cells.push(Cell { class, index, entries: first..end, points: start..points.len() });
            first = end;
        }
        let parents = (0..cells.len() as u32).collect();
        let trees = cells.iter().map(|_| None).collect();
        Self { cells, points, trees, parents }
    }

    /// Joins cells that are at most `radius` cells apart and have a pair of vertices near each other. It walks over the
    /// rows of cells beside each cell, all at once, so a cell takes at most 13 rows of 5 cells.
    fn join(&mut self, radius: i64, distance: WeldDistance) {
        let beside = (0..=radius).flat_map(|z| (-radius..=radius).map(move |y| [z, y]));
        let mut rows: Vec<([i64; 2], usize)> = beside.filter(|&row| row >= [0, 0]).map(|row| (row, 0)).collect();
        for at in 0..self.cells.len() {
            let (class, [z, y, x]) = (self.cells[at].class, self.cells[at].index);
            for ([above, beside], start) in &mut rows {
                let is_same_row = *above == 0 && *beside == 0;
                let key_at = |x: i64| (class, [z + *above, y + *beside, x]);
                let (low, high) = (key_at(if is_same_row { x + 1 } else { x - radius }), key_at(x + radius));
                let key = |at: usize| self.cells.get(at).map(|cell| (cell.class, cell.index));
                while key(*start).is_some_and(|key| key < low) {
                    *start += 1;
                }
                let mut other = *start;
                while self.cells.get(other).is_some_and(|cell| (cell.class, cell.index) <= high) {
                    self.join_pair(at, other, distance);
                    other += 1;
                }
            }
        }
    }

    fn join_pair(&mut self, a: usize, b: usize, distance: WeldDistance) {
        let [first, second] = [a, b].map(|at| root(&mut self.parents, at as u32));
        if first == second {
            return;
        }
        let of = |at: usize| self.cells[at].points.clone();
        let is_joined = if of(a).len().saturating_mul(of(b).len()) <= FEW_PAIRS {
            any_near(&self.points[of(a)], &self.points[of(b)], distance)
        } else {
            for at in [a, b] {
                self.trees[at].get_or_insert_with(|| Tree::new(&mut self.points[of(at)]));
            }
            let node = |at: usize| Some(Node::root(self.trees[at].as_ref()?, &self.points[of(at)]));
            node(a).zip(node(b)).is_some_and(|(a, b)| near(a, b, distance))
        };
        if is_joined {
            self.parents[first.max(second) as usize] = first.min(second);
        }
    }
}

/// The root of a tree; ways to it are halved.
pub(crate) fn root(parents: &mut [u32], mut cell: u32) -> u32 {
    while parents[cell as usize] != cell {
        let above = parents[parents[cell as usize] as usize];
        parents[cell as usize] = above;
        cell = above;
    }
    cell
}

/// A group of the vertices so far.
#[derive(Clone, Copy)]
struct Group {
    first: u32,
    extent: Extent,
}

impl Group {
    const EMPTY: Self = Self { first: NONE, extent: Extent::EMPTY };

    fn take(&mut self, positions: &[[f32; 3]], vertex: u32) {
        if self.first == NONE || compare(positions, vertex, self.first).is_lt() {
            self.first = vertex;
        }
        self.extent = self.extent.with(&positions[vertex as usize]);
    }
}
