//! Compact: lists of silhouette edges for each light, in edge order.

use crate::layout::EdgeMasks;

/// The bit of a list entry that is set if the edge's winding bit is set.
pub const WINDING: u32 = 1 << 31;

/// The list of a light.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CompactedList {
    /// Edge indices in edge order, with the winding bit as bit 31. There are at most as many as the capacity.
    pub entries: Vec<u32>,
    /// The number of silhouette edges, including those that the list has no room for.
    pub count: u32,
}

/// The list of one light over one plane of masks. `bit` is its bit in the plane, 0 to 31. The list has at most
/// `capacity` entries.
pub fn compact(plane: &[EdgeMasks], bit: u32, capacity: usize) -> CompactedList {
    let mut silhouettes = (0_u32..)
        .zip(plane)
        .filter(|(_, masks)| masks.silhouette >> bit & 1 != 0)
        .map(|(edge, masks)| edge | (masks.winding >> bit & 1) << 31);
    let entries: Vec<u32> = silhouettes.by_ref().take(capacity).collect();
    let count = (entries.len() + silhouettes.count()) as u32;
    CompactedList { entries, count }
}
