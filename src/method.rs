//! Methods that find silhouettes, and predicates that decide a face's side.

/// A method that turns positions into silhouette bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Decides each face once. The edges read the result, so loops always close.
    #[default]
    FaceMask,
    /// Tests both faces at each edge, as Brabec and Seidel published it in 2003. It is for comparison. A face's side is
    /// decided again at each of its edges, so loops may fail to close. It has no exact form: see [`Method::predicate`].
    PerEdge,
}

impl Method {
    /// The predicate that this method uses for a requested one. [`Method::FaceMask`] uses the requested one.
    /// [`Method::PerEdge`] replaces [`Predicate::Exact`], the default of extractors, by the published
    /// [`Predicate::Plane`].
    pub const fn predicate(self, requested: Predicate) -> Predicate {
        match (self, requested) {
            (Self::PerEdge, Predicate::Exact) => Predicate::Plane,
            _ => requested,
        }
    }

    #[cfg(feature = "gpu")]
    pub(crate) const fn is_per_edge(self) -> bool {
        matches!(self, Self::PerEdge)
    }
}

/// How a face's side is decided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Predicate {
    /// The sign in exact arithmetic, for every finite position and light. Every device gives the same bits. A filter in
    /// `f32` decides almost all pairs of face and light, and integers decide the rest. See docs/numerics/facing.md,
    /// "Filter".
    #[default]
    Exact,
    /// The sign that `f32` arithmetic gives for `n · (l − w·a)`. It is wrong for some lights that lie nearly in a
    /// face's plane, and devices may differ. It may be wrong for any light where products overflow or underflow: with
    /// coordinates above 10¹², or with tiny faces, such as faces and lights within 10⁻¹² of the origin. Silhouettes
    /// still close, because each face is decided once.
    Fast,
    /// The sign that `f32` arithmetic gives for the plane equation `n · l − w·(n · a)`, as published in 2003. It is
    /// less accurate than `Fast` far from the origin, because its terms cancel there. It is for comparison.
    #[doc(hidden)]
    Plane,
}
