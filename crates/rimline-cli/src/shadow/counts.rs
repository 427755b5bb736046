//! Whether eight bits of stencil hold what is counted.

use rimline::gpu::{ReadError, read_back_vec};
use rimline::reference::cpu;
use rimline::reference::layout::{SeenLight, ShadowLight, ShadowStatistics};
use rimline::reference::shadow::CAST_NOTHING;

use super::caster::Caster;
use crate::device::Gpu;
use crate::output::note;

/// The most that the stencil counts to; 256 looks like 0.
const MOST: u64 = 255;

/// A bound on stencil counts. All casters count into one stencil, so theirs add up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct CountBound {
    /// No count exceeds it, for any light.
    pub(crate) count_bound: u64,
    /// Lights, or samples, whose counts may exceed what the stencil holds.
    pub(crate) may_wrap: usize,
}

impl CountBound {
    /// `casters` have their lights, and what they found for all of those.
    pub(super) fn new(casters: &[(&[ShadowLight], ShadowStatistics)]) -> Self {
        if let [(_, alone)] = casters {
            return Self { count_bound: alone.count_bound.into(), may_wrap: alone.may_wrap as usize };
        }
        let lights = casters.first().map_or(0, |(lights, _)| lights.len());
        let bound = |light: usize| -> u64 {
            let casts = casters.iter().filter(|(lights, _)| lights[light].casting != CAST_NOTHING);
            casts.map(|(_, found)| u64::from(found.count_bound)).sum()
        };
        Self {
            count_bound: (0..lights).map(bound).max().unwrap_or(0),
            may_wrap: (0..lights).filter(|&light| bound(light) > MOST).count(),
        }
    }

    /// Of what was encoded and submitted. Waits for the device.
    pub(crate) fn read(gpu: &Gpu, casters: &[Caster], samples: usize) -> Result<Self, ReadError> {
        let mut found = Vec::with_capacity(casters.len());
        for caster in casters {
            found.push(read(gpu, caster, samples)?);
        }
        let found: Vec<_> = found.iter().map(|(lights, statistics)| (lights.as_slice(), *statistics)).collect();
        Ok(Self::new(&found))
    }

    /// The larger of both.
    pub(crate) fn max(self, other: Self) -> Self {
        Self { count_bound: self.count_bound.max(other.count_bound), may_wrap: self.may_wrap.max(other.may_wrap) }
    }

    /// Tells the user where counts may wrap.
    pub(crate) fn warn(self) {
        let Self { count_bound, may_wrap } = self;
        if may_wrap > 0 {
            note(&format!(
                "shadows may be wrong where 256 or more faces overlap as seen from the eye: the stencil has 8 bits, and \
                 the models may overlap up to {count_bound} times. Draw fewer files at once, or models with fewer \
                 layers; `rimline query` counts without this limit"
            ));
        }
    }
}

/// A caster's lights, and what it found for them.
pub(super) fn read(
    gpu: &Gpu,
    caster: &Caster,
    samples: usize,
) -> Result<(Vec<ShadowLight>, ShadowStatistics), ReadError> {
    let mut seen: Vec<SeenLight> = read_back_vec(&gpu.device, &gpu.queue, caster.volumes.seen())?;
    seen.truncate(samples);
    let words: Vec<u32> = read_back_vec(&gpu.device, &gpu.queue, caster.volumes.choices())?;
    let lights = cpu::chosen(&caster.volumes.shape(), &seen, &words);
    let statistics: Vec<ShadowStatistics> = read_back_vec(&gpu.device, &gpu.queue, caster.volumes.statistics())?;
    Ok((lights, statistics.first().copied().unwrap_or(bytemuck::Zeroable::zeroed())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn the_casters_of_a_light_add_up() {
        let light = |casting| ShadowLight { casting, ..Zeroable::zeroed() };
        let found = |count_bound, may_wrap| ShadowStatistics { count_bound, may_wrap, ..Zeroable::zeroed() };
        let (both, second) = ([light(1), light(2)], [light(0), light(1)]);
        let bound = CountBound::new(&[(&both, found(200, 0)), (&second, found(100, 0))]);
        assert_eq!(bound, CountBound { count_bound: 300, may_wrap: 1 });
        let alone = CountBound::new(&[(&both, found(700, 1))]);
        assert_eq!(alone, CountBound { count_bound: 700, may_wrap: 1 });
        assert_eq!(CountBound::new(&[(&both, found(255, 0))]).may_wrap, 0);
    }
}
