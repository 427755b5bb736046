//! Polygon masks: the masks of a polygon, from how lights see its boundary.

use super::orientation::Orientation;

/// Masks of one polygon for 32 lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PolygonMasks {
    /// The lights that it faces.
    pub facing: u32,
    /// The lights for which it is twisted.
    pub twisted: u32,
    /// The lights for which it counts nowhere: those for which it is twisted, those in a plane with all its corners, and
    /// all lights if a corner is not finite.
    pub excluded: u32,
}

/// The masks of the lights that are given by their bits, with what each sees.
pub fn polygon_masks(seen: impl IntoIterator<Item = (usize, Orientation)>) -> PolygonMasks {
    seen.into_iter().fold(PolygonMasks::default(), |masks, (bit, seen)| PolygonMasks {
        facing: masks.facing | u32::from(seen == Orientation::FrontFacing) << bit,
        twisted: masks.twisted | u32::from(seen == Orientation::Twisted) << bit,
        excluded: masks.excluded | u32::from(matches!(seen, Orientation::Twisted | Orientation::InPlane)) << bit,
    })
}
