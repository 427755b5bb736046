//! Edges: silhouette and winding masks of the edge records, from the facing masks of their faces.
//!
//! A face that is twisted counts nowhere: its edges are boundaries of its neighbours.

use crate::cpu::common::parallel::Threads;
use crate::layout::{EdgeMasks, low_bits};
use crate::light;
use crate::mesh::{EdgeRecords, INCONSISTENT_BIT, NO_FACE};

/// Silhouette and winding masks: ⌈N/32⌉ planes with one [`EdgeMasks`] for each edge record. `facing` has planes of
/// `face_count` facing masks for `light_count` lights, without bits of other lights. Masks that the last plane lacks count
/// as zeros.
pub fn edges(
    records: &EdgeRecords,
    facing: &[u32],
    face_count: usize,
    light_count: usize,
    threads: Threads,
) -> Vec<EdgeMasks> {
    let mut masks = Vec::new();
    edges_into(&mut masks, records, FaceMasks { facing, twisted: &[] }, face_count, light_count, threads);
    masks
}

/// Masks of faces, in ⌈N/32⌉ planes. Facing masks that the last plane lacks count as zeros. `twisted` is complete or empty.
#[derive(Clone, Copy)]
pub(crate) struct FaceMasks<'a> {
    pub(crate) facing: &'a [u32],
    pub(crate) twisted: &'a [u32],
}

/// Like [`edges`], into a vector that is reused. Planes that `faces` lacks altogether keep what they held.
pub(crate) fn edges_into(
    masks: &mut Vec<EdgeMasks>,
    records: &EdgeRecords,
    faces: FaceMasks<'_>,
    face_count: usize,
    light_count: usize,
    threads: Threads,
) {
    masks.resize(records.len() * light::batches(light_count), EdgeMasks { silhouette: 0, winding: 0 });
    fill(masks, records, faces, face_count, light_count, threads, |masks| masks);
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
    let faces = FaceMasks { facing, twisted: &[] };
    fill(silhouettes, records, faces, face_count, light_count, threads, |masks| masks.silhouette);
}

/// Fills planes with the part of each record's masks that `keep` selects.
fn fill<T: Send>(
    planes: &mut [T],
    records: &EdgeRecords,
    faces: FaceMasks<'_>,
    face_count: usize,
    light_count: usize,
    threads: Threads,
    keep: impl Fn(EdgeMasks) -> T + Sync,
) {
    let counts = records.counts();
    let is_closed = counts.boundary == 0 && counts.inconsistent == 0;
    let planes = planes.chunks_mut(records.len().max(1)).zip(faces.facing.chunks(face_count.max(1)));
    for (batch, (plane, facing)) in planes.enumerate() {
        let live = low_bits(light_count - 32 * batch);
        let twisted = faces.twisted.get(face_count * batch..face_count * (batch + 1)).unwrap_or_default();
        threads.share(plane, |first, words| {
            let records = words.iter_mut().zip(&records.packed_faces()[first..]);
            if !twisted.is_empty() {
                records.for_each(|(word, &faces)| *word = keep(masks_beside_twisted(faces, facing, twisted, live)));
            } else if is_closed {
                records.for_each(|(word, &faces)| *word = keep(consistent_masks(faces, facing)));
            } else {
                records.for_each(|(word, &faces)| *word = keep(edge_masks(faces, facing, live)));
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

/// The bits of one edge record. Only boundary and inconsistent records mask the silhouette by `live`.
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

/// The bits of one edge record, for the lights of `live`. Bits of other lights may be set, too.
#[cfg(feature = "gpu")]
pub(crate) fn record_masks(faces: [u32; 2], masks: FaceMasks<'_>, live: u32) -> EdgeMasks {
    if masks.twisted.is_empty() {
        edge_masks(faces, masks.facing, live)
    } else {
        masks_beside_twisted(faces, masks.facing, masks.twisted, live)
    }
}

/// The bits of one edge record where faces may be twisted. Twisted faces have the sign 0. A record with one other face is
/// then the boundary of that face.
fn masks_beside_twisted([face_0, face_1]: [u32; 2], facing: &[u32], twisted: &[u32], live: u32) -> EdgeMasks {
    let is_inconsistent = face_0 & INCONSISTENT_BIT != 0;
    let (f0, f1) = (mask(facing, face_0 & !INCONSISTENT_BIT), mask(facing, face_1));
    let counts = |face: u32| live & !mask(twisted, face);
    let counts_0 = counts(face_0 & !INCONSISTENT_BIT);
    let counts_1 = if face_1 == NO_FACE { 0 } else { counts(face_1) };
    // Face 1 walks the edge against face 0, unless the record is inconsistent.
    let turned_1 = if is_inconsistent { f1 } else { !f1 };
    let alone = counts_0 ^ counts_1;
    let both = counts_0 & counts_1;
    EdgeMasks { silhouette: alone | both & !(f0 ^ turned_1), winding: counts_0 & f0 | !counts_0 & counts_1 & turned_1 }
}
