//! Whether volumes can be made with some options.

use super::options::{DanglingEdges, DepthEdges, DepthMapOptions};
use super::texture::MAP_FORMATS;
use super::volumes_errors::DepthMapVolumesError;

impl DepthMapOptions {
    /// Whether volumes can be made with them.
    pub(super) fn check(&self) -> Result<(), DepthMapVolumesError> {
        match self.edges {
            DepthEdges::EveryCell if self.objects => return Err(DepthMapVolumesError::EveryCell("objects")),
            DepthEdges::EveryCell if self.dangling.is_some() => {
                return Err(DepthMapVolumesError::EveryCell("dangling"));
            }
            DepthEdges::Differences { threshold } if !(0.0..=1.0).contains(&threshold) => {
                return Err(DepthMapVolumesError::Threshold(threshold));
            }
            DepthEdges::WorldDifferences { threshold } if !(threshold.is_finite() && threshold >= 0.0) => {
                return Err(DepthMapVolumesError::WorldThreshold(threshold));
            }
            DepthEdges::SecondDifferences { low, high } if !(0.0 <= low && low <= high && high <= 1.0) => {
                return Err(DepthMapVolumesError::SecondThresholds { low, high });
            }
            _ => {}
        }
        if let Some(DanglingEdges { share, cells }) = self.dangling
            && !((0.0..=1.0).contains(&share) && (1..=64).contains(&cells))
        {
            return Err(DepthMapVolumesError::Dangling { share, cells });
        }
        if !(self.slope_bias.is_finite() && self.slope_bias >= 0.0) {
            return Err(DepthMapVolumesError::Bias(self.slope_bias));
        }
        if !(1..=8).contains(&self.bits) {
            return Err(DepthMapVolumesError::Bits(self.bits));
        }
        match self.rounded_to {
            Some(format) if !MAP_FORMATS.contains(&format) => Err(DepthMapVolumesError::RoundedTo(format)),
            _ => Ok(()),
        }
    }
}
