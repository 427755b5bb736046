//! Per edge: the method as published in 2003. Both faces' plane equations are tested at each edge anew, so bits of the
//! same face may differ from edge to edge.

use super::Threads;
use super::facing::normal;
use crate::layout::{Masks, live_bits};
use crate::mesh::{INCONSISTENT, Mesh, NO_FACE};
use crate::{Light, light};

/// Silhouette and winding masks: ⌈N/32⌉ planes of one [`Masks`] an edge record. Vertices that `positions` lacks count
/// as NaN.
pub fn per_edge(positions: &[[f32; 3]], mesh: &Mesh, lights: &[Light], threads: Threads) -> Vec<Masks> {
    let corners = edge_corners(mesh);
    let mut masks = vec![Masks { silhouette: 0, winding: 0 }; corners.len() * light::words(lights.len())];
    for (lights, plane) in lights.chunks(32).zip(masks.chunks_mut(corners.len().max(1))) {
        threads.share(plane, |first, masks| {
            for (masks, &corners) in masks.iter_mut().zip(&corners[first..]) {
                *masks = edge_masks(positions, corners, lights);
            }
        });
    }
    masks
}

/// The four vertices of each edge record as the 2003 method wants them, `(a, b, c, d)`: face 0 is `(a, b, c)`; face 1
/// is `(b, a, d)`, or `(a, b, d)` where bit 31 of `a` is set; where there is no face 1, `d` is [`NO_FACE`].
pub(crate) fn edge_corners(mesh: &Mesh) -> Vec<[u32; 4]> {
    let opposite = |face: u32, [a, b]: [u32; 2]| {
        let corners = mesh.faces().get(face as usize).into_iter().flatten();
        corners.copied().find(|&v| v != a && v != b).unwrap_or(NO_FACE)
    };
    let records = mesh.edges();
    let packed = records.vertices().iter().zip(records.packed_faces());
    packed
        .map(|(&[a, b], &[face_0, face_1])| {
            let c = opposite(face_0 & !INCONSISTENT, [a, b]);
            let d = if face_1 == NO_FACE { NO_FACE } else { opposite(face_1, [a, b]) };
            [a | face_0 & INCONSISTENT, b, c, d]
        })
        .collect()
}

fn edge_masks(positions: &[[f32; 3]], [a, b, c, d]: [u32; 4], lights: &[Light]) -> Masks {
    let position = |vertex: u32| positions.get(vertex as usize).copied().unwrap_or([f32::NAN; 3]);
    let is_inconsistent = a & INCONSISTENT != 0;
    let (a, b) = (position(a & !INCONSISTENT), position(b));
    let winding = plane_mask(a, b, position(c), lights);
    let silhouette = match d {
        NO_FACE => live_bits(lights.len()),
        _ if is_inconsistent => !(winding ^ plane_mask(a, b, position(d), lights)) & live_bits(lights.len()),
        _ => winding ^ plane_mask(b, a, position(d), lights),
    };
    Masks { silhouette, winding }
}

/// One bit a light: in front of the plane through the three points.
fn plane_mask(a: [f32; 3], b: [f32; 3], c: [f32; 3], lights: &[Light]) -> u32 {
    let n = normal(a, b, c);
    let d = -(n[0] * a[0] + n[1] * a[1] + n[2] * a[2]);
    lights.iter().enumerate().fold(0, |mask, (bit, light)| {
        let [x, y, z, w] = light.to_array();
        mask | u32::from(n[0] * x + n[1] * y + n[2] * z + d * w > 0.0) << bit
    })
}
