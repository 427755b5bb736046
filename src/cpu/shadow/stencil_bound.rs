//! Stencil bound: an upper bound of the stencil counts of a light.

use super::stencil_crossings::{CastingSide, stencil_crossings};
use super::stencil_pencil::{BINS, CastingBox, stencil_pencil};

/// The bound of a row of [`super::stencil_crossings::stencil_crossings`]: half of the weights that a half plane crosses at
/// most, and the faces of casters that the axis may meet, but no more than there are faces.
pub fn stencil_bound(row: &[u32]) -> u32 {
    let (bins, others) = row.split_at(row.len().min(BINS));
    let mut crossed = 0_u32;
    let sums = bins.iter().map(|&change| {
        crossed = crossed.wrapping_add(change);
        crossed
    });
    let most = sums.max().unwrap_or(0);
    match *others {
        [_, met, all, ..] => all.min(most.div_ceil(2) + met),
        _ => 0,
    }
}

/// The bound for `light`, which is homogeneous in world space, and the casters that cast for it, with their sides.
pub fn bound_casters(light: [f32; 4], casters: Vec<(CastingBox, Vec<CastingSide>)>) -> u32 {
    let boxes: Vec<CastingBox> = casters.iter().map(|(own, _)| *own).collect();
    stencil_bound(&stencil_crossings(&stencil_pencil(light, &boxes), casters))
}
