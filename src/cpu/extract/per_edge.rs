//! Per edge: the method as published in 2003. It tests both faces again at each edge, so the bits of a face may differ
//! from edge to edge.

use crate::mesh::{INCONSISTENT_BIT, Mesh, NO_FACE};
use crate::{
    Light,
    cpu::common::determinant::{local_mask, plane_mask},
    cpu::common::parallel::Threads,
    layout::{EdgeMasks, LightBatch},
    light,
    method::{Method, Predicate},
};

/// Silhouette and winding masks: ⌈N/32⌉ planes with one [`EdgeMasks`] for each edge record. [`Method::predicate`] says
/// which predicate replaces `predicate`. Vertices that `positions` lacks count as NaN.
pub fn per_edge(
    positions: &[[f32; 3]],
    mesh: &Mesh,
    lights: &[Light],
    predicate: Predicate,
    threads: Threads,
) -> Vec<EdgeMasks> {
    let by_plane = Method::PerEdge.predicate(predicate) == Predicate::Plane;
    let corners = edge_corners(mesh);
    let mut masks = vec![EdgeMasks { silhouette: 0, winding: 0 }; corners.len() * light::batches(lights.len())];
    for (lights, plane) in lights.chunks(32).zip(masks.chunks_mut(corners.len().max(1))) {
        let light_batch = LightBatch::new(lights, 0, 3);
        threads.share(plane, |first, masks| {
            for (masks, &corners) in masks.iter_mut().zip(&corners[first..]) {
                *masks = edge_masks(positions, corners, &light_batch, by_plane);
            }
        });
    }
    masks
}

/// The four vertices `(a, b, c, d)` of each edge record, as the 2003 method needs them. Face 0 is `(a, b, c)`. Face 1
/// is `(b, a, d)`, or `(a, b, d)` if bit 31 of `a` is set. If there is no face 1, `d` is [`NO_FACE`].
pub(crate) fn edge_corners(mesh: &Mesh) -> Vec<[u32; 4]> {
    let opposite = |face: u32, [a, b]: [u32; 2]| {
        // A polygon stands for its triangle at the edge.
        let face = face as usize;
        let triangles = mesh.polygons().map_or(face..face + 1, |polygons| polygons.triangles(face));
        let mut at_edge = mesh.faces()[triangles].iter().filter(|face| face.contains(&a) && face.contains(&b));
        at_edge.next().into_iter().flatten().copied().find(|&v| v != a && v != b).unwrap_or(NO_FACE)
    };
    let records = mesh.edges();
    let packed = records.vertices().iter().zip(records.packed_faces());
    packed
        .map(|(&[a, b], &[face_0, face_1])| {
            let c = opposite(face_0 & !INCONSISTENT_BIT, [a, b]);
            let d = if face_1 == NO_FACE { NO_FACE } else { opposite(face_1, [a, b]) };
            [a | face_0 & INCONSISTENT_BIT, b, c, d]
        })
        .collect()
}

fn edge_masks(positions: &[[f32; 3]], [a, b, c, d]: [u32; 4], light_batch: &LightBatch, by_plane: bool) -> EdgeMasks {
    let position = |vertex: u32| positions.get(vertex as usize).copied().unwrap_or([f32::NAN; 3]);
    let mask = |a, b, c| if by_plane { plane_mask(a, b, c, light_batch) } else { local_mask(a, b, c, light_batch) };
    let is_inconsistent = a & INCONSISTENT_BIT != 0;
    let (a, b) = (position(a & !INCONSISTENT_BIT), position(b));
    let winding = mask(a, b, position(c));
    let silhouette = match d {
        NO_FACE => light_batch.active_bits,
        _ if is_inconsistent => !(winding ^ mask(a, b, position(d))) & light_batch.active_bits,
        _ => winding ^ mask(b, a, position(d)),
    };
    EdgeMasks { silhouette, winding }
}
