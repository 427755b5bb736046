//! Whether a point of one set and a point of another are at most a distance apart; docs/numerics/welding.md.

use super::distance::WeldDistance;

/// So many pairs are compared one by one.
pub(super) const FEW_PAIRS: usize = 64;

/// Boxes around points, around their halves, and so on down to single points. The points are in such an order that halves
/// are runs.
pub(super) struct Tree(Vec<Extent>);

impl Tree {
    /// Orders the points.
    pub(super) fn new(points: &mut [[f32; 3]]) -> Self {
        let (mut most, mut levels) = (points.len(), 1);
        while most > 1 {
            most = most.div_ceil(2);
            levels += 1;
        }
        let mut tree = Self(vec![Extent::EMPTY; (1 << levels) - 1]);
        tree.fill(0, points);
        tree
    }

    fn fill(&mut self, at: usize, points: &mut [[f32; 3]]) {
        let extent = points.iter().fold(Extent::EMPTY, Extent::with);
        self.0[at] = extent;
        if points.len() > 1 {
            let axis = extent.longest().0;
            let middle = points.len() / 2;
            points.select_nth_unstable_by(middle, |p, q| p[axis].total_cmp(&q[axis]));
            let (low, high) = points.split_at_mut(middle);
            self.fill(2 * at + 1, low);
            self.fill(2 * at + 2, high);
        }
    }
}

/// Points of a tree, and where the tree has their box.
#[derive(Clone, Copy)]
pub(super) struct Node<'a> {
    tree: &'a Tree,
    at: usize,
    points: &'a [[f32; 3]],
}

impl<'a> Node<'a> {
    /// All points of a tree.
    pub(super) fn root(tree: &'a Tree, points: &'a [[f32; 3]]) -> Self {
        Self { tree, at: 0, points }
    }

    fn extent(&self) -> Extent {
        self.tree.0[self.at]
    }

    fn halves(&self) -> Option<[Self; 2]> {
        if self.points.len() <= 1 {
            return None;
        }
        let (low, high) = self.points.split_at(self.points.len() / 2);
        let half = |at, points| Self { tree: self.tree, at, points };
        Some([half(2 * self.at + 1, low), half(2 * self.at + 2, high)])
    }
}

/// Whether any pair of points is at most `distance` apart.
pub(super) fn any_near(a: &[[f32; 3]], b: &[[f32; 3]], distance: WeldDistance) -> bool {
    a.iter().any(|&p| b.iter().any(|&q| distance.reaches(p, q)))
}

/// The same for two nodes, whose points lie in boxes of a few times the distance.
pub(super) fn near(a: Node<'_>, b: Node<'_>, distance: WeldDistance) -> bool {
    if a.points.len().saturating_mul(b.points.len()) <= FEW_PAIRS {
        return any_near(a.points, b.points, distance);
    }
    let [box_a, box_b] = [a.extent(), b.extent()];
    // Exact. The limit below has room for rounding, so alone it would compare each pair of points that are hardly more than
    // the distance apart, such as those beside a sphere and those about its centre.
    if !distance.reaches(box_a.nearest(&box_b), box_b.nearest(&box_a)) {
        return false;
    }
    let towards = box_a.towards(&box_b);
    let length = (towards[0].powi(2) + towards[1].powi(2) + towards[2].powi(2)).sqrt();
    // Rounding adds less than 2⁻⁴⁵ of it.
    let limit = f64::from(distance.get()) * length * (1.0 + 1.0 / (1_u64 << 40) as f64);
    // Points give a closer bound than their boxes. A node's points are read only if the other node has at least about a
    // quarter as many. Otherwise many points would be read again for every few.
    let along = |p: &[f32; 3]| {
        let [x, y, z] = [0, 1, 2].map(|axis| f64::from(p[axis]) - f64::from(box_a.low[axis]));
        towards[0] * x + towards[1] * y + towards[2] * z
    };
    let is_small = |node: &Node<'_>, other: &Node<'_>| node.points.len() / 4 <= other.points.len();
    let by_way = |p: &&[f32; 3], q: &&[f32; 3]| along(p).total_cmp(&along(q));
    let farthest = if is_small(&a, &b) { a.points.iter().max_by(by_way) } else { None };
    let nearest = if is_small(&b, &a) { b.points.iter().min_by(by_way) } else { None };
    let end = farthest.map_or_else(|| along(&box_a.corner(towards, true)), along);
    let begin = nearest.map_or_else(|| along(&box_b.corner(towards, false)), along);
    if begin - end > limit {
        return false;
    }
    if farthest.zip(nearest).is_some_and(|(a, b)| distance.reaches(*a, *b)) {
        return true;
    }
    let is_a_larger = box_a.longest().1 >= box_b.longest().1;
    match (a.halves(), b.halves()) {
        (Some(halves), other) if is_a_larger || other.is_none() => {
            halves.into_iter().any(|half| near(half, b, distance))
        }
        (_, Some(halves)) => halves.into_iter().any(|half| near(a, half, distance)),
        _ => any_near(a.points, b.points, distance),
    }
}

/// A box around points.
#[derive(Clone, Copy)]
pub(super) struct Extent {
    pub(super) low: [f32; 3],
    pub(super) high: [f32; 3],
}

impl Extent {
    pub(super) const EMPTY: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    /// The same with a point.
    pub(super) fn with(self, p: &[f32; 3]) -> Self {
        Self {
            low: [0, 1, 2].map(|axis| self.low[axis].min(p[axis])),
            high: [0, 1, 2].map(|axis| self.high[axis].max(p[axis])),
        }
    }

    /// The axis along which it is longest, and its length.
    fn longest(&self) -> (usize, f64) {
        let lengths = [0, 1, 2].map(|axis| (axis, f64::from(self.high[axis]) - f64::from(self.low[axis])));
        lengths
            .into_iter()
            .fold((0, f64::NEG_INFINITY), |longest, side| if side.1 > longest.1 { side } else { longest })
    }

    /// The way from its middle to that of another.
    fn towards(&self, other: &Self) -> [f64; 3] {
        [0, 1, 2].map(|axis| {
            let between = |a: [f32; 3], b: [f32; 3]| f64::from(b[axis]) - f64::from(a[axis]);
            0.5 * (between(self.low, other.low) + between(self.high, other.high))
        })
    }

    /// The point of the box that is nearest to another box, for two boxes the ends of a shortest way between them.
    fn nearest(&self, other: &Self) -> [f32; 3] {
        [0, 1, 2].map(|axis| other.low[axis].min(self.high[axis]).max(self.low[axis]))
    }

    /// The corner that is farthest or nearest along a way.
    fn corner(&self, towards: [f64; 3], is_farthest: bool) -> [f32; 3] {
        [0, 1, 2].map(|axis| if (towards[axis] >= 0.0) == is_farthest { self.high[axis] } else { self.low[axis] })
    }
}
