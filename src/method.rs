//! How silhouettes are found.

/// The way from positions to silhouette bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Each face is decided once, and its edges read that: loops always close.
    #[default]
    FaceMask,
    /// As published by Brabec and Seidel in 2003: each edge tests the plane equations of both its faces. For
    /// comparison; loops may fail to close, since a face's side is decided again at each of its edges.
    PerEdge,
}
