//! Seen: the ways in which a light may see an outline.

/// How a light sees an outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// It is simple and counter-clockwise.
    Facing,
    /// It is simple and clockwise.
    Averted,
    /// Each of its edges is in one plane with the light and each corner. So it has no extent as seen from the light.
    InPlane,
    /// Anything else: it crosses itself, or goes around the light, or has a hole that is not in its outer loop.
    Twisted,
}
