//! Edges: silhouette and winding masks of the edge records, from the facing masks of their faces.

use crate::cpu::common::parallel::Threads;
use crate::layout::{EdgeMasks, live_bits};
use crate::light;
use crate::mesh::{EdgeRecords, INCONSISTENT_BIT, NO_FACE};

/// Silhouette and winding masks: ⌈N/32⌉ planes with one [`EdgeMasks`] for each edge record. `facing` has planes of
/// `face_count` facing masks for `light_count` lights. Missing facing masks count as zeros.
pub fn edges(
    records: &EdgeRecords,
    facing: &[u32],
    face_count: usize,
    light_count: usize,
    threads: Threads,
) -> Vec<EdgeMasks> {
    let mut masks = Vec::new();
    edges_into(&mut masks, records, facing, face_count, light_count, threads);
    masks
}

/// As [`edges`], into a vector that is reused.
pub(crate) fn edges_into(
    masks: &mut Vec<EdgeMasks>,
    records: &EdgeRecords,
    facing: &[u32],
    face_count: usize,
    light_count: usize,
    threads: Threads,
) {
    masks.resize(records.len() * light::batches(light_count), EdgeMasks { silhouette: 0, winding: 0 });
    fill(masks, records, facing, face_count, light_count, threads, |masks| masks);
}

/// Only the silhouette masks, into a vector that is reused. Their layout is that of [`edges`]. Winding masks are the
/// facing masks of face 0 of each record, so a caller that needs few of them can read those.
pub fn silhouettes_into(
    silhouettes: &mut Vec<u32>,
    records: &EdgeRecords,
    facing: &[u32],
    face_count: usize,
    light_count: usize,
    threads: Threads,
) {
    silhouettes.resize(records.len() * light::batches(light_count), 0);
    fill(silhouettes, records, facing, face_count, light_count, threads, |masks| masks.silhouette);
}

/// Fills planes with the part of each record's masks that `keep` selects.
fn fill<T: Send>(
    planes: &mut [T],
    records: &EdgeRecords,
    facing: &[u32],
    face_count: usize,
    light_count: usize,
    threads: Threads,
    keep: impl Fn(EdgeMasks) -> T + Sync,
) {
    let counts = records.counts();
    let is_closed = counts.boundary == 0 && counts.inconsistent == 0;
    let planes = planes.chunks_mut(records.len().max(1)).zip(facing.chunks(face_count.max(1)));
    for (batch, (plane, facing)) in planes.enumerate() {
        let live = live_bits(light_count - 32 * batch);
        threads.share(plane, |first, kept| {
            let records = kept.iter_mut().zip(&records.packed_faces()[first..]);
            if is_closed {
                records.for_each(|(kept, &faces)| *kept = keep(consistent_masks(faces, facing)));
            } else {
                records.for_each(|(kept, &faces)| *kept = keep(edge_masks(faces, facing, live)));
            }
        });
    }
}

/// A facing mask, or zeros if it is missing.
fn mask(facing: &[u32], face: u32) -> u32 {
    facing.get(face as usize).copied().unwrap_or(0)
}

/// The bits of one consistent edge record.
fn consistent_masks([face_0, face_1]: [u32; 2], facing: &[u32]) -> EdgeMasks {
    let winding = mask(facing, face_0);
    EdgeMasks { silhouette: winding ^ mask(facing, face_1), winding }
}

/// The bits of one edge record.
fn edge_masks([face_0, face_1]: [u32; 2], facing: &[u32], live: u32) -> EdgeMasks {
    let mask = |face: u32| mask(facing, face);
    let winding = mask(face_0 & !INCONSISTENT_BIT);
    let silhouette = match face_1 {
        NO_FACE => live,
        _ if face_0 & INCONSISTENT_BIT != 0 => !(winding ^ mask(face_1)) & live,
        _ => winding ^ mask(face_1),
    };
    EdgeMasks { silhouette, winding }
}
