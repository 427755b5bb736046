//! List sides: lists the edges whose sides are drawn, for each light.

use super::multiplicity::{EdgeFace, side_of_edge};
use crate::cpu::extract::compact::WINDING;
use crate::layout::ShadowLight;
use crate::mesh::{INCONSISTENT_BIT, NO_FACE};
use crate::shadow::{COUNT_ZP_PLUS, COUNT_ZP_PLUS_2005};

/// Two lists of sides for each light, in the order of the edges: plain ones, and those that are clipped at the near plane. An
/// entry is the edge's index, with the winding of its side as bit 31. A side of weight 2 is there twice. `capped` tells
/// for each light whether any near cap was found; without one its sides are not clipped. `faces` are the packed faces of the edge
/// records. `facing` and `excluded` have ⌈N/32⌉ planes of masks, one `u32` a face of the mesh.
///
/// # Panics
/// If a plane is shorter than the faces that records name.
pub fn list_sides(
    faces: &[[u32; 2]],
    facing: &[u32],
    excluded: &[u32],
    face_count: usize,
    lights: &[ShadowLight],
    capped: &[bool],
) -> Vec<[Vec<u32>; 2]> {
    let mut lists = vec![[const { Vec::new() }; 2]; lights.len()];
    let planes = facing.chunks(face_count.max(1)).zip(excluded.chunks(face_count.max(1)));
    let batches = lights.chunks(32).zip(capped.chunks(32)).zip(lists.chunks_mut(32)).zip(planes);
    for (((lights, capped), lists), (facing, excluded)) in batches {
        for (((bit, light), &capped), [plain, clipped]) in (0..).zip(lights).zip(capped).zip(lists) {
            let is_clipped = match light.counting {
                COUNT_ZP_PLUS => capped,
                COUNT_ZP_PLUS_2005 => true,
                _ => false,
            };
            let list = if is_clipped { clipped } else { plain };
            for (edge, &packed) in (0..).zip(faces) {
                let at = packed.map(|face| match face {
                    NO_FACE => EdgeFace { facing: false, excluded: false },
                    face => {
                        let face = (face & !INCONSISTENT_BIT) as usize;
                        let is_set = |plane: &[u32]| plane[face] >> bit & 1 != 0;
                        EdgeFace { facing: is_set(facing), excluded: light.excludes != 0 && is_set(excluded) }
                    }
                });
                let (weight, winding) = side_of_edge(light.casting, packed, at);
                let entry = edge | if winding { WINDING } else { 0 };
                list.extend((0..weight).map(|_| entry));
            }
        }
    }
    lists
}
