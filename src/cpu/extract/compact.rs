//! Compact: lists of silhouette edges a light, in the order of the edges.

use crate::layout::Masks;

/// Set in a list entry where the edge's winding bit is set.
pub const WINDING: u32 = 1 << 31;

/// A light's list.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CompactedList {
    /// Edge indices with the winding bit at bit 31, in the order of the edges, at most the capacity.
    pub entries: Vec<u32>,
    /// Silhouette edges there are, in the list or not.
    pub count: u32,
}

/// The list of one light (its bit in `plane`, 0 to 31) over one plane of masks, at most `capacity` entries.
pub fn compact(plane: &[Masks], bit: u32, capacity: usize) -> CompactedList {
    let mut silhouettes = (0_u32..)
        .zip(plane)
        .filter(|(_, masks)| masks.silhouette >> bit & 1 != 0)
        .map(|(edge, masks)| edge | (masks.winding >> bit & 1) << 31);
    let entries: Vec<u32> = silhouettes.by_ref().take(capacity).collect();
    let count = (entries.len() + silhouettes.count()) as u32;
    CompactedList { entries, count }
}
