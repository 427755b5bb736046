//! Trees of boxes.

use std::ops::ControlFlow;

use rimline::cpu::Threads;

use crate::parallel::blocks;

/// A box along three axes. On the page the third is the depth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Box3 {
    pub(crate) low: [f32; 3],
    pub(crate) high: [f32; 3],
}

impl Box3 {
    const EMPTY: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    /// Around points.
    pub(crate) fn around(points: [[f32; 3]; 3]) -> Self {
        points.into_iter().fold(Self::EMPTY, |all, point| all.join(Self { low: point, high: point }))
    }

    pub(crate) fn join(self, other: Self) -> Self {
        Self {
            low: [0, 1, 2].map(|axis| self.low[axis].min(other.low[axis])),
            high: [0, 1, 2].map(|axis| self.high[axis].max(other.high[axis])),
        }
    }

    pub(crate) fn meets(&self, other: &Self) -> bool {
        (0..3).all(|axis| self.low[axis] <= other.high[axis] && other.low[axis] <= self.high[axis])
    }
}

/// Nodes lie in the order of a walk that takes the left child first, so a node with n leaves has its right child 2·⌊n/2⌋ nodes
/// later. Each leaf has [`LEAF`] items, the last one may have fewer.
pub(crate) struct Tree<T> {
    nodes: Vec<Box3>,
    items: Vec<(Box3, T)>,
}

/// A node, its first leaf, and how many it has.
#[derive(Clone, Copy, Default)]
struct Below {
    node: usize,
    first: usize,
    leaves: usize,
}

impl Below {
    fn children(self) -> [Self; 2] {
        let left = self.leaves / 2;
        let right = Self { node: self.node + 2 * left, first: self.first + left, leaves: self.leaves - left };
        [Self { node: self.node + 1, first: self.first, leaves: left }, right]
    }
}

const LEAF: usize = 4;
/// With fewer items a thread of its own is not worth its cost.
const LEAST: usize = 1 << 14;
/// Pairs of nodes that threads share.
const SHARED: usize = 1 << 10;

impl<T: Copy + Send + Sync> Tree<T> {
    /// Boxes are told apart along the first `axes` axes.
    pub(crate) fn new(mut items: Vec<(Box3, T)>, axes: usize, threads: Threads) -> Self {
        let leaves = items.len().div_ceil(LEAF);
        let mut nodes = vec![Box3::EMPTY; (2 * leaves).saturating_sub(1)];
        if leaves > 0 {
            build(&mut items, &mut nodes, axes, threads.count());
        }
        Self { nodes, items }
    }

    fn root(&self) -> Below {
        Below { node: 0, first: 0, leaves: self.items.len().div_ceil(LEAF) }
    }

    fn leaf(&self, below: Below) -> &[(Box3, T)] {
        &self.items[LEAF * below.first..(LEAF * (below.first + 1)).min(self.items.len())]
    }

    /// Calls `found` for each item whose box, and those around it, `meets` says yes to.
    pub(crate) fn visit(&self, meets: impl Fn(&Box3) -> bool, mut found: impl FnMut(T)) {
        let mut stack = [Below::default(); 64];
        stack[0] = self.root();
        let mut count = usize::from(!self.nodes.is_empty());
        while count > 0 {
            count -= 1;
            let below = stack[count];
            if !meets(&self.nodes[below.node]) {
                continue;
            }
            if below.leaves == 1 {
                self.leaf(below).iter().filter(|(around, _)| meets(around)).for_each(|&(_, what)| found(what));
                continue;
            }
            let [left, right] = below.children();
            (stack[count], stack[count + 1]) = (right, left);
            count += 2;
        }
    }

    /// Results that `found` adds for all pairs of items whose boxes meet, in any order. `None` if `tick` ends it.
    pub(crate) fn pairs<R: Send>(
        &self,
        threads: Threads,
        tick: &mut dyn FnMut(usize) -> ControlFlow<()>,
        found: impl Fn(&mut Vec<R>, T, T) + Sync,
    ) -> Option<Vec<Vec<R>>> {
        let mut pairs = if self.nodes.is_empty() { Vec::new() } else { vec![[self.root(); 2]] };
        // The same pairs of nodes with any number of threads.
        while (1..SHARED).contains(&pairs.len()) && pairs.iter().any(|pair| pair[0].leaves + pair[1].leaves > 2) {
            let mut next = Vec::new();
            for pair in pairs {
                self.split(pair, |pair| next.push(pair));
            }
            pairs = next;
        }
        let work = |number: usize| {
            let mut results = Vec::new();
            let mut stack = vec![pairs[number]];
            while let Some(pair) = stack.pop() {
                if pair[0].leaves + pair[1].leaves > 2 {
                    self.split(pair, |pair| stack.push(pair));
                    continue;
                }
                let [one, other] = pair.map(|below| self.leaf(below));
                let is_same = pair[0].node == pair[1].node;
                for (at, (around, what)) in one.iter().enumerate() {
                    let others = if is_same { &other[at + 1..] } else { other };
                    for (other_around, other_what) in others {
                        if around.meets(other_around) {
                            found(&mut results, *what, *other_what);
                        }
                    }
                }
            }
            results
        };
        blocks(threads, pairs.len(), work, tick)
    }

    /// The pairs of nodes below a pair of nodes whose boxes meet. Pairs of leaves stay.
    fn split(&self, [one, other]: [Below; 2], mut add: impl FnMut([Below; 2])) {
        if one.node == other.node {
            if one.leaves == 1 {
                return add([one, other]);
            }
            let [left, right] = one.children();
            add([left, left]);
            add([right, right]);
            if self.nodes[left.node].meets(&self.nodes[right.node]) {
                add([left, right]);
            }
            return;
        }
        if one.leaves + other.leaves == 2 {
            return add([one, other]);
        }
        let [large, small] = if one.leaves >= other.leaves { [one, other] } else { [other, one] };
        for child in large.children() {
            if self.nodes[child.node].meets(&self.nodes[small.node]) {
                add([child, small]);
            }
        }
    }
}

/// Orders the items and fills the nodes above them.
fn build<T: Copy + Send + Sync>(items: &mut [(Box3, T)], nodes: &mut [Box3], axes: usize, threads: usize) {
    nodes[0] = items.iter().fold(Box3::EMPTY, |all, &(around, _)| all.join(around));
    let leaves = items.len().div_ceil(LEAF);
    if leaves == 1 {
        return;
    }
    let middle = |item: &(Box3, T), axis: usize| item.0.low[axis] + item.0.high[axis];
    let spreads = [0, 1, 2].map(|axis| {
        let finite = items.iter().map(|item| middle(item, axis)).filter(|c| axis < axes && c.is_finite());
        let [low, high] = finite.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], c| [low.min(c), high.max(c)]);
        high - low
    });
    let axis = (1..3).fold(0, |best, axis| if spreads[axis] > spreads[best] { axis } else { best });
    let left = leaves / 2;
    items.select_nth_unstable_by(LEAF * left, |one, other| middle(one, axis).total_cmp(&middle(other, axis)));
    let (before, after) = items.split_at_mut(LEAF * left);
    let (nodes_before, nodes_after) = nodes[1..].split_at_mut(2 * left - 1);
    if threads > 1 && after.len() > LEAST {
        std::thread::scope(|scope| {
            scope.spawn(|| build(before, nodes_before, axes, threads / 2));
            build(after, nodes_after, axes, threads - threads / 2);
        });
    } else {
        build(before, nodes_before, axes, 1);
        build(after, nodes_after, axes, 1);
    }
}
