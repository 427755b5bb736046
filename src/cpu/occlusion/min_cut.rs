//! A minimum cut between faces that are kept and faces that are left out, by Dinic's algorithm (1970). Costs are counts.

const UNSEEN: u32 = u32::MAX;

/// Costs of keeping faces or leaving them out. A face is a node.
pub(crate) struct MinCut {
    /// The cost of leaving a node out: the flow into it.
    inflow: Vec<u32>,
    /// The cost of keeping it: the flow out of it.
    outflow: Vec<u32>,
    /// Nodes of which keeping just one costs 1.
    pairs: Vec<[u32; 2]>,
}

impl MinCut {
    pub(crate) fn new(nodes: usize) -> Self {
        Self { inflow: vec![0; nodes], outflow: vec![0; nodes], pairs: Vec::new() }
    }

    /// Keeping the node costs 1 more. `None` is a face that is kept in any case, so nothing changes.
    pub(crate) fn cost_of_keeping(&mut self, node: Option<usize>) {
        if let Some(cost) = node.and_then(|node| self.outflow.get_mut(node)) {
            *cost += 1;
        }
    }

    /// Leaving the node out costs 1 more.
    pub(crate) fn cost_of_leaving_out(&mut self, node: usize) {
        if let Some(cost) = self.inflow.get_mut(node) {
            *cost += 1;
        }
    }

    /// Keeping one of two nodes and not the other costs 1 more.
    pub(crate) fn cost_of_parting(&mut self, a: usize, b: usize) {
        if a != b {
            self.pairs.push([a as u32, b as u32]);
        }
    }

    /// Which nodes to keep for the least cost. Where several choices have this cost, it keeps the fewest nodes.
    pub(crate) fn solve(self) -> Vec<bool> {
        let mut flow = Flow::new(self);
        while flow.set_levels() {
            flow.augment_all();
        }
        flow.level.iter().map(|level| *level != UNSEEN).collect()
    }
}

/// A flow, as what is left of capacities.
struct Flow {
    inflow: Vec<u32>,
    outflow: Vec<u32>,
    /// The arcs that leave a node are those from `first[node]` to before `first[node + 1]` in `arcs`.
    first: Vec<usize>,
    arcs: Vec<u32>,
    /// Arc 2p leads from the first node of pair p to the second, and arc 2p + 1 back.
    to: Vec<u32>,
    /// The capacity that is left of each arc, 0 to 2: both arcs of a pair have 2 together.
    left: Vec<u8>,
    /// The fewest steps from a node with inflow, or [`UNSEEN`].
    level: Vec<u32>,
    /// For each node the index in `arcs` of the next arc to try.
    at: Vec<usize>,
    queue: Vec<usize>,
    /// The steps of the path that is tried: the node, and the arc that leaves it.
    path: Vec<(usize, usize)>,
}

impl Flow {
    fn new(MinCut { mut inflow, mut outflow, pairs }: MinCut) -> Self {
        for (inflow, outflow) in inflow.iter_mut().zip(&mut outflow) {
            let through = (*inflow).min(*outflow);
            *inflow -= through;
            *outflow -= through;
        }
        let nodes = inflow.len();
        let mut first = vec![0; nodes + 1];
        for node in pairs.as_flattened() {
            first[*node as usize + 1] += 1;
        }
        for node in 0..nodes {
            first[node + 1] += first[node];
        }
        let mut at = first.clone();
        let mut arcs = vec![0; 2 * pairs.len()];
        for (arc, node) in (0..).zip(pairs.as_flattened()) {
            let at = &mut at[*node as usize];
            arcs[*at] = arc;
            *at += 1;
        }
        let to = pairs.iter().flat_map(|&[a, b]| [b, a]).collect();
        let (left, level) = (vec![1; 2 * pairs.len()], vec![UNSEEN; nodes]);
        Self { inflow, outflow, first, arcs, to, left, level, at, queue: Vec::new(), path: Vec::new() }
    }

    /// Sets the levels of nodes that more flow can reach, and tells whether one of them lets it out.
    fn set_levels(&mut self) -> bool {
        self.level.fill(UNSEEN);
        self.queue.clear();
        self.queue.extend((0..self.inflow.len()).filter(|&node| self.inflow[node] > 0));
        for &node in &self.queue {
            self.level[node] = 0;
        }
        let (mut next, mut lets_out) = (0, false);
        while let Some(&node) = self.queue.get(next) {
            next += 1;
            lets_out |= self.outflow[node] > 0;
            for &arc in &self.arcs[self.first[node]..self.first[node + 1]] {
                let to = self.to[arc as usize] as usize;
                if self.left[arc as usize] > 0 && self.level[to] == UNSEEN {
                    self.level[to] = self.level[node] + 1;
                    self.queue.push(to);
                }
            }
        }
        lets_out
    }

    /// Adds flow along rising levels, until there is no such path.
    fn augment_all(&mut self) {
        self.at.clear();
        self.at.extend_from_slice(&self.first[..self.inflow.len()]);
        for node in 0..self.inflow.len() {
            while self.inflow[node] > 0 && self.augment(node) {
                self.inflow[node] -= 1;
            }
        }
    }

    /// Adds one unit of flow that enters at a node, if it can.
    fn augment(&mut self, mut node: usize) -> bool {
        self.path.clear();
        loop {
            if self.outflow[node] > 0 {
                self.outflow[node] -= 1;
                for &(_, arc) in &self.path {
                    self.left[arc] -= 1;
                    self.left[arc ^ 1] += 1;
                }
                return true;
            }
            let rest = &self.arcs[self.at[node]..self.first[node + 1]];
            let rises = |arc: &u32| {
                self.left[*arc as usize] > 0
                    && self.level[self.to[*arc as usize] as usize] == self.level[node].saturating_add(1)
            };
            if let Some(steps) = rest.iter().position(rises) {
                self.at[node] += steps;
                let arc = self.arcs[self.at[node]] as usize;
                self.path.push((node, arc));
                node = self.to[arc] as usize;
                continue;
            }
            self.at[node] = self.first[node + 1];
            let Some((before, _)) = self.path.pop() else { return false };
            self.at[before] += 1;
            node = before;
        }
    }
}

#[cfg(test)]
mod tests {
    use rimline_testkit::random::Random;

    use super::*;

    /// Against all choices: none costs less, and none of the same cost keeps fewer nodes.
    #[test]
    fn no_choice_costs_less_than_the_cut() {
        let mut random = Random::new(5901);
        let (mut mixed, mut swayed) = (0, 0);
        for number in 0..2000 {
            let nodes = 1 + random.below(10);
            let mut cut = MinCut::new(nodes);
            for _ in 0..random.below(4 * nodes) {
                match random.below(4) {
                    0 => cut.cost_of_keeping(Some(random.below(nodes))),
                    1 => cut.cost_of_leaving_out(random.below(nodes)),
                    _ => cut.cost_of_parting(random.below(nodes), random.below(nodes)),
                }
            }
            let (inflow, outflow, pairs) = (cut.inflow.clone(), cut.outflow.clone(), cut.pairs.clone());
            let cost = |choice: u32| {
                let is_kept = |node: usize| choice >> node & 1 != 0;
                let alone = (0..nodes).map(|node| if is_kept(node) { outflow[node] } else { inflow[node] });
                let parted = pairs.iter().filter(|pair| is_kept(pair[0] as usize) != is_kept(pair[1] as usize));
                (alone.sum::<u32>() + parted.count() as u32, choice.count_ones())
            };
            let chosen = |kept: &[bool]| (0..nodes).filter(|&node| kept[node]).fold(0_u32, |all, node| all | 1 << node);
            let found = chosen(&cut.solve());
            let least = (0..1_u32 << nodes).map(cost).min();
            assert_eq!(Some(cost(found)), least, "cut {number}: {inflow:?}, {outflow:?}, {pairs:?}");
            mixed += usize::from(found != 0 && found != (1 << nodes) - 1);
            // Without a look at pairs.
            let alone: Vec<bool> = inflow.iter().zip(&outflow).map(|(leaving, keeping)| leaving > keeping).collect();
            swayed += usize::from(cost(chosen(&alone)).0 != cost(found).0);
        }
        println!("{mixed} cuts keep some nodes and not others; pairs matter for {swayed}");
        assert!(mixed > 200 && swayed > 100, "{mixed}, {swayed}");
    }
}
