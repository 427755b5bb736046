//! Whether eight bits of stencil hold what is counted, and other numbers that stages leave.

use rimline::reference::layout::ShadowStatistics;

use crate::output::note;

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
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn sums_do_not_wrap() {
        let found = |count_bound, skipped| ShadowStatistics { count_bound, skipped, ..Zeroable::zeroed() };
        let both = sum(found(200, 1), found(100, 2));
        assert_eq!((both.count_bound, both.skipped, both.capped), (300, 3, 0));
        assert_eq!(sum(found(u32::MAX, 0), found(2, 0)).count_bound, u32::MAX);
    }
}
