//! What of a model counts how many bytes against the limit of memory.

/// What a list that grows takes at most for each byte of its elements: the old and the new array while it doubles.
pub(crate) const GROWTH: u64 = 3;
/// Bytes for a vertex and for a face: as read, then welded, then in a mesh with its edge records. As the library counts
/// those of a glTF.
pub(crate) const VERTEX: u64 = 12 * GROWTH + 128;
pub(crate) const FACE: u64 = 12 * GROWTH + 144;
/// Bytes for a polygon, for a loop, and for a corner: two copies of all arrays, an edge of the outline, a triangle and its
/// edge records.
pub(crate) const POLYGON: u64 = 4 * GROWTH + 48;
pub(crate) const LOOP: u64 = 4 * GROWTH + 32;
pub(crate) const CORNER: u64 = 4 * GROWTH + 240;
