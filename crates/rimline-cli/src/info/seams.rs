//! Boundary edges that nearly meet others, as rounding leaves them, and T-junctions.

use glam::DVec3;
use rimline::mesh::{Edge, EdgeKind, Weld, WeldDistance};
use rimline::{Geometry, Mesh};
use rimline_picture::Bounds;
use serde_json::{Value, json};

/// Boundary edges that lie so near others that they are meant to be one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Seams {
    pub(super) edges: usize,
    /// The farthest that ends of two such edges are apart.
    pub(super) gap: f64,
    /// A distance that joins them, and what it does.
    pub(super) distance: f32,
    pub(crate) closes: usize,
    pub(super) collapses: usize,
    /// Whether only `--weld position` joins them, too.
    pub(super) across_data: bool,
    /// Whether `--weld position` alone joins as many: the vertices are split, and no rounding parts them.
    pub(super) by_position: bool,
}

impl Seams {
    /// The seams of a mesh in its own space, where vertices are welded.
    pub(crate) fn of(geometry: &Geometry, mesh: &Mesh) -> Option<Self> {
        let edges: Vec<[u32; 2]> = boundary(mesh).map(|edge| edge.vertices).collect();
        let first = tolerance(geometry.positions())?;
        let found = [1.0, 10.0, 100.0].map(|times| {
            // A power of ten, as people write them.
            let distance = format!("{:.0e}", f64::from(first) * times).parse().ok()?;
            let (count, gap) = pairs(geometry.positions(), &edges, distance)?;
            Some((distance, count, gap))
        });
        let most = found.iter().flatten().map(|(_, count, _)| *count).max().filter(|&count| count > 0)?;
        let (distance, edges, gap) = found.into_iter().flatten().find(|(_, count, _)| *count == most)?;
        let by = WeldDistance::new(distance).ok()?;
        let closed = |by: Weld| {
            let (welded, counts) = geometry.welded(by);
            let after = welded.mesh().ok()?;
            let before = mesh.edges().counts().boundary;
            Some((before.saturating_sub(after.edges().counts().boundary), counts.collapsed))
        };
        let (within, across) = (closed(Weld::Distance(by))?, closed(Weld::Distance(by.across_data()))?);
        let across_data = across.0 > within.0;
        let (closes, collapses) = if across_data { across } else { within };
        let by_position = closes > 0 && gap == 0.0 && closed(Weld::Position)?.0 == closes;
        Some(Self { edges, gap, distance, closes, collapses, across_data, by_position })
    }

    pub(crate) fn text(&self) -> String {
        let Self { edges, gap, distance, closes, collapses, across_data, by_position } = self;
        let position = if *across_data { "--weld position " } else { "" };
        let them = if closes >= edges { "them".to_owned() } else { format!("{closes} of them") };
        let collapse = match *collapses {
            0 => String::new(),
            1 => ", and 1 face collapses".to_owned(),
            _ => format!(", and {collapses} faces collapse"),
        };
        if *by_position {
            let some = if closes >= edges { String::new() } else { format!(", which closes {them}") };
            return format!("{edges} boundary edges are seams of split vertices: use --weld position{some}{collapse}");
        }
        format!(
            "{edges} boundary edges lie within {gap:.0e} of each other: {position}--weld-distance {distance:e} closes {them}{collapse}"
        )
    }

    pub(super) fn json(&self) -> Value {
        let Self { edges, gap, distance, closes, collapses, across_data, by_position } = self;
        let distance: f64 = distance.to_string().parse().unwrap_or_default();
        json!({
            "edges": edges, "gap": gap, "weld_distance": distance, "closes": closes, "collapses": collapses,
            "across_data": across_data, "by_position": by_position,
        })
    }
}

fn double(position: [f32; 3]) -> DVec3 {
    DVec3::from(position.map(f64::from))
}

fn boundary(mesh: &Mesh) -> impl Iterator<Item = Edge> + '_ {
    mesh.edges().iter().filter(|edge| edge.kind == EdgeKind::Boundary)
}

/// The power of ten below a millionth of the size or of the largest coordinate: some steps of a float.
fn tolerance(positions: &[[f32; 3]]) -> Option<f32> {
    let Bounds { min, max } = Bounds::of(positions)?;
    let largest = (0..3)
        .map(|axis| (f64::from(max[axis]) - f64::from(min[axis])).max(f64::from(max[axis].abs().max(min[axis].abs()))));
    let largest = largest.fold(0.0, f64::max);
    let power = (largest * 1e-6).log10().floor();
    let tolerance = 10.0_f64.powf(power) as f32;
    (largest > 0.0 && tolerance > 0.0).then_some(tolerance)
}

/// A boundary edge between groups of vertices that are near each other. Edges are sorted by their fields, in order.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct KeyedEdge {
    /// The lower group first.
    groups: [u32; 2],
    /// Whether the edge begins in the lower group.
    is_forward: bool,
    edge: usize,
}

/// How many boundary edges meet another of the opposite way once vertices so near are one, and how far their ends are apart.
fn pairs(positions: &[[f32; 3]], edges: &[[u32; 2]], distance: f32) -> Option<(usize, f64)> {
    let ends: Vec<[f32; 3]> = edges.iter().flatten().map(|&v| positions[v as usize]).collect();
    let each: Vec<[u32; 3]> = (0..ends.len() as u32).map(|v| [v; 3]).collect();
    let groups = Mesh::new(&ends, &each, Weld::Distance(WeldDistance::new(distance).ok()?)).ok()?;
    let group = |end: usize| groups.faces()[end][0];
    let keyed = |edge: usize| {
        let (a, b) = (group(2 * edge), group(2 * edge + 1));
        (a != b).then(|| KeyedEdge { groups: [a.min(b), a.max(b)], is_forward: a < b, edge })
    };
    let mut keyed: Vec<KeyedEdge> = (0..edges.len()).filter_map(keyed).collect();
    keyed.sort_unstable();
    let apart = |a: [f32; 3], b: [f32; 3]| double(a).distance(double(b));
    let (mut count, mut gap) = (0, 0.0_f64);
    for run in keyed.chunk_by(|p, q| p.groups == q.groups) {
        let (backward, forward) = run.split_at(run.partition_point(|keyed| !keyed.is_forward));
        for (one, other) in forward.iter().zip(backward) {
            let (one, other) = (one.edge, other.edge);
            count += 2;
            gap = gap.max(apart(ends[2 * one], ends[2 * other + 1])).max(apart(ends[2 * one + 1], ends[2 * other]));
        }
    }
    Some((count, gap))
}

/// How many vertices of boundary edges lie on another boundary edge, between its ends, as near as rounding leaves them.
pub(super) fn t_junctions(mesh: &Mesh, positions: &[[f32; 3]]) -> usize {
    let Some(tolerance) = tolerance(positions).map(f64::from) else { return 0 };
    let position = |v: u32| double(positions[v as usize]);
    let edges: Vec<[DVec3; 2]> = boundary(mesh)
        .map(|edge| edge.vertices.map(position))
        .filter(|ends| ends.iter().all(|end| end.is_finite()))
        .collect();
    let mut points: Vec<DVec3> = edges.iter().flatten().copied().collect();
    points.sort_unstable_by(|p, q| p.to_array().partial_cmp(&q.to_array()).unwrap_or(std::cmp::Ordering::Equal));
    points.dedup();
    let Some(mut tree) = Points::of(&mut points) else { return 0 };
    edges.into_iter().map(|[a, b]| tree.take(a, b, tolerance)).sum()
}

/// Points that lie on no edge yet, halved by position: edges that lie over each other ask none of them twice.
struct Points {
    low: DVec3,
    high: DVec3,
    left: usize,
    /// At a leaf, which holds one point.
    halves: Option<Box<[Points; 2]>>,
}

impl Points {
    fn of(points: &mut [DVec3]) -> Option<Self> {
        let (&first, others) = points.split_first()?;
        let (low, high) = others.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p)));
        let widest = (high - low).max_position();
        let (left, middle) = (points.len(), points.len() / 2);
        let halves = if left == 1 {
            None
        } else {
            points.select_nth_unstable_by(middle, |p, q| p[widest].total_cmp(&q[widest]));
            let (before, after) = points.split_at_mut(middle);
            Some(Box::new([Self::of(before)?, Self::of(after)?]))
        };
        Some(Self { low, high, left, halves })
    }

    /// Takes out those between the ends of an edge, and says how many.
    fn take(&mut self, a: DVec3, b: DVec3, tolerance: f64) -> usize {
        if self.left == 0 || !self.may_meet(a, b, tolerance) {
            return 0;
        }
        let taken = match &mut self.halves {
            Some(halves) => halves.iter_mut().map(|half| half.take(a, b, tolerance)).sum(),
            None => usize::from(is_between(self.low, a, b, tolerance)),
        };
        self.left -= taken;
        taken
    }

    /// Whether the edge comes so near the box of them: the part of it between all pairs of opposite sides is not empty.
    fn may_meet(&self, a: DVec3, b: DVec3, tolerance: f64) -> bool {
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for c in 0..3 {
            // Twice as far, so that rounding leaves none out.
            let (low, high) = (self.low[c] - 2.0 * tolerance, self.high[c] + 2.0 * tolerance);
            let step = b[c] - a[c];
            if step == 0.0 {
                if a[c] < low || a[c] > high {
                    return false;
                }
                continue;
            }
            let (t, u) = ((low - a[c]) / step, (high - a[c]) / step);
            (from, to) = (from.max(t.min(u)), to.min(t.max(u)));
        }
        from <= to
    }
}

fn is_between(p: DVec3, a: DVec3, b: DVec3, tolerance: f64) -> bool {
    let (along, to) = (b - a, p - a);
    let (square, t) = (along.dot(along), along.dot(to));
    if square == 0.0 || t <= 0.0 || t >= square {
        return false;
    }
    let t = t / square;
    let (length, aside) = (square.sqrt(), to - t * along);
    t * length > tolerance && (1.0 - t) * length > tolerance && aside.dot(aside) <= tolerance * tolerance
}

#[cfg(test)]
mod tests {
    use rimline_testkit::random::Random;

    use super::*;

    /// On a small lattice, where whole numbers tell.
    #[test]
    fn t_junctions_are_those_of_the_definition() {
        let mut random = Random::new(32);
        let mut all = 0;
        for count in 6..60 {
            let positions: Vec<[f32; 3]> =
                (0..3 * count).map(|_| std::array::from_fn(|_| random.below(6) as f32)).collect();
            let faces: Vec<[u32; 3]> = (0..count).map(|face| [0, 1, 2].map(|corner| 3 * face + corner)).collect();
            let mesh = Mesh::new(&positions, &faces, Weld::Position).expect("there are faces");
            let edges: Vec<[DVec3; 2]> =
                boundary(&mesh).map(|edge| edge.vertices.map(|v| double(positions[v as usize]))).collect();
            let is_within = |p: DVec3, [a, b]: [DVec3; 2]| {
                let (along, to) = (b - a, p - a);
                along.cross(to) == DVec3::ZERO && along.dot(to) > 0.0 && along.dot(to) < along.dot(along)
            };
            let lattice = (0..216).map(|n: i32| DVec3::new(f64::from(n % 6), f64::from(n / 6 % 6), f64::from(n / 36)));
            let ends = lattice.filter(|p| edges.iter().flatten().any(|end| end == p));
            let right = ends.filter(|p| edges.iter().any(|edge| is_within(*p, *edge))).count();
            assert_eq!(t_junctions(&mesh, &positions), right, "{count} triangles");
            all += right;
        }
        assert!(all > 100, "hardly any junctions: {all}");
    }
}
