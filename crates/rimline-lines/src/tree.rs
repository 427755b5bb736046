//! Trees of boxes.

use std::ops::ControlFlow;

use rimline::cpu::Threads;

use crate::parallel::{blocks, ranges};

/// A box along three axes. On the page the third is the depth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Box3 {
    pub(crate) low: [f32; 3],
    pub(crate) high: [f32; 3],
}

impl Box3 {
    /// The page with its depths.
    pub(crate) const UNIT: Self = Self { low: [0.0; 3], high: [1.0; 3] };
    pub(crate) const EMPTY: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    pub(crate) fn of(point: [f32; 3]) -> Self {
        Self { low: point, high: point }
    }

    pub(crate) fn join(self, other: Self) -> Self {
        // Comparisons leave out a NaN of the other. Only faces without an area have any, and they meet nothing.
        let less = |axis: usize| if other.low[axis] < self.low[axis] { other.low[axis] } else { self.low[axis] };
        let more = |axis: usize| if other.high[axis] > self.high[axis] { other.high[axis] } else { self.high[axis] };
        Self { low: [less(0), less(1), less(2)], high: [more(0), more(1), more(2)] }
    }
}

/// Boxes of a [`Row`].
pub(crate) const WIDE: usize = 8;

/// Boxes side by side, which are tested together. Those that are missing are empty.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    pub(crate) low: [[f32; WIDE]; 3],
    pub(crate) high: [[f32; WIDE]; 3],
}

impl Row {
    fn new(boxes: impl Iterator<Item = Box3>) -> Self {
        let mut row = Self { low: [[f32::INFINITY; WIDE]; 3], high: [[f32::NEG_INFINITY; WIDE]; 3] };
        for (at, Box3 { low, high }) in boxes.enumerate() {
            for axis in 0..3 {
                (row.low[axis][at], row.high[axis][at]) = (low[axis], high[axis]);
            }
        }
        row
    }

    fn get(&self, at: usize) -> Box3 {
        Box3 { low: [0, 1, 2].map(|axis| self.low[axis][at]), high: [0, 1, 2].map(|axis| self.high[axis][at]) }
    }

    fn around(&self) -> Box3 {
        (0..WIDE).fold(Box3::EMPTY, |all, at| all.join(self.get(at)))
    }

    /// A bit for each of the boxes that meets another one.
    #[expect(clippy::needless_bitwise_bool, reason = "boxes are tested together, without branches")]
    fn meets(&self, Box3 { low, high }: &Box3) -> u32 {
        let ([x, y, z], [right, above, far]) = (*low, *high);
        bits(|at| {
            let [low, high] = [&self.low, &self.high];
            (low[0][at] <= right)
                & (high[0][at] >= x)
                & (low[1][at] <= above)
                & (high[1][at] >= y)
                & (low[2][at] <= far)
                & (high[2][at] >= z)
        })
    }
}

/// A bit for each box of a row that `is` says yes to.
#[inline(always)]
pub(crate) fn bits(is: impl Fn(usize) -> bool) -> u32 {
    const BITS: [u32; WIDE] = [1, 2, 4, 8, 16, 32, 64, 128];
    let mut all = 0;
    for (at, bit) in BITS.into_iter().enumerate() {
        all |= if is(at) { bit } else { 0 };
    }
    all
}

/// The positions of the bits of a mask.
fn positions_of(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let at = mask.trailing_zeros();
        mask &= mask.wrapping_sub(1);
        (at < u32::BITS).then_some(at as usize)
    })
}

/// Items in the order of a curve through space. Rows of the first level have their boxes, those of each other level the boxes
/// around the rows of the one below; the last level has one row, or none.
pub(crate) struct Tree<T> {
    levels: Vec<Vec<Row>>,
    items: Vec<T>,
}

/// Items at a time.
const RUN: usize = 1 << 14;
/// Rows whose pairs are looked for at a time.
const PAIR_RUN: usize = 1 << 8;

impl<T: Copy + Send + Sync> Tree<T> {
    /// Makes a tree of `count` items, each with a box; `item` makes each of them twice. They are ordered along the first `axes`
    /// axes, 2 or 3. Most are within `around`.
    pub(crate) fn new(
        count: usize,
        (axes, around): (usize, &Box3),
        threads: Threads,
        item: impl Fn(usize) -> (Box3, T) + Sync,
    ) -> Self {
        let middle = |at: usize| {
            let Box3 { low, high } = item(at).0;
            [0, 1, 2].map(|axis| 0.5 * low[axis] + 0.5 * high[axis])
        };
        let curve = Curve::new(around, axes);
        let order = sorted(threads, count, |at| u64::from(curve.rank(middle(at))) << 32 | at as u64);
        let rows = ranges(threads, order.len().div_ceil(WIDE), RUN / WIDE, |range| {
            let keys = &order[WIDE * range.start..(WIDE * range.end).min(order.len())];
            let items: Vec<_> = keys.iter().map(|&key| item(key as u32 as usize)).collect();
            let rows: Vec<_> = items.chunks(WIDE).map(|row| Row::new(row.iter().map(|&(around, _)| around))).collect();
            (rows, items.into_iter().map(|(_, item)| item).collect::<Vec<_>>())
        });
        drop(order);
        let mut tree = Self { levels: Vec::new(), items: Vec::with_capacity(count) };
        let mut level = Vec::with_capacity(count.div_ceil(WIDE));
        for (rows, items) in rows {
            level.extend(rows);
            tree.items.extend(items);
        }
        while level.len() > 1 {
            let next = level.chunks(WIDE).map(|rows| Row::new(rows.iter().map(Row::around))).collect();
            tree.levels.push(std::mem::replace(&mut level, next));
        }
        tree.levels.push(level);
        tree
    }

    /// Calls `found` for each item whose box, and those around it, are among those that `meets` gives bits for.
    pub(crate) fn visit(&self, meets: impl Fn(&Row) -> u32, mut found: impl FnMut(T)) {
        self.rows(&meets, 0, |row, mask| positions_of(mask).for_each(|at| found(self.items[WIDE * row + at])));
    }

    /// The rows of the first level from `first` on, with their bits.
    fn rows(&self, meets: &impl Fn(&Row) -> u32, first: usize, mut found: impl FnMut(usize, u32)) {
        // At most 11 levels with 7 rows that wait.
        let mut stack = [(0_u32, 0_u32); 80];
        stack[0] = (self.levels.len() as u32 - 1, 0);
        let mut count = usize::from(!self.items.is_empty());
        while count > 0 {
            count -= 1;
            let (level, row) = stack[count];
            let below = if level == 0 { self.items.len() } else { self.levels[level as usize - 1].len() };
            let missing = (WIDE * (row as usize + 1)).saturating_sub(below);
            let mask = meets(&self.levels[level as usize][row as usize]) & 0xff >> missing;
            if level == 0 {
                if mask != 0 {
                    found(row as usize, mask);
                }
                continue;
            }
            for at in positions_of(mask) {
                let below = WIDE * row as usize + at;
                if (below + 1) << (3 * (level - 1)) > first {
                    stack[count] = (level - 1, below as u32);
                    count += 1;
                }
            }
        }
    }

    /// Results that `found` adds for all pairs of items whose boxes meet, in any order. The first one is given by what
    /// `prepare` made of it. `None` if `tick` ends it.
    pub(crate) fn pairs<P, R: Send>(
        &self,
        threads: Threads,
        tick: &mut dyn FnMut(usize) -> ControlFlow<()>,
        prepare: impl Fn(&T) -> P + Sync,
        found: impl Fn(&mut Vec<R>, &P, &T) + Sync,
    ) -> Option<Vec<Vec<R>>> {
        let rows = &self.levels[0];
        let work = |block: usize| {
            let mut results = Vec::new();
            for number in block * PAIR_RUN..((block + 1) * PAIR_RUN).min(rows.len()) {
                let (boxes, around) = (&rows[number], rows[number].around());
                let items = &self.items[WIDE * number..self.items.len().min(WIDE * (number + 1))];
                let prepared: Vec<_> = items.iter().map(&prepare).collect();
                self.rows(&|row| row.meets(&around), number, |other, mask| {
                    let row = &rows[other];
                    for (at, item) in prepared.iter().enumerate() {
                        let later = if other == number { u32::MAX << at << 1 } else { u32::MAX };
                        for other_at in positions_of(row.meets(&boxes.get(at)) & mask & later) {
                            found(&mut results, item, &self.items[WIDE * other + other_at]);
                        }
                    }
                });
            }
            results
        };
        blocks(threads, rows.len().div_ceil(PAIR_RUN), work, tick)
    }
}

/// The keys of all numbers below `count`, in order. No two are equal.
fn sorted(threads: Threads, count: usize, key: impl Fn(usize) -> u64 + Sync) -> Vec<u64> {
    let runs = ranges(threads, count, RUN, |range| {
        let mut keys: Vec<_> = range.map(&key).collect();
        keys.sort_unstable();
        keys
    });
    if runs.len() == 1 {
        return runs.concat();
    }
    // Keys that part the others to about equal shares.
    let mut borders: Vec<_> = runs.iter().flat_map(|run| run.iter().step_by(RUN / 16)).copied().collect();
    borders.sort_unstable();
    let borders: Vec<_> = borders.into_iter().step_by(16).skip(1).collect();
    let parts = ranges(threads, borders.len() + 1, 1, |range| {
        let mut part = Vec::new();
        for run in &runs {
            let from = if range.start == 0 { 0 } else { run.partition_point(|key| *key < borders[range.start - 1]) };
            let to = borders.get(range.start).map_or(run.len(), |border| run.partition_point(|key| key < border));
            part.extend_from_slice(&run[from..to]);
        }
        part.sort_unstable();
        part
    });
    parts.concat()
}

/// A curve through all cells of a square or a cube, on which neighbours are neighbours: Hilbert's.
struct Curve {
    low: [f32; 3],
    scale: f32,
    axes: usize,
}

impl Curve {
    fn new(around: &Box3, axes: usize) -> Self {
        let size = (0..axes).map(|axis| around.high[axis] - around.low[axis]).fold(0.0, f32::max);
        let scale = (1_u32 << Self::bits(axes)) as f32 / size;
        Self { low: around.low, scale: if scale.is_finite() { scale } else { 0.0 }, axes }
    }

    /// Bits of a cell along an axis.
    fn bits(axes: usize) -> u32 {
        if axes == 2 { 15 } else { 10 }
    }

    /// Where the cell of a point is on the curve, by Skilling (2004): "Programming the Hilbert curve".
    fn rank(&self, point: [f32; 3]) -> u32 {
        let bits = Self::bits(self.axes);
        let most = (1_u32 << bits) - 1;
        // Numbers that are not finite go to a border.
        let cell = |axis: usize| (((point[axis] - self.low[axis]) * self.scale) as u32).min(most);
        let mut x = [0, 1, 2].map(|axis| if axis < self.axes { cell(axis) } else { 0 });
        let last = self.axes - 1;
        for bit in (1..bits).rev() {
            let (bit, below) = (1 << bit, (1 << bit) - 1);
            for axis in 0..self.axes {
                let flip = if x[axis] & bit != 0 { below } else { 0 };
                let swap = (x[0] ^ x[axis]) & below & !flip;
                x[0] ^= flip | swap;
                x[axis] ^= swap;
            }
        }
        for axis in 1..self.axes {
            x[axis] ^= x[axis - 1];
        }
        let mut flip = 0;
        for bit in (1..bits).rev() {
            flip ^= if x[last] >> bit & 1 != 0 { (1 << bit) - 1 } else { 0 };
        }
        let x = x.map(|x| x ^ flip);
        let digits = (0..bits).rev().flat_map(|bit| (0..self.axes).map(move |axis| x[axis] >> bit & 1));
        digits.fold(0, |rank, digit| rank << 1 | digit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Trees of up to four levels find the pairs that all pairs of boxes have, and what each box meets.
    #[test]
    fn trees_miss_nothing() {
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        for (count, axes) in [(0, 3), (1, 3), (7, 2), (9, 3), (64, 2), (65, 3), (700, 2), (700, 3)] {
            let mut boxes = Vec::new();
            for _ in 0..count {
                let low = [random(), random(), random()];
                let size = 0.2 * random();
                boxes.push(Box3 { low, high: low.map(|c| c + size) });
            }
            let is_met = |one: &Box3, other: &Box3| {
                (0..3).all(|axis| one.low[axis] <= other.high[axis] && other.low[axis] <= one.high[axis])
            };
            let tree = Tree::new(count, (axes, &Box3::UNIT), Threads::new(2), |at| (boxes[at], at));
            let add = |found: &mut Vec<[usize; 2]>, &one: &usize, &other: &usize| {
                found.push([one.min(other), one.max(other)]);
            };
            let found = tree.pairs(Threads::new(2), &mut |_| ControlFlow::Continue(()), |&item| item, add);
            let mut found = found.expect("not ended").concat();
            found.sort_unstable();
            let all = (0..count).flat_map(|one| (one + 1..count).map(move |other| [one, other]));
            let expected: Vec<_> = all.filter(|&[one, other]| is_met(&boxes[one], &boxes[other])).collect();
            assert_eq!(found, expected, "{count} boxes");
            for around in &boxes {
                let mut found = Vec::new();
                tree.visit(|row| row.meets(around), |item| found.push(item));
                found.sort_unstable();
                let expected: Vec<_> = (0..count).filter(|&at| is_met(around, &boxes[at])).collect();
                assert_eq!(found, expected, "{count} boxes");
            }
        }
    }
}
