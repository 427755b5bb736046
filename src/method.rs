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

/// How a face's side is decided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Predicate {
    /// By the sign in exact arithmetic, for every finite position and light: the same bits on every device. A filter in
    /// `f32` decides almost all pairs of face and light, integers the rest. See NUMERICS.md, "Filter".
    #[default]
    Exact,
    /// By the sign that `f32` arithmetic gives: wrong for some lights that are nearly in a face's plane, and not the
    /// same on all devices. Silhouettes close all the same.
    Fast,
}
