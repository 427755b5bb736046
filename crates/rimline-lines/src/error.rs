//! Why nothing is drawn, and which objects are left out.

use rimline::{ModelError, cpu::CpuError};

/// Why there is no drawing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LinesError {
    /// The eye or its axes are no view.
    #[error(
        "the eye sees no page: eye, target and up must be finite, the target apart from the eye, and up not along the line of sight"
    )]
    View,
    /// The crease angle is no angle.
    #[error("the crease angle is {degrees}; give 0 to 180 degrees")]
    Crease {
        /// The angle given.
        degrees: f64,
    },
    /// The nearest depth is no depth.
    #[error("lines are to begin at a depth of {near}; give a finite depth above 0")]
    Near {
        /// The depth given.
        near: f64,
    },
    /// The window has no area.
    #[error("the window from {low:?} to {high:?} has no area; give finite corners, the lower one first")]
    Window {
        /// Its lower left corner.
        low: [f64; 2],
        /// Its upper right corner.
        high: [f64; 2],
    },
    /// The drawing needs more memory than the limit allows.
    #[error(
        "the drawing needs about {needed} bytes, and the limit is {limit}; raise it, or draw fewer objects or classes"
    )]
    Memory {
        /// Bytes needed.
        needed: u64,
        /// The limit.
        limit: u64,
    },
    /// There are more vertices, faces, points where faces meet or pieces of lines than can be numbered.
    #[error("there are {count} {what}, and at most {most} can be drawn; draw fewer objects or classes at a time")]
    TooMany {
        /// The kind of elements.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many there may be.
        most: usize,
    },
    /// A model and its pose do not fit.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Facing was refused.
    #[error(transparent)]
    Facing(#[from] CpuError),
    /// The caller ended it.
    #[error("the drawing was cancelled")]
    Cancelled,
}

/// Refuses more than can be numbered.
pub(crate) fn check_count(what: &'static str, count: usize, most: usize) -> Result<(), LinesError> {
    if count > most { Err(LinesError::TooMany { what, count, most }) } else { Ok(()) }
}

/// An object that is not drawn, or not as asked.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// Its number among the objects.
    pub object: usize,
    /// Its name.
    pub name: String,
    /// Its fault.
    pub fault: Fault,
}

/// A fault of an object.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// It is left out: a vertex of a face is infinite or NaN.
    #[error("vertex {vertex} is infinite or NaN; the object is left out")]
    NotFinite {
        /// The vertex.
        vertex: u32,
    },
    /// It is left out: positions are missing.
    #[error("{given} positions given, and the mesh has {needed} vertices; the object is left out")]
    TooFewPositions {
        /// Positions given.
        given: usize,
        /// Vertices of the mesh.
        needed: u32,
    },
    /// It is left out: it has no faces, or each of them names a vertex twice.
    #[error("there is no face of three different vertices; the object is left out")]
    NoFaces,
    /// It has no outline: it reaches behind the eye, or nearer than lines are drawn.
    #[error("the object reaches behind the eye or too near to it; it has no outline")]
    TooNear,
    /// It is drawn, but an edge that the caller marks is not there.
    #[error("the marked edge from vertex {} to {} is no edge of the mesh; the rest is drawn", vertices[0], vertices[1])]
    NoSuchEdge {
        /// The vertices given.
        vertices: [u32; 2],
    },
}
