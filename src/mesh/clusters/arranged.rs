//! A mesh in the order of its clusters, as the GPU has it.

use super::{CLUSTER_FACES, Clusters};
use crate::cpu::Threads;
use crate::layout::CHUNK;
use crate::mesh::{INCONSISTENT_BIT, Mesh, NO_FACE};

/// Low bits of a chunk's word: the offset in the words at which the clusters of its faces begin. The upper two bits are a
/// [`SkipRule`].
const OFFSET_BITS: u32 = 30;

/// When a chunk of edges has no silhouette edge for a light, so that the stage `chunks` skips it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum SkipRule {
    /// Never: it has boundaries or inconsistent records.
    Never = 0,
    /// If all its clusters are decided. Each record is within a cluster.
    Decided = 1,
    /// If all its clusters are decided and have the same facing.
    SameFacing = 2,
}

/// A mesh with faces and edge records in their slots.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Arranged {
    /// The vertices of the face of each slot.
    pub faces: Vec<[u32; 3]>,
    /// The vertices of the edge record of each slot.
    pub edge_vertices: Vec<[u32; 2]>,
    /// The slots of its faces, packed as in [`EdgeRecords::packed_faces`](crate::mesh::EdgeRecords::packed_faces).
    pub edge_faces: Vec<[u32; 2]>,
    /// Twelve words for each cluster, its [`ClusterBound`](super::ClusterBound). Then, for each chunk of edge slots and for
    /// their end, the offset in these words at which the clusters of its faces begin, with the rule by which it is skipped in
    /// the upper two bits. Then the indices of these clusters.
    pub words: Vec<u32>,
}

impl Arranged {
    /// The mesh in the order of its clusters. The result does not depend on the number of threads.
    pub fn new(mesh: &Mesh, clusters: &Clusters, threads: Threads) -> Self {
        let mut slots = vec![0_u32; clusters.faces().len()];
        for (slot, &face) in (0..).zip(clusters.faces()) {
            if let Some(entry) = slots.get_mut(face as usize) {
                *entry = slot;
            }
        }
        let slot = |packed: u32| {
            let slot = slots.get((packed & !INCONSISTENT_BIT) as usize).copied().unwrap_or(0);
            if packed == NO_FACE { NO_FACE } else { slot | packed & INCONSISTENT_BIT }
        };
        let records = clusters.edges();
        let mut edge_faces = gather(mesh.edges().packed_faces(), records, threads);
        threads
            .share(&mut edge_faces, |_, faces| faces.iter_mut().flatten().for_each(|packed| *packed = slot(*packed)));
        let words = words(clusters, &edge_faces, threads);
        Self {
            faces: gather(mesh.faces(), clusters.faces(), threads),
            edge_vertices: gather(mesh.edges().vertices(), records, threads),
            edge_faces,
            words,
        }
    }
}

/// The items with these indices.
fn gather<T: Copy + Default + Send + Sync>(items: &[T], indices: &[u32], threads: Threads) -> Vec<T> {
    let mut gathered = vec![T::default(); indices.len()];
    threads.share(&mut gathered, |first, gathered| {
        let indices = indices.get(first..).unwrap_or_default();
        for (item, &index) in gathered.iter_mut().zip(indices) {
            *item = items.get(index as usize).copied().unwrap_or_default();
        }
    });
    gathered
}

/// Bounds, and the clusters of each chunk of edge slots.
fn words(clusters: &Clusters, edge_faces: &[[u32; 2]], threads: Threads) -> Vec<u32> {
    let mut chunks: Vec<_> = edge_faces.chunks(CHUNK as usize).collect();
    // For each range of chunks the rule and the number of clusters of each, then the clusters.
    // The records of 64 chunks are enough for a thread.
    let ranges = threads.share_runs_of(64, &mut chunks, |_, chunks| {
        let (mut rules, mut all, mut indices) = (Vec::with_capacity(chunks.len()), Vec::new(), Vec::new());
        for records in chunks {
            let rule = clusters_of(records, &mut indices);
            rules.push((rule, indices.len() as u32));
            all.extend_from_slice(&indices);
        }
        (rules, all)
    });
    let mut words: Vec<u32> = bytemuck::cast_slice(clusters.bounds()).to_vec();
    let mut offset = (words.len() + chunks.len() + 1) as u32;
    for (rules, _) in &ranges {
        for &(rule, count) in rules {
            words.push(offset | (rule as u32) << OFFSET_BITS);
            offset += count;
        }
    }
    words.push(offset);
    words.extend(ranges.into_iter().flat_map(|(_, indices)| indices));
    words
}

/// Writes the indices of the clusters of a chunk's edge records, each once, ascending. There are none if the chunk is never
/// skipped.
fn clusters_of(records: &[[u32; 2]], indices: &mut Vec<u32>) -> SkipRule {
    indices.clear();
    let mut rule = SkipRule::Decided;
    for &[face_0, face_1] in records {
        if face_1 == NO_FACE || face_0 & INCONSISTENT_BIT != 0 {
            indices.clear();
            return SkipRule::Never;
        }
        let [first, second] = [face_0, face_1].map(|slot| slot / CLUSTER_FACES as u32);
        if first != second {
            rule = SkipRule::SameFacing;
        }
        for cluster in [first, second] {
            // Records of a cluster follow each other, and a chunk has few clusters.
            if indices.last() != Some(&cluster) && !indices.contains(&cluster) {
                indices.push(cluster);
            }
        }
    }
    indices.sort_unstable();
    rule
}
