//! The bound of a cluster: a box around the planes of its faces. docs/numerics/clusters.md.

use bytemuck::{Pod, Zeroable};

use super::CLUSTER_FACES;
use super::order::Order;
use super::plane::{Kind, Plane};
use crate::cpu::Threads;

/// The widening of bounds, as a part of the largest component: 14 units in the last place. It pays for all rounding,
/// here and where a light is decided.
pub const WIDENING: f64 = 14.0 / 8_388_608.0;

/// Kinds of clusters, by the decisions that their bounds allow.
mod cluster_kinds {
    /// Nothing. A face has no bound.
    pub(super) const MIXED: u32 = 0;
    /// All faces face a light, or none does.
    pub(super) const BOUNDED: u32 = 1;
    /// No face faces a light. Some faces name a vertex twice.
    pub(super) const AT_MOST_BACK_FACING: u32 = 2;
    /// All faces name a vertex twice, so they are back-facing for every light.
    pub(super) const BACK_FACING: u32 = 3;
}

/// The bound of a cluster: 48 bytes.
///
/// A plane is `(m, e)` with `m = s·n` and `e = m·(centre − a)`, where `n = (b − a) × (c − a)` and `s > 0` makes the
/// largest component of `m` 1 or −1. The face faces a light `(l, w)` if `m·(l − w·centre) + e·w > 0`. The planes of all
/// faces of the cluster are within `half` of `middle`, component by component, and `half` has room for rounding.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ClusterBound {
    /// About the centre of the faces.
    pub centre: [f32; 3],
    /// 0: nothing is decided; 1: by the bound; 2: by the bound, but never as front-facing; 3: always back-facing.
    pub kind: u32,
    /// The middle of the planes `(m, e)`.
    pub middle: [f32; 4],
    /// How far they may be from it.
    pub half: [f32; 4],
}

/// The bounds of the clusters of an order.
pub(super) fn bounds(order: &Order, threads: Threads) -> Vec<ClusterBound> {
    let mut bounds = vec![ClusterBound::zeroed(); order.faces.len().div_ceil(CLUSTER_FACES)];
    threads.share_runs_of(64, &mut bounds, |first, bounds| {
        let slots = order.faces[first * CLUSTER_FACES..].chunks(CLUSTER_FACES);
        let mut planes = Vec::with_capacity(CLUSTER_FACES);
        for (bound, slots) in bounds.iter_mut().zip(slots) {
            planes.clear();
            planes.extend(slots.iter().map(|&face| order.planes[face as usize]));
            let has = |kind| planes.iter().any(|plane| Kind::of(plane) == kind);
            let kind = match (has(Kind::Irregular), has(Kind::Degenerate), has(Kind::Regular)) {
                (true, _, _) => cluster_kinds::MIXED,
                (_, false, _) => cluster_kinds::BOUNDED,
                (_, true, true) => cluster_kinds::AT_MOST_BACK_FACING,
                (_, true, false) => cluster_kinds::BACK_FACING,
            };
            planes.retain(|plane| Kind::of(plane) == Kind::Regular);
            *bound =
                if kind == cluster_kinds::MIXED { ClusterBound::zeroed() } else { ClusterBound::of(kind, &planes) };
        }
    });
    bounds
}

impl ClusterBound {
    /// The bound of regular planes.
    fn of(kind: u32, planes: &[Plane]) -> Self {
        let Some(&[normal, corner]) = planes.first() else { return Self { kind, ..Self::zeroed() } };
        let (mut normals, mut corners) = (Range::of(normal), Range::of(corner));
        for &[normal, corner] in planes {
            normals.add(normal);
            corners.add(corner);
        }
        let centre = corners.middle();
        // Heights of the centre over the planes, and the largest distance of a corner from it.
        let height_and_distance = |[normal, corner]: &Plane| {
            let to_centre: [f64; 3] = std::array::from_fn(|axis| f64::from(centre[axis]) - f64::from(corner[axis]));
            let terms: [f64; 3] = std::array::from_fn(|axis| f64::from(normal[axis]) * to_centre[axis]);
            let distance = to_centre[0].abs() + to_centre[1].abs() + to_centre[2].abs();
            [terms[0] + terms[1] + terms[2], distance]
        };
        let mut heights = Range::of(height_and_distance(&[normal, corner]));
        for plane in planes {
            heights.add(height_and_distance(plane));
        }
        let reach = heights.high[1];
        let ([x, y, z], [e, _]) = (normals.middle(), heights.middle());
        let [half_x, half_y, half_z] = normals.half([x, y, z], WIDENING);
        let [half_e, _] = heights.half([e, 0.0], WIDENING * reach);
        Self { centre, kind, middle: [x, y, z, e], half: [half_x, half_y, half_z, half_e] }
    }
}

/// The range of some vectors, by components.
#[derive(Clone, Copy)]
struct Range<T, const N: usize> {
    low: [T; N],
    high: [T; N],
}

impl<T: Copy + PartialOrd + Into<f64>, const N: usize> Range<T, N> {
    /// The range of one vector.
    fn of(vector: [T; N]) -> Self {
        Self { low: vector, high: vector }
    }

    fn add(&mut self, vector: [T; N]) {
        for (axis, c) in vector.into_iter().enumerate() {
            self.low[axis] = if c < self.low[axis] { c } else { self.low[axis] };
            self.high[axis] = if c > self.high[axis] { c } else { self.high[axis] };
        }
    }

    /// The middle, as numbers that no device flushes.
    fn middle(&self) -> [f32; N] {
        std::array::from_fn(|axis| {
            let middle = (0.5 * (self.low[axis].into() + self.high[axis].into())) as f32;
            if middle.is_normal() { middle } else { 0.0 }
        })
    }

    /// How far the range reaches from `middle`, and `more` added: rounded up, and never flushed.
    fn half(&self, middle: [f32; N], more: f64) -> [f32; N] {
        std::array::from_fn(|axis| {
            let middle = f64::from(middle[axis]);
            let (below, above) = (middle - self.low[axis].into(), self.high[axis].into() - middle);
            // A cast rounds to nearest, so the next number is not below.
            ((below.max(above) + more) as f32).next_up().max(f32::MIN_POSITIVE)
        })
    }
}
