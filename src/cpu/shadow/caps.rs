//! Caps: lists of the faces that caps are drawn from.

use super::casting::{cap_class, casts};
use super::pyramid::misses_pyramid;
use crate::cpu::extract::facing::is_finite;
use crate::layout::{ShadowLight, ShadowView};
use crate::shadow::{COUNT_Z_PASS, COUNT_ZP_PLUS};

/// Two lists of faces for each light, in the order of the faces: those whose cap counts up on its front, and those
/// whose cap counts up on its back. `facing` has ⌈N/32⌉ planes of facing masks. The lists leave out faces that name a
/// vertex twice, or have a missing corner or one that is not finite.
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
