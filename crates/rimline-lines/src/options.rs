//! Classes of lines, and the options of a drawing.

use rimline::cpu::Threads;

/// Why a line is drawn. An edge that is of several classes is drawn once, as the first of them that is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
#[non_exhaustive]
pub enum LineClass {
    /// Between a face whose front the eye sees and one whose back it sees, by the exact facing bits; a face seen edge-on counts
    /// as its back. Between two fronts or two backs where the faces are wound inconsistently.
    Silhouette,
    /// An edge of one face.
    Boundary,
    /// An edge of more than two faces. Triangles that lie in two half-planes, as in a mesh whose faces are there twice, count
    /// as two.
    NonManifold,
    /// Where two faces meet at an angle.
    Crease,
    /// Where faces pass through each other.
    Intersection,
    /// Marked by the caller.
    Marked,
}

impl LineClass {
    /// All classes, the highest first.
    pub const ALL: [Self; 6] =
        [Self::Silhouette, Self::Boundary, Self::NonManifold, Self::Crease, Self::Intersection, Self::Marked];

    /// A word for it, for layers and identifiers.
    pub fn name(self) -> &'static str {
        match self {
            Self::Silhouette => "silhouette",
            Self::Boundary => "boundary",
            Self::NonManifold => "non-manifold",
            Self::Crease => "crease",
            Self::Intersection => "intersection",
            Self::Marked => "marked",
        }
    }
}

/// A set of classes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Classes(u8);

impl Classes {
    /// All classes.
    pub const ALL: Self = Self((1 << LineClass::ALL.len()) - 1);
    /// No class.
    pub const NONE: Self = Self(0);

    /// These and one more.
    #[must_use]
    pub const fn with(self, class: LineClass) -> Self {
        Self(self.0 | 1 << class as u8)
    }

    /// These without one.
    #[must_use]
    pub const fn without(self, class: LineClass) -> Self {
        Self(self.0 & !(1 << class as u8))
    }

    /// Whether a class is among them.
    pub const fn contains(self, class: LineClass) -> bool {
        self.0 >> class as u8 & 1 != 0
    }
}

impl FromIterator<LineClass> for Classes {
    fn from_iter<I: IntoIterator<Item = LineClass>>(classes: I) -> Self {
        classes.into_iter().fold(Self::NONE, Self::with)
    }
}

/// A rectangle of the page, in its unit ([`View`](crate::View)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PageBox {
    /// The lower left corner.
    pub low: [f64; 2],
    /// The upper right corner.
    pub high: [f64; 2],
}

/// Options of a drawing, and limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineOptions {
    /// The classes that are drawn. Default: all.
    pub classes: Classes,
    /// The least angle between the normals of two faces that makes a crease, in degrees: 0 to 180. Default: 33. Its
    /// cosine is rounded up to `f64`, and angles are compared with this number exactly.
    pub crease_degrees: f64,
    /// Lines nearer to a perspective eye than this are left out, and cut there; faces there still hide what is behind
    /// them. Default: a thousandth of the greatest depth of a line. Depths are rounded, so no line is cut at less than 1e-13 of
    /// the largest coordinate of its ends and the eye. An eye at infinity has no use for it.
    pub near: Option<f64>,
    /// The part of the page that is drawn. Lines are cut at its border. Default: all. Set it where the eye is inside a
    /// model.
    pub window: Option<PageBox>,
    /// Threads that work. The result does not depend on them.
    pub threads: Threads,
    /// The most memory that the drawing may take, in bytes, by estimates made before lines are found and before they are cut.
    /// The search for intersections is in neither. Default: no limit.
    pub memory_limit: Option<u64>,
}

impl Default for LineOptions {
    fn default() -> Self {
        Self {
            classes: Classes::ALL,
            crease_degrees: 33.0,
            near: None,
            window: None,
            threads: Threads::all(),
            memory_limit: None,
        }
    }
}
