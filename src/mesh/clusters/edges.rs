//! The order of edge records: first those within clusters, then those between two clusters, then the others.

use super::CLUSTER_FACES;
use crate::mesh::topology::{prefix_sum, put};
use crate::mesh::{EdgeRecords, INCONSISTENT_BIT, NO_FACE};

/// An order of edge records by the clusters of their faces.
///
/// 1. **Inner** records, cluster by cluster: both faces are in one cluster. If it is decided whole for a light, the
///    record is no silhouette.
/// 2. **Outer** records, by the lower of two clusters. If both have the same decided facing, the record is no silhouette.
/// 3. The others are boundaries and inconsistent records. Boundaries are silhouettes for every light, and inconsistent
///    records whose faces have the same facing. So they are never skipped.
///
/// Each part keeps the order of the mesh within its groups. Memory: 4 bytes for each record and 8 for each cluster.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EdgeOrder {
    records: Vec<u32>,
    /// Where each group begins: the inner records of each cluster, the outer records of each, and the others.
    starts: Vec<u32>,
}

impl EdgeOrder {
    /// `faces` has the face of each slot.
    pub fn new(records: &EdgeRecords, faces: &[u32]) -> Self {
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
        let starts = next.clone();
        let mut order = vec![0_u32; groups.len()];
        for (record, &group) in (0..).zip(&groups) {
            put(&mut next, &mut order, group, record);
        }
        Self { records: order, starts }
    }

    /// For each edge slot the mesh's record.
    pub fn records(&self) -> &[u32] {
        &self.records
    }

    /// The inner records of a cluster. None, if there is no such cluster.
    pub fn inner(&self, cluster: usize) -> &[u32] {
        if cluster < self.clusters() { self.group(cluster) } else { &[] }
    }

    /// The outer records that have `cluster` for the lower one. None, if there is no such cluster.
    pub fn outer(&self, cluster: usize) -> &[u32] {
        if cluster < self.clusters() { self.group(self.clusters() + cluster) } else { &[] }
    }

    /// Boundaries and inconsistent records.
    pub fn others(&self) -> &[u32] {
        self.group(2 * self.clusters())
    }

    /// The slot where each group begins, and their end: the inner records of each cluster, the outer records of each, and
    /// the others.
    pub fn starts(&self) -> &[u32] {
        &self.starts
    }

    fn clusters(&self) -> usize {
        self.starts.len().saturating_sub(2) / 2
    }

    fn group(&self, group: usize) -> &[u32] {
        match self.starts.get(group..group + 2) {
            Some(&[start, end]) => self.records.get(start as usize..end as usize).unwrap_or_default(),
            _ => &[],
        }
    }

    /// The size in memory, in bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.records) + size_of_val(&*self.starts)
    }
}
