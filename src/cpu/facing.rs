//! Facing: for each face one bit a light, set where the light lies strictly on the face's counter-clockwise side.

use super::Threads;
use crate::mesh::is_degenerate;
use crate::{Light, light};

/// Facing masks of `faces` for `lights`: ⌈N/32⌉ planes of one `u32` a face. Vertices that `positions` lacks count as
/// non-finite. `f32` arithmetic in the order of `wgsl/facing.wgsl`; see NUMERICS.md, "Facing".
pub fn facing(positions: &[[f32; 3]], faces: &[[u32; 3]], lights: &[Light], threads: Threads) -> Vec<u32> {
    let mut masks = vec![0; faces.len() * light::words(lights.len())];
    for (lights, plane) in lights.chunks(32).zip(masks.chunks_mut(faces.len().max(1))) {
        threads.share(plane, |first, masks| {
            for (mask, &corners) in masks.iter_mut().zip(&faces[first..]) {
                *mask = face_mask(positions, corners, lights);
            }
        });
    }
    masks
}

/// The bits of one face for up to 32 lights.
fn face_mask(positions: &[[f32; 3]], corners: [u32; 3], lights: &[Light]) -> u32 {
    let [Some(&a), Some(&b), Some(&c)] = corners.map(|v| positions.get(v as usize)) else {
        return 0;
    };
    if is_degenerate(corners) || ![a, b, c].into_iter().all(is_finite) {
        return 0;
    }
    let n = normal(a, b, c);
    lights.iter().enumerate().fold(0, |mask, (bit, light)| {
        mask | u32::from(faces_light(n, a, *light)) << bit
    })
}

/// All three coordinates are finite.
pub fn is_finite(position: [f32; 3]) -> bool {
    position.iter().all(|c| c.is_finite())
}

/// `(b − a) × (c − a)`, counter-clockwise outside.
pub(super) fn normal(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> [f32; 3] {
    let u = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let v = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    [
        u[1] * v[2] - u[2] * v[1],
        u[2] * v[0] - u[0] * v[2],
        u[0] * v[1] - u[1] * v[0],
    ]
}

fn faces_light(n: [f32; 3], a: [f32; 3], light: Light) -> bool {
    let Light { xyz: l, w } = light;
    let to_light = [l[0] - w * a[0], l[1] - w * a[1], l[2] - w * a[2]];
    n[0] * to_light[0] + n[1] * to_light[1] + n[2] * to_light[2] > 0.0
}
