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
    /// All others: the boundary crosses or touches itself, but for corners at one point, goes around the light, or has a
    /// hole outside its outer loop.
    Twisted,
}

impl Orientation {
    /// The side of a boundary whose edges do not meet, by the winding number on the left of each edge. On the right it is one
    /// less. So all of the boundary's inside has 1, or all of it has −1.
    pub(super) fn of_windings(windings: &[i32]) -> Self {
        match windings {
            [1, rest @ ..] if rest.iter().all(|&winding| winding == 1) => Self::FrontFacing,
            [0, rest @ ..] if rest.iter().all(|&winding| winding == 0) => Self::BackFacing,
            _ => Self::Twisted,
        }
    }
}
