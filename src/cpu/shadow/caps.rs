//! Caps: lists of the faces that caps are drawn from.

use super::casting::{cap_class, casts};
use super::pyramid::misses_pyramid;
use crate::cpu::extract::facing::is_finite;
use crate::layout::{ShadowLight, ShadowView};
use crate::shadow::{COUNT_Z_PASS, COUNT_ZP_PLUS};

/// For each light two lists of faces in their order: those whose cap counts up on its front, and on its back. `facing`
/// is ⌈N/32⌉ planes of facing masks. Faces that name a vertex twice or a missing one, or have a corner that is not
/// finite, are in no list.
pub fn caps(
    view: &ShadowView,
    positions: &[[f32; 3]],
    faces: &[[u32; 3]],
    facing: &[u32],
    lights: &[ShadowLight],
) -> Vec<[Vec<u32>; 2]> {
    let mut lists = vec![[Vec::new(), Vec::new()]; lights.len()];
    for (number, &face) in (0..).zip(faces) {
        let [a, b, c] = face;
        let corners = face.map(|vertex| positions.get(vertex as usize).copied().unwrap_or([f32::NAN; 3]));
        if a == b || b == c || c == a || !corners.iter().all(|&corner| is_finite(corner)) {
            continue;
        }
        let planes = lights.chunks(32).zip(lists.chunks_mut(32)).zip(facing.chunks(faces.len()));
        for ((lights, lists), plane) in planes {
            let mask = plane.get(number as usize).copied().unwrap_or(0);
            for ((bit, light), lists) in (0..).zip(lights).zip(lists) {
                let facing = mask >> bit & 1 != 0;
                let is_needed = match light.counting {
                    COUNT_Z_PASS => light.end != 0.0,
                    COUNT_ZP_PLUS => !misses_pyramid(view, light, &corners),
                    _ => true,
                };
                if casts(light, facing) && is_needed {
                    let [front, back] = lists;
                    if cap_class(light, facing) == 0 { front } else { back }.push(number);
                }
            }
        }
    }
    lists
}
