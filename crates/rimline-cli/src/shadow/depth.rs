//! Limits of the depth and the stencil that shadows are counted with, and other numbers that stages leave.

use rimline::internals::layout::ShadowStatistics;
use rimline::wgpu;
use wgpu::TextureFormat;

use crate::output::note;

/// Floating point where the device has it: with reversed depth that tells the same part of any distance apart, however
/// near the near plane is (docs/numerics/rasterisers.md, "Depth").
pub(crate) fn depth_format(device: &wgpu::Device) -> TextureFormat {
    let finest = TextureFormat::Depth32FloatStencil8;
    if device.features().contains(finest.required_features()) { finest } else { TextureFormat::Depth24PlusStencil8 }
}

/// Lengths that the depth format must resolve, in the models' unit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    pub(crate) near: f32,
    /// Distance of the farthest surface with a shadow.
    pub(crate) farthest: f32,
    /// The size of a pixel at a distance of 1.
    pub(crate) pixel: f32,
}

impl Seen {
    /// The nearest near plane with which 24 bits tell distances half a pixel apart: two numbers next to each other are
    /// `distance² / (2²⁴ near)` apart.
    fn nearest(self) -> f32 {
        self.farthest / (16_777_216.0 * 0.5 * self.pixel)
    }

    /// Warning for the user, if depth in this format is too coarse.
    fn warning(self, format: TextureFormat) -> Option<String> {
        let (Self { near, farthest, .. }, nearest) = (self, self.nearest());
        (format == TextureFormat::Depth24PlusStencil8 && near < nearest).then(|| {
            format!(
                "shadows {farthest} away may be wrong: depth has 24 bits on this device, too few for a near plane at {near}. \
                 Set --near to {nearest} or more, or choose a device with DEPTH32FLOAT_STENCIL8 (`rimline devices` says which \
                 have it)"
            )
        })
    }

    pub(crate) fn warn(self, format: TextureFormat) {
        if let Some(warning) = self.warning(format) {
            note(&format!("warning: {warning}"));
        }
    }
}

/// The most that the stencil counts to; 256 looks like 0.
pub(super) const MOST: u32 = 255;

/// A bound on stencil counts. All casters count into one stencil.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct CountBound {
    /// No count exceeds it, for any light.
    pub(crate) count_bound: u32,
    /// Lights, or samples, whose counts may exceed what the stencil holds.
    pub(crate) may_wrap: u32,
}

impl From<ShadowStatistics> for CountBound {
    fn from(ShadowStatistics { count_bound, may_wrap, .. }: ShadowStatistics) -> Self {
        Self { count_bound, may_wrap }
    }
}

impl CountBound {
    /// The larger of both.
    pub(crate) fn max(self, other: Self) -> Self {
        Self { count_bound: self.count_bound.max(other.count_bound), may_wrap: self.may_wrap.max(other.may_wrap) }
    }

    /// Tells the user where counts may wrap.
    pub(crate) fn warn(self) {
        let Self { count_bound, may_wrap } = self;
        if may_wrap > 0 {
            note(&format!(
                "warning: shadows may be wrong where 256 or more faces overlap as seen from the eye: the stencil has 8 bits, and \
                 the models may overlap up to {count_bound} times. Draw fewer files at once, or models with fewer \
                 layers; `rimline query` counts without this limit"
            ));
        }
    }
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
    fn coarse_depth_is_told_with_what_to_set() {
        let bits = TextureFormat::Depth24PlusStencil8;
        let seen = |near| Seen { near, farthest: 10.0, pixel: 1.0 / 1024.0 };
        // 10 · 2¹⁰ · 2 / 2²⁴.
        let nearest = 10.0 / 8192.0;
        assert_eq!(seen(1.0).nearest(), nearest);
        assert_eq!(seen(nearest).warning(bits), None);
        let warning = seen(1e-5).warning(bits).expect("10⁻⁶ of the distance is too near");
        let expected = "shadows 10 away may be wrong: depth has 24 bits on this device, too few for a near plane at 0.00001. Set \
                        --near to 0.0012207031 or more, or choose a device with DEPTH32FLOAT_STENCIL8 (`rimline devices` says \
                        which have it)";
        assert_eq!(warning, expected);
        assert_eq!(seen(1e-5).warning(TextureFormat::Depth32FloatStencil8), None);
        // Steps are half a pixel there.
        let step = |distance: f32, near: f32| distance * distance / (16_777_216.0 * near);
        assert_eq!(step(10.0, nearest), 0.5 * 10.0 / 1024.0);
    }

    #[test]
    fn sums_do_not_wrap() {
        let found = |count_bound, skipped| ShadowStatistics { count_bound, skipped, ..Zeroable::zeroed() };
        let both = sum(found(200, 1), found(100, 2));
        assert_eq!((both.count_bound, both.skipped, both.capped), (300, 3, 0));
        assert_eq!(sum(found(u32::MAX, 0), found(2, 0)).count_bound, u32::MAX);
    }
}
