//! A mesh in the order of its clusters, as the GPU has it.

use super::{CLUSTER_FACES, Clusters};
use crate::layout::CHUNK;
use crate::mesh::{INCONSISTENT_BIT, Mesh, NO_FACE};

/// Bits of the place where the clusters of a chunk of edges begin. The upper two tell when the chunk has no silhouette.
const PLACE_BITS: u32 = 30;

/// When a chunk of edges has no silhouette edge for a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Spared {
    /// It may always have one: there are boundaries or inconsistent records.
    Never = 0,
    /// All its clusters are decided: each record is within a cluster.
    Decided = 1,
    /// All its clusters are decided alike.
    Alike = 2,
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
    /// their end, the word where the clusters of its faces begin, with [`Spared`] in the upper two bits. Then these clusters.
    pub words: Vec<u32>,
}

impl Arranged {
    /// The mesh in the order of these clusters, which are its own.
    pub fn new(mesh: &Mesh, clusters: &Clusters) -> Self {
        let mut slots = vec![0_u32; clusters.faces().len()];
        for (slot, &face) in (0..).zip(clusters.faces()) {
            if let Some(place) = slots.get_mut(face as usize) {
                *place = slot;
            }
        }
        let slot = |packed: u32| {
            let slot = slots.get((packed & !INCONSISTENT_BIT) as usize).copied().unwrap_or(0);
            if packed == NO_FACE { NO_FACE } else { slot | packed & INCONSISTENT_BIT }
        };
        let records = clusters.edges().records();
        let (vertices, faces) = (mesh.edges().vertices(), mesh.edges().packed_faces());
        let faces_of = |face: u32| mesh.faces().get(face as usize).copied().unwrap_or_default();
        let edge_faces: Vec<[u32; 2]> =
            records.iter().map(|&record| faces.get(record as usize).copied().unwrap_or_default().map(slot)).collect();
        let words = words(clusters, &edge_faces);
        Self {
            faces: clusters.faces().iter().copied().map(faces_of).collect(),
            edge_vertices: records
                .iter()
                .map(|&record| vertices.get(record as usize).copied().unwrap_or_default())
                .collect(),
            edge_faces,
            words,
        }
    }
}

/// Bounds, and the clusters of each chunk of edge slots.
fn words(clusters: &Clusters, edge_faces: &[[u32; 2]]) -> Vec<u32> {
    let mut words: Vec<u32> = bytemuck::cast_slice(clusters.bounds()).to_vec();
    let chunks = edge_faces.chunks(CHUNK as usize);
    let starts = words.len();
    words.resize(starts + chunks.len() + 1, 0);
    let mut names = Vec::new();
    for (chunk, records) in (starts..).zip(chunks) {
        let spared = clusters_of(records, &mut names);
        let place = words.len() as u32;
        if let Some(start) = words.get_mut(chunk) {
            *start = place | (spared as u32) << PLACE_BITS;
        }
        words.extend(&names);
    }
    let (end, last) = (words.len() as u32, starts + edge_faces.len().div_ceil(CHUNK as usize));
    if let Some(start) = words.get_mut(last) {
        *start = end;
    }
    words
}

/// The clusters of some edge records, each once, in order.
fn clusters_of(records: &[[u32; 2]], names: &mut Vec<u32>) -> Spared {
    names.clear();
    let mut spared = Spared::Decided;
    for &[face_0, face_1] in records {
        if face_1 == NO_FACE || face_0 & INCONSISTENT_BIT != 0 {
            names.clear();
            return Spared::Never;
        }
        let [first, second] = [face_0, face_1].map(|slot| slot / CLUSTER_FACES as u32);
        if first != second {
            spared = Spared::Alike;
        }
        names.extend([first, second]);
    }
    names.sort_unstable();
    names.dedup();
    spared
}
