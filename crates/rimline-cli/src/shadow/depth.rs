//! Limits of the depth and the stencil that shadows are counted with, and other numbers that stages leave.

use rimline::internals::layout::ShadowStatistics;
use rimline::wgpu::TextureFormat;

use crate::output::note;

/// The nearest near plane with which 24 bits tell distances half a pixel apart, where `pixel` is the size of one at a
/// distance of 1: two numbers next to each other are `distance² / (2²⁴ near)` apart.
fn nearest(farthest: f32, pixel: f32) -> f32 {
    farthest / (16_777_216.0 * 0.5 * pixel)
}

/// A warning, if depth in this format is too coarse for the farthest surface with a shadow.
pub(super) fn too_coarse(format: TextureFormat, near: f32, farthest: f32, pixel: f32) -> Option<String> {
    let nearest = nearest(farthest, pixel);
    (format == TextureFormat::Depth24PlusStencil8 && near < nearest).then(|| {
        format!(
            "shadows {farthest} away may be wrong: depth has 24 bits on this device, too few for a near plane at {near}. \
             Set --near to {nearest} or more, or choose a device with DEPTH32FLOAT_STENCIL8 (`rimline devices` says which \
             have it)"
        )
    })
}

/// The most that the stencil counts to; 256 looks like 0.
pub(super) const MOST: u32 = 255;

/// Tells the user where shadows may be wrong. Counts may wrap: no count exceeds `count_bound`, and `may_wrap` counts
/// lights, or samples, whose counts may exceed what the stencil holds. All casters count into one stencil. Pieces of
/// twisted polygons may have no room.
pub(crate) fn warn_of_limits(found: ShadowStatistics) {
    let ShadowStatistics { count_bound, may_wrap, .. } = found;
    if let Some(warning) = too_many_pieces(&found) {
        note(&warning);
    }
    if may_wrap > 0 {
        note(&format!(
            "warning: shadows may be wrong where 256 or more faces overlap as seen from the eye: the stencil has 8 bits, and \
             the models may overlap up to {count_bound} times. Draw fewer files at once, or models with fewer \
             layers; `rimline query` counts without this limit"
        ));
    }
}

/// A warning, if pieces of twisted polygons had no room.
fn too_many_pieces(&ShadowStatistics { lost_pieces, most_pieces, .. }: &ShadowStatistics) -> Option<String> {
    (lost_pieces > 0).then(|| {
        format!(
            "warning: shadows of twisted polygons are wrong: those of a file have {most_pieces} pieces for a light, and a buffer \
             of this device has no room for them. Use fewer lights, cut the file into several, or leave out --polygons"
        )
    })
}

/// Each number of one statistic and the same of the other.
pub(super) fn sum<T: bytemuck::Pod>(one: T, other: T) -> T {
    let mut sum = one;
    let words = bytemuck::cast_slice::<T, u32>(std::slice::from_ref(&other)).iter();
    let sums = bytemuck::cast_slice_mut::<T, u32>(std::slice::from_mut(&mut sum)).iter_mut();
    sums.zip(words).for_each(|(sum, word)| *sum = sum.saturating_add(*word));
    sum
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    #[test]
    fn coarse_depth_is_reported_with_what_to_set() {
        let bits = TextureFormat::Depth24PlusStencil8;
        let warning = |bits, near| too_coarse(bits, near, 10.0, 1.0 / 1024.0);
        // 10 · 2¹⁰ · 2 / 2²⁴.
        let least = 10.0 / 8192.0;
        assert_eq!(nearest(10.0, 1.0 / 1024.0), least);
        assert_eq!(warning(bits, least), None);
        let coarse = warning(bits, 1e-5).expect("10⁻⁶ of the distance is too near");
        let expected = "shadows 10 away may be wrong: depth has 24 bits on this device, too few for a near plane at 0.00001. Set \
                        --near to 0.0012207031 or more, or choose a device with DEPTH32FLOAT_STENCIL8 (`rimline devices` says \
                        which have it)";
        assert_eq!(coarse, expected);
        assert_eq!(warning(TextureFormat::Depth32FloatStencil8, 1e-5), None);
        // Steps are half a pixel there.
        let step = |distance: f32, near: f32| distance * distance / (16_777_216.0 * near);
        assert_eq!(step(10.0, least), 0.5 * 10.0 / 1024.0);
    }

    #[test]
    fn pieces_without_room_are_reported() {
        let found = |lost_pieces| ShadowStatistics { lost_pieces, most_pieces: 600, ..Zeroable::zeroed() };
        assert_eq!(too_many_pieces(&found(0)), None);
        let warning = too_many_pieces(&found(1)).expect("one is lost");
        assert!(warning.contains("have 600 pieces for a light"), "{warning}");
    }

    #[test]
    fn sums_do_not_wrap() {
        let found = |count_bound, skipped| ShadowStatistics { count_bound, skipped, ..Zeroable::zeroed() };
        let both = sum(found(200, 1), found(100, 2));
        assert_eq!((both.count_bound, both.skipped, both.near_capped), (300, 3, 0));
        assert_eq!(sum(found(u32::MAX, 0), found(2, 0)).count_bound, u32::MAX);
    }
}
