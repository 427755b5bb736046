//! How often an edge's side is drawn, and which way it is wound. The WGSL is `wgsl/shadow/lists.wgsl`.

use crate::mesh::{INCONSISTENT_BIT, NO_FACE};
use crate::shadow::{CAST_AVERTED, CAST_EVERY};

/// A face at an edge.
#[derive(Clone, Copy, Debug)]
pub struct EdgeFace {
    /// Whether it faces the light.
    pub facing: bool,
    /// Whether it counts nowhere.
    pub excluded: bool,
}

/// The weight of an edge's side, 0 to 2, and its winding: if set, `(b, a, far a, far b)` is counter-clockwise as seen from
/// outside the volume. `packed` is the edge record; see [`crate::mesh::EdgeRecords::packed_faces`]. `at` are its faces.
pub fn side_of_edge(casting: u32, packed: [u32; 2], at: [EdgeFace; 2]) -> (u32, bool) {
    let [first, second] = at;
    let is_boundary = packed[1] == NO_FACE;
    match casting {
        CAST_AVERTED => {
            let casts = |face: EdgeFace| !face.facing && !face.excluded;
            (u32::from(casts(first) != (!is_boundary && casts(second))), !casts(first))
        }
        CAST_EVERY => {
            let sign = |face: EdgeFace| match face {
                EdgeFace { excluded: true, .. } => 0_i32,
                EdgeFace { facing, .. } => {
                    if facing {
                        1
                    } else {
                        -1
                    }
                }
            };
            let other = match packed {
                [_, NO_FACE] => 0,
                [first, _] if first & INCONSISTENT_BIT != 0 => sign(second),
                _ => -sign(second),
            };
            let multiplicity = sign(first) + other;
            (multiplicity.unsigned_abs(), multiplicity > 0)
        }
        _ => (0, false),
    }
}
