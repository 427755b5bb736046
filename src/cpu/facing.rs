//! Facing: for each face one bit a light, set where the light lies strictly on the face's counter-clockwise side.

use super::Threads;
use crate::mesh::is_degenerate;
use crate::{Light, light};

/// Facing masks of `faces` for `lights`: ⌈N/32⌉ planes of one `u32` a face. Vertices that `positions` lacks count as
/// non-finite. `f32` arithmetic in the order of `wgsl/facing.wgsl`; see NUMERICS.md, "Facing".
pub fn facing(positions: &[[f32; 3]], faces: &[[u32; 3]], lights: &[Light], threads: Threads) -> Vec<u32> {
    let mut masks = Vec::new();
    facing_into(&mut masks, positions, faces, lights, threads);
    masks
}

/// The same into a vector that may be used again. Returns how many faces have a non-finite vertex.
pub(super) fn facing_into(
    masks: &mut Vec<u32>,
    positions: &[[f32; 3]],
    faces: &[[u32; 3]],
    lights: &[Light],
    threads: Threads,
) -> u32 {
    masks.resize(faces.len() * light::words(lights.len()), 0);
    let mut non_finite_faces = 0;
    for (lights, plane) in lights.chunks(32).zip(masks.chunks_mut(faces.len().max(1))) {
        let counts = threads.share(plane, |first, masks| {
            let mut non_finite_faces = 0;
            for (mask, &corners) in masks.iter_mut().zip(&faces[first..]) {
                *mask = face_mask(positions, corners, lights).unwrap_or_else(|NonFinite| {
                    non_finite_faces += 1;
                    0
                });
            }
            non_finite_faces
        });
        non_finite_faces = counts.into_iter().sum();
    }
    non_finite_faces
}

/// A face has an infinite or NaN vertex, or one that is not there.
struct NonFinite;

/// The bits of one face for up to 32 lights.
fn face_mask(positions: &[[f32; 3]], corners: [u32; 3], lights: &[Light]) -> Result<u32, NonFinite> {
    let [Some(&a), Some(&b), Some(&c)] = corners.map(|v| positions.get(v as usize)) else {
        return Err(NonFinite);
    };
    let n = normal(a, b, c);
    // A non-finite coordinate makes two components of the normal non-finite, so this one test stands for nine. Finite
    // ones may overflow: those faces are then decided like any other.
    if !(n[0] + n[1] + n[2]).is_finite() && ![a, b, c].into_iter().all(is_finite) {
        return Err(NonFinite);
    }
    if is_degenerate(corners) {
        return Ok(0);
    }
    Ok(match lights {
        [light] => u32::from(faces_light(n, a, *light)),
        _ => lights.iter().enumerate().fold(0, |mask, (bit, light)| {
            mask | u32::from(faces_light(n, a, *light)) << bit
        }),
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
