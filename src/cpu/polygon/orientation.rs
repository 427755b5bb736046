//! The side of a polygon that a light sees.

/// The side of a polygon that a light sees, decided by its boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Orientation {
    /// Its boundary is simple and counter-clockwise.
    FrontFacing,
    /// Its boundary is simple and clockwise.
    BackFacing,
    /// Each edge is in one plane with the light and each corner. The light sees no area.
    InPlane,
    /// All others: the boundary crosses itself, goes around the light, or has a hole outside its outer loop.
    Twisted,
}
