//! Bounds: the box of a caster's finite faces, and whether it has other faces.

use crate::cpu::common::positions::is_finite;
use crate::mesh::is_degenerate;

/// The bits of a float as an integer with the same order as the floats.
const fn ordered(bits: u32) -> u32 {
    if bits >= 0x8000_0000 { !bits } else { bits | 0x8000_0000 }
}

/// The float of ordered bits.
pub(crate) const fn unordered(bits: u32) -> f32 {
    f32::from_bits(if bits >= 0x8000_0000 { bits & 0x7fff_ffff } else { !bits })
}

/// The box of the faces whose corners are all finite, as ordered bits: the lowest x, y, z, inverted, then the highest.
/// Without such a face all are 0. The last element is 1 if some face has a missing corner or one that is
/// not finite, and names no vertex twice; else 0.
pub fn bounds(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> [u32; 7] {
    let mut found = [0; 7];
    for face in faces {
        let corners = face.map(|vertex| positions.get(vertex as usize).copied().unwrap_or([f32::NAN; 3]));
        let [.., has_holes] = &mut found;
        if !corners.iter().all(|&corner| is_finite(corner)) {
            *has_holes |= u32::from(!is_degenerate(*face));
            continue;
        }
        for corner in corners {
            let (low, high) = found.split_at_mut(3);
            for ((low, high), bits) in low.iter_mut().zip(high).zip(corner.map(|c| ordered(c.to_bits()))) {
                *low = (!bits).max(*low);
                *high = bits.max(*high);
            }
        }
    }
    found
}
