//! Stencil crossings: the sides that cross the half planes of a pencil.

use glam::Vec3;

use super::stencil_pencil::{AROUND, BINS, CastingBox};
use crate::cpu::common::positions::is_finite;
use crate::layout::StencilPencil;

/// The positions of the ends of a side's edge in world space, and the side's weight.
pub type CastingSide = ([[f32; 3]; 2], u32);

/// The row of a pencil for casters with their sides: for each bin the weights that begin there less those that ended in the
/// bin before, then one more end, the faces of the casters that the axis may meet, the faces of all casters, and a 0.
pub fn stencil_crossings(
    pencil: &StencilPencil,
    casters: impl IntoIterator<Item = (CastingBox, Vec<CastingSide>)>,
) -> Vec<u32> {
    let mut bins = vec![0_u32; BINS + 1];
    let (mut met, mut all) = (0, 0);
    for (caster, sides) in casters {
        all += caster.faces;
        if pencil.meets(&caster) {
            met += caster.faces;
            continue;
        }
        for (ends, weight) in sides {
            if ends.iter().all(|&end| is_finite(end)) {
                cross_edge(pencil, &mut bins, ends.map(Vec3::from), weight);
            }
        }
    }
    bins.extend([met, all, 0]);
    bins
}

pub(super) fn cross_edge(pencil: &StencilPencil, bins: &mut [u32], ends: [Vec3; 2], weight: u32) {
    let [p, q] = ends.map(|end| pencil.half_plane(end));
    let bin = |at: f32| ((at - pencil.first) * pencil.scale).clamp(0.0, (BINS - 1) as f32) as usize;
    let (first, last) = (bin(p.min(q)), bin(p.max(q)));
    let mut cross = |first: usize, last: usize| {
        bins[first] = bins[first].wrapping_add(weight);
        bins[last + 1] = bins[last + 1].wrapping_sub(weight);
    };
    // An edge that does not meet the axis goes the shorter way around it.
    if pencil.kind == AROUND && (p - q).abs() > 2.0 {
        cross(0, first);
        cross(last, BINS - 1);
    } else {
        cross(first, last);
    }
}
