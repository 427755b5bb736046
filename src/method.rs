//! How silhouettes are found.

/// The way from positions to silhouette bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Each face is decided once, and its edges read that: loops always close.
    #[default]
    FaceMask,
    /// As published by Brabec and Seidel in 2003: each edge tests both its faces. For comparison; loops may fail to
    /// close, since a face's side is decided again at each of its edges. It has no exact form: see
    /// [`Method::predicate`].
    #[cfg(feature = "reference")]
    PerEdge,
}

impl Method {
    /// How this method decides a face's side when `asked` is asked for: as asked, but for the per-edge method, for which
    /// [`Predicate::Exact`], the default of all options, stands for the published [`Predicate::Plane`].
    pub const fn predicate(self, asked: Predicate) -> Predicate {
        match (self, asked) {
            #[cfg(feature = "reference")]
            (Self::PerEdge, Predicate::Exact) => Predicate::Plane,
            _ => asked,
        }
    }

    pub(crate) const fn is_per_edge(self) -> bool {
        !matches!(self, Self::FaceMask)
    }
}

/// How a face's side is decided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Predicate {
    /// By the sign in exact arithmetic, for every finite position and light: the same bits on every device. A filter in
    /// `f32` decides almost all pairs of face and light, integers the rest. See NUMERICS.md, "Filter".
    #[default]
    Exact,
    /// By the sign that `f32` arithmetic gives for `n · (l − w·a)`: wrong for some lights that are nearly in a face's
    /// plane, and not the same on all devices. With face masks, silhouettes close all the same.
    Fast,
    /// As `Fast`, by the plane's equation `n · l − w·(n · a)`, as published in 2003. Less accurate far from the origin,
    /// where it cancels; for comparison.
    #[cfg(feature = "reference")]
    Plane,
}

impl Predicate {
    pub(crate) const fn is_plane(self) -> bool {
        !matches!(self, Self::Exact | Self::Fast)
    }
}
