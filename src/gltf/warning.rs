//! Warnings about a file that was loaded.

use std::cell::RefCell;
use std::collections::HashSet;

use super::budget::Budget;
use super::error::GltfError;
use super::info::SkippedPrimitives;

/// Something in a file that was left out, or read in another way than it is written. The file was loaded all the same:
/// see [`Asset::warnings`](super::Asset::warnings).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GltfWarning {
    /// A part of the file is damaged. The scene can be shown without it, so it was left out. Whoever asks for the part
    /// gets this fault as an error.
    #[error("{fault}; the scene can be shown without it, so it is left out")]
    Damaged {
        /// The fault, and where it is.
        fault: Box<GltfError>,
    },
    /// The file uses an extension that is not read, and that may place, shape or move what is drawn.
    #[error("the extension {name} is not read; where it places, shapes or moves something, the result is another")]
    Extension {
        /// The extension.
        name: String,
    },
    /// Primitives were skipped.
    #[error(
        "skipped {} point primitives, {} line primitives and {} primitives without positions", .0.points, .0.lines,
        .0.without_position
    )]
    Skipped(SkippedPrimitives),
    /// Positions are infinite or NaN. Their faces face no light, cast no shadow and are not drawn.
    #[error("{place}: {vertices} positions are infinite or NaN, first that of vertex {first}")]
    NonFinitePositions {
        /// JSON path of the attribute.
        place: String,
        /// The number of such positions.
        vertices: usize,
        /// The first vertex.
        first: usize,
    },
    /// Offsets of a morph target are infinite or NaN. The faces of these vertices face no light, cast no shadow and are
    /// not drawn, whatever the weights.
    #[error(
        "{place}: {vertices} offsets are infinite or NaN, first that of vertex {first}; the faces of these vertices are \
         not drawn"
    )]
    NonFiniteOffsets {
        /// JSON path of the morph target's attribute.
        place: String,
        /// The number of such offsets.
        vertices: usize,
        /// The first vertex.
        first: usize,
    },
    /// The number of corners of a list of triangles is not a multiple of three. The last one or two were left out.
    #[error(
        "meshes[{mesh}].primitives[{primitive}]: {corners} corners are no whole number of triangles; the last {} are left \
         out", .corners % 3
    )]
    CornerCount {
        /// Index of the mesh.
        mesh: usize,
        /// Index of the primitive in it.
        primitive: usize,
        /// Indices, or vertices if there are no indices.
        corners: usize,
    },
    /// An index has the value that restarts a strip, which glTF forbids. In a list of triangles it names a vertex if there
    /// are so many. Otherwise it begins a new triangle, strip or fan.
    #[error(
        "meshes[{mesh}].primitives[{primitive}]: index {position} is the primitive restart value {index}, which glTF \
         forbids; it is read as {}", if *.is_vertex { "a vertex" } else { "a restart" }
    )]
    PrimitiveRestart {
        /// Index of the mesh.
        mesh: usize,
        /// Index of the primitive in it.
        primitive: usize,
        /// The first such position in the index accessor.
        position: usize,
        /// The index: the largest value of its type.
        index: u32,
        /// Whether it names a vertex.
        is_vertex: bool,
    },
    /// Two nodes list the same child, or one node lists it twice. It is placed once. The parent that comes first in the
    /// chosen scene has it.
    #[error(
        "nodes[{node}] is a child of nodes[{parent}] and again of nodes[{other}]; nodes must form trees, so it is placed \
         below nodes[{parent}] only"
    )]
    SharedChild {
        /// Index of the child.
        node: usize,
        /// Index of the parent that has it.
        parent: usize,
        /// Index of the other parent, or of the same one again.
        other: usize,
    },
    /// Bytes of value 0 follow the JSON. They were ignored.
    #[error("{bytes} zero bytes follow the JSON, where only spaces may; they are ignored")]
    Padding {
        /// Their number.
        bytes: usize,
    },
    /// A rotation has length 0. It was read as no rotation.
    #[error("{place} is a quaternion without a direction; it is read as no rotation, (0, 0, 0, 1)")]
    Rotation {
        /// JSON path of the rotation.
        place: String,
    },
    /// There are morph weights, but no morph targets. The weights were ignored.
    #[error("{place} has {weights} morph weights, but there are no morph targets; they are ignored")]
    MorphWeights {
        /// JSON path of the weights.
        place: String,
        /// Their number.
        weights: usize,
    },
    /// A channel of an animation moves nothing.
    #[error("{place}: {problem}, so the channel moves nothing")]
    Channel {
        /// JSON path of the channel.
        place: String,
        /// Why it moves nothing.
        problem: String,
    },
}

/// Warnings while a file is loaded. Their memory is charged.
pub(super) struct Warnings<'a> {
    budget: &'a Budget,
    list: RefCell<Vec<GltfWarning>>,
    /// The texts of warnings so far. They keep a warning from being repeated: a damaged accessor spoils all that use it.
    said: RefCell<HashSet<String>>,
}

/// Bytes of a warning in a list that doubles, and of an error that is kept for whoever asks for its part.
const WARNING: u64 = 3 * size_of::<GltfWarning>() as u64 + 4 * size_of::<GltfError>() as u64 + 512;
/// Bytes for each byte of its text: in the warning, in the kept error and its copies, and as what was said.
const TEXT: u64 = 8;

impl<'a> Warnings<'a> {
    pub(super) fn new(budget: &'a Budget) -> Self {
        Self { budget, list: RefCell::default(), said: RefCell::default() }
    }

    /// Adds a warning, unless it was added before.
    pub(super) fn push(&self, warning: GltfWarning) -> Result<(), GltfError> {
        let text = warning.to_string();
        self.charge(&text)?;
        if self.said.borrow_mut().insert(text) {
            self.list.borrow_mut().push(warning);
        }
        Ok(())
    }

    /// Makes a fault of what a part is refused for, to be kept until somebody asks for the part. The memory limit is the
    /// whole file's matter, so [`GltfError::TooLarge`] is no part's fault.
    pub(super) fn fault(&self, error: GltfError) -> Result<Box<GltfError>, GltfError> {
        if let GltfError::TooLarge { .. } = error {
            return Err(error);
        }
        self.charge(&error.to_string())?;
        Ok(Box::new(error))
    }

    /// The value, or a fault that is kept.
    pub(super) fn keep<T>(&self, result: Result<T, GltfError>) -> Result<Result<T, Box<GltfError>>, GltfError> {
        Ok(match result {
            Ok(value) => Ok(value),
            Err(error) => Err(self.fault(error)?),
        })
    }

    /// The value, or a warning that a part is damaged.
    pub(super) fn leave_out<T>(&self, result: Result<T, GltfError>) -> Result<Option<T>, GltfError> {
        match result {
            Ok(value) => Ok(Some(value)),
            Err(error) => {
                let fault = self.fault(error)?;
                self.push(GltfWarning::Damaged { fault })?;
                Ok(None)
            }
        }
    }

    /// Warns of faults that were kept and that nobody asked for.
    pub(super) fn damaged<'f>(&self, faults: impl Iterator<Item = &'f Box<GltfError>>) -> Result<(), GltfError> {
        for fault in faults {
            self.push(GltfWarning::Damaged { fault: fault.clone() })?;
        }
        Ok(())
    }

    pub(super) fn finish(self) -> Vec<GltfWarning> {
        self.list.into_inner()
    }

    fn charge(&self, text: &str) -> Result<(), GltfError> {
        self.budget.charge_lasting(WARNING + TEXT * text.len() as u64, &|| "the file's warnings".to_owned())
    }
}
