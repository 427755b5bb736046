//! The order of edge records: first those within clusters, then those between two clusters, then the others.

use super::CLUSTER_FACES;
use crate::mesh::topology::{prefix_sum, put};
use crate::mesh::{EdgeRecords, INCONSISTENT_BIT, NO_FACE};

/// The edge record of each edge slot, by the clusters of its faces. `faces` has the face of each face slot.
///
/// 1. **Inner** records, cluster by cluster: both faces are in one cluster. If it is decided whole for a light, the
///    record is no silhouette.
/// 2. **Outer** records, by the lower of two clusters. If both have the same decided facing, the record is no silhouette.
/// 3. The others are boundaries and inconsistent records. Boundaries are silhouettes for every light, and inconsistent
///    records whose faces have the same facing. So they are never skipped.
///
/// Each part keeps the order of the mesh within its groups.
pub fn edge_order(records: &EdgeRecords, faces: &[u32]) -> Vec<u32> {
    let clusters = faces.len().div_ceil(CLUSTER_FACES);
    let mut cluster_of = vec![0_u32; faces.len()];
    for (cluster, slots) in (0..).zip(faces.chunks(CLUSTER_FACES)) {
        for &face in slots {
            cluster_of[face as usize] = cluster;
        }
    }
    let others = 2 * clusters as u32;
    let groups: Vec<u32> = records
        .packed_faces()
        .iter()
        .map(|&[face_0, face_1]| {
            if face_1 == NO_FACE || face_0 & INCONSISTENT_BIT != 0 {
                return others;
            }
            let [first, second] = [face_0, face_1].map(|face| cluster_of[face as usize]);
            if first == second { first } else { clusters as u32 + first.min(second) }
        })
        .collect();
    let mut next = vec![0_u32; others as usize + 2];
    for &group in &groups {
        next[group as usize + 1] += 1;
    }
    prefix_sum(&mut next);
    let mut order = vec![0_u32; groups.len()];
    for (record, &group) in (0..).zip(&groups) {
        put(&mut next, &mut order, group, record);
    }
    order
}
