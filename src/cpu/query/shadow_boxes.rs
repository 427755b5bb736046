//! Shadow boxes: boxes around clusters of 32 faces, and around groups of 32 clusters.

use bytemuck::Zeroable;

use crate::cpu::common::parallel::Threads;
use crate::cpu::common::positions::{is_finite, position};
use crate::layout::FaceCluster;
use crate::mesh::{Mesh, is_degenerate};

/// The number of faces in a cluster, and of clusters in a group.
pub(crate) const CLUSTER: usize = 32;

/// The faces of the mesh in order, 32 in each cluster, with the boxes around the faces that count. A face counts if it is
/// finite and names three different vertices. A vertex that `positions` lacks counts as non-finite.
pub fn shadow_boxes(positions: &[[f32; 3]], mesh: &Mesh, threads: Threads) -> Vec<FaceCluster> {
    let mut clusters = clusters(mesh, ANY_RANGE);
    threads.share_runs_of(CLUSTER, &mut clusters, |_, clusters| {
        for cluster in clusters {
            let (faces, _) = cluster.corners.as_chunks::<3>();
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

/// A range of clusters that holds every mesh.
const ANY_RANGE: usize = usize::MAX / CLUSTER;

/// The clusters of a mesh without their boxes, with its triangles in order. No polygon lies in two ranges of `range`
/// clusters: entries before one that would stay empty. A polygon with more faces than a range still does, see
/// [`largest_polygon`].
pub(crate) fn clusters(mesh: &Mesh, range: usize) -> Vec<FaceCluster> {
    let mut clusters = vec![FaceCluster::zeroed(); cluster_count(mesh, range)];
    let mut put = |index: usize, face_index: usize, head: usize| {
        let (cluster, face) = (&mut clusters[index / CLUSTER], mesh.faces()[face_index]);
        if index.is_multiple_of(CLUSTER) {
            cluster.first_face = face_index as u32;
        }
        cluster.corners[index % CLUSTER * 3..][..3].copy_from_slice(&face);
        cluster.continues |= u32::from(index > head) << (index % CLUSTER);
        if index.is_multiple_of(CLUSTER) && index > head {
            cluster.head = (head % (range * CLUSTER)) as u32;
        }
    };
    let Some(polygons) = mesh.polygons() else {
        for face in 0..mesh.faces().len() {
            put(face, face, face);
        }
        return clusters;
    };
    let mut end = 0;
    for polygon in 0..polygons.len() {
        let triangles = polygons.triangles(polygon);
        let first = first_index(end, triangles.len(), range);
        for (index, face) in (first..).zip(triangles.clone()) {
            put(index, face, first);
        }
        end = first + triangles.len();
    }
    clusters
}

/// The number of clusters that [`clusters`] gives.
pub(crate) fn cluster_count(mesh: &Mesh, range: usize) -> usize {
    let end = mesh.polygons().map_or(mesh.faces().len(), |polygons| {
        let sizes = (0..polygons.len()).map(|polygon| polygons.triangles(polygon).len());
        sizes.fold(0, |end, size| first_index(end, size, range) + size)
    });
    end.div_ceil(CLUSTER)
}

/// The number of triangles of the largest polygon.
#[cfg(feature = "gpu")]
pub(crate) fn largest_polygon(mesh: &Mesh) -> usize {
    mesh.polygons()
        .map_or(1, |polygons| (0..polygons.len()).map(|polygon| polygons.triangles(polygon).len()).max().unwrap_or(0))
}

/// Where a polygon of `size` triangles begins if all entries below `end` are in use.
fn first_index(end: usize, size: usize, range: usize) -> usize {
    let range = range * CLUSTER;
    if end / range == (end + size).saturating_sub(1) / range { end } else { end.next_multiple_of(range) }
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
