//! Shadow boxes: boxes around clusters of 32 faces, and around groups of 32 clusters.

use crate::cpu::common::parallel::Threads;
use crate::cpu::common::positions::{is_finite, position};
use crate::layout::FaceCluster;
use crate::mesh::is_degenerate;

/// The number of faces in a cluster, and of clusters in a group.
pub(crate) const CLUSTER: usize = 32;

/// The faces in the order given, 32 in each cluster, with the boxes around the faces that count. A face counts if it is
/// finite and names three different vertices. A vertex that `positions` lacks counts as non-finite.
pub fn shadow_boxes(positions: &[[f32; 3]], faces: &[[u32; 3]], threads: Threads) -> Vec<FaceCluster> {
    let mut clusters: Vec<_> = faces.chunks(CLUSTER).map(clustered).collect();
    threads.share_runs_of(CLUSTER, &mut clusters, |first, clusters| {
        for (cluster, faces) in clusters.iter_mut().zip(faces[CLUSTER * first..].chunks(CLUSTER)) {
            let counts = |face: &&[u32; 3]| !is_degenerate(**face);
            let corners = faces.iter().filter(counts).map(|face| face.map(|vertex| position(positions, vertex)));
            let boxes = corners.filter(|face| face.iter().all(|&p| is_finite(p))).flatten().map(Keys::around);
            [cluster.low, cluster.high] = boxes.fold(Keys::EMPTY, Keys::join).bits();
        }
    });
    for group in clusters.chunks_mut(CLUSTER) {
        let boxes = group.iter().map(|cluster| Keys::new(cluster.low, cluster.high));
        let [low, high] = boxes.fold(Keys::EMPTY, Keys::join).bits();
        [group[0].group_low, group[0].group_high] = [low, high];
    }
    clusters
}

/// A cluster without its boxes.
pub(crate) fn clustered(faces: &[[u32; 3]]) -> FaceCluster {
    let mut cluster: FaceCluster = bytemuck::Zeroable::zeroed();
    for (corner, &vertex) in cluster.corners.iter_mut().zip(faces.as_flattened()) {
        *corner = vertex;
    }
    cluster
}

/// A box of integers that have the same order as the floats. No device can flush or round them.
#[derive(Clone, Copy)]
struct Keys {
    low: [u32; 3],
    high: [u32; 3],
    /// The bits of the largest absolute coordinate.
    largest: u32,
    any: bool,
}

const SIGN: u32 = 1 << 31;

impl Keys {
    const EMPTY: Self = Self { low: [u32::MAX; 3], high: [0; 3], largest: 0, any: false };

    fn around(point: [f32; 3]) -> Self {
        let bits = point.map(f32::to_bits);
        let keys = bits.map(key);
        let largest = bits.into_iter().fold(0, |largest, bits| largest.max(bits & !SIGN));
        Self { low: keys, high: keys, largest, any: true }
    }

    fn new(low: [u32; 4], high: [u32; 4]) -> Self {
        if high[3] == 0 {
            return Self::EMPTY;
        }
        let [[x, y, z, largest], [far_x, far_y, far_z, _]] = [low, high];
        Self { low: [x, y, z].map(key), high: [far_x, far_y, far_z].map(key), largest, any: true }
    }

    fn join(self, other: Self) -> Self {
        Self {
            low: [0, 1, 2].map(|axis| self.low[axis].min(other.low[axis])),
            high: [0, 1, 2].map(|axis| self.high[axis].max(other.high[axis])),
            largest: self.largest.max(other.largest),
            any: self.any | other.any,
        }
    }

    fn bits(self) -> [[u32; 4]; 2] {
        if !self.any {
            return [[0; 4]; 2];
        }
        let [[x, y, z], [far_x, far_y, far_z]] = [self.low, self.high].map(|keys| keys.map(unkey));
        [[x, y, z, self.largest], [far_x, far_y, far_z, 1]]
    }
}

fn key(bits: u32) -> u32 {
    if bits & SIGN == 0 { bits | SIGN } else { !bits }
}

fn unkey(key: u32) -> u32 {
    if key & SIGN == 0 { !key } else { key & !SIGN }
}
