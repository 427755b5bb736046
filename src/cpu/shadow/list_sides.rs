//! List sides: lists the edges whose sides are drawn, for each light.

use super::multiplicity::{EdgeFace, side_of_edge};
use crate::cpu::extract::compact::WINDING;
use crate::layout::ShadowLight;
use crate::mesh::{INCONSISTENT_BIT, NO_FACE};

/// Two lists of sides for each light, in the order of the edges: those of weight 1, then those of weight 2. An entry is the
/// edge's index, with the winding of its side as bit 31. `faces` are the packed faces of the edge records. `facing` and
/// `excluded` have ⌈N/32⌉ planes of masks, one `u32` a face of the mesh.
///
/// # Panics
/// If a plane is shorter than the faces that records name.
pub fn list_sides(
    faces: &[[u32; 2]],
    facing: &[u32],
    excluded: &[u32],
    face_count: usize,
    lights: &[ShadowLight],
) -> Vec<[Vec<u32>; 2]> {
    let mut lists = vec![[const { Vec::new() }; 2]; lights.len()];
    let planes = facing.chunks(face_count.max(1)).zip(excluded.chunks(face_count.max(1)));
    for ((lights, lists), (facing, excluded)) in lights.chunks(32).zip(lists.chunks_mut(32)).zip(planes) {
        for ((bit, light), [singles, doubles]) in (0..).zip(lights).zip(lists) {
            for (edge, &packed) in (0..).zip(faces) {
                let at = packed.map(|face| match face {
                    NO_FACE => EdgeFace { facing: false, excluded: false },
                    face => {
                        let face = (face & !INCONSISTENT_BIT) as usize;
                        let is_set = |plane: &[u32]| plane[face] >> bit & 1 != 0;
                        EdgeFace { facing: is_set(facing), excluded: light.excludes != 0 && is_set(excluded) }
                    }
                });
                let (weight, winding) = side_of_edge(light, packed, at);
                let entry = edge | if winding { WINDING } else { 0 };
                match weight {
                    0 => {}
                    1 => singles.push(entry),
                    _ => doubles.push(entry),
                }
            }
        }
    }
    lists
}
