//! Caps: lists of the faces that caps are drawn from.

use super::casting::{LISTS, casts, far_kind, has_far_caps, near_kind};
use super::pyramid::misses_pyramid;
use crate::cpu::common::positions::is_finite;
use crate::layout::{ShadowLight, ShadowView};
use crate::shadow::{COUNT_ZP_PLUS, COUNT_ZP_PLUS_2005};

/// Four lists of faces for each light, in the order of the faces: near caps that count up on their front and on their back,
/// then other caps likewise. `facing` has ⌈N/32⌉ planes of facing masks. `excluded` has as many planes of
/// [`excluded`](crate::cpu::extract::exact_facing::excluded) masks. The lists leave out excluded faces, and those that
/// name a vertex twice, or have a missing corner or one that is not finite. `in_depth`: the depth buffer has the caster.
pub fn caps(
    view: &ShadowView,
    positions: &[[f32; 3]],
    faces: &[[u32; 3]],
    facing: &[u32],
    excluded: &[u32],
    lights: &[ShadowLight],
    in_depth: bool,
) -> Vec<[Vec<u32>; LISTS]> {
    let mut lists = vec![[const { Vec::new() }; LISTS]; lights.len()];
    for (number, &face) in (0..).zip(faces) {
        let [a, b, c] = face;
        let corners = face.map(|vertex| positions.get(vertex as usize).copied().unwrap_or([f32::NAN; 3]));
        if a == b || b == c || c == a || !corners.iter().all(|&corner| is_finite(corner)) {
            continue;
        }
        let planes = facing.chunks(faces.len()).zip(excluded.chunks(faces.len()));
        for ((lights, lists), planes) in lights.chunks(32).zip(lists.chunks_mut(32)).zip(planes) {
            let mask = |plane: &[u32]| plane.get(number as usize).copied().unwrap_or(0);
            let (facing, excluded) = (mask(planes.0), mask(planes.1));
            for ((bit, light), lists) in (0..).zip(lights).zip(lists) {
                let [facing, excluded] = [facing, excluded].map(|mask| mask >> bit & 1 != 0);
                if !casts(light, facing) || (excluded && light.excludes != 0) {
                    continue;
                }
                let is_near = match light.counting {
                    COUNT_ZP_PLUS => !misses_pyramid(view, light, &corners),
                    counting => counting == COUNT_ZP_PLUS_2005,
                };
                if is_near {
                    lists[near_kind(light, facing)].push(number);
                }
                if has_far_caps(light, in_depth) {
                    lists[far_kind(facing)].push(number);
                }
            }
        }
    }
    lists
}
