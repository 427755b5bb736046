//! Warnings about a file that was loaded.

use std::cell::RefCell;
use std::collections::HashSet;

use super::budget::Budget;
use super::document::Part;
use super::error::GltfError;
use super::info::SkippedPrimitives;

/// A part of a file that was left out, or read in another way than it is written. The file was loaded:
/// see [`Asset::warnings`](super::Asset::warnings).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what fields are")]
pub enum GltfWarning {
    /// A part of the file is damaged. The scene can be shown without it, so it was left out. A caller that requests an
    /// animation or a light gets an error with its fault: [`GltfError::DamagedAnimation`], [`GltfError::DamagedLight`].
    #[error("{fault}; the scene can be shown without it, so it is left out")]
    Damaged { fault: Box<GltfError> },
    /// The file uses an extension that is not read, and that may transform, shape or move what is drawn.
    #[error("the extension {name} is not read; where it places, shapes or moves something, the result is another")]
    Extension { name: String },
    /// Primitives were skipped, also those of meshes that the scene does not show.
    #[error(
        "skipped {} point primitives, {} line primitives and {} primitives without positions", .0.points, .0.lines,
        .0.without_position
    )]
    Skipped(SkippedPrimitives),
    /// Positions, or offsets of a morph target, are infinite or NaN. The faces of these vertices face no light, cast no
    /// shadow and are not drawn. Offsets have this effect while the weight of their target is not 0.
    #[error(
        "{json_path}: {vertices} {} are infinite or NaN, first that of vertex {first}{}",
        if *.is_target { "offsets" } else { "positions" },
        if *.is_target { "; while the target's weight is not 0, the faces of these vertices are not drawn" } else { "" }
    )]
    NonFinite { json_path: String, vertices: usize, first: usize, is_target: bool },
    /// A part was read in another way than it is written, or ignored. It breaks the specification: left-over corners,
    /// indices that restart, children of two nodes, rotations of length 0, weights without morph targets, zero bytes after
    /// the JSON. Or it may be legal, but is not supported: other colours for the same vertices, channels that move nothing.
    #[error("{json_path}{problem}")]
    Changed { json_path: String, problem: String },
}

impl GltfWarning {
    /// A rotation has length 0.
    pub(super) fn no_rotation(json_path: String) -> Self {
        let problem = " is a quaternion without a direction; it is read as no rotation, (0, 0, 0, 1)".to_owned();
        Self::Changed { json_path, problem }
    }

    /// A channel of an animation moves nothing.
    pub(super) fn channel(json_path: &str, problem: &str) -> Self {
        Self::Changed { json_path: json_path.to_owned(), problem: format!(": {problem}, so the channel moves nothing") }
    }
}

/// Warnings while a file is loaded. Their memory is charged.
pub(super) struct Warnings<'a> {
    budget: &'a Budget,
    list: RefCell<Vec<GltfWarning>>,
    /// The texts of warnings so far. They keep a warning from being repeated: a damaged accessor spoils all that use it.
    said: RefCell<HashSet<String>>,
}

/// Bytes of a warning in a list that doubles, and of an error that is stored until its part is used.
const WARNING: u64 = 3 * size_of::<GltfWarning>() as u64 + 4 * size_of::<GltfError>() as u64 + 512;
/// Bytes for each byte of its text: in the warning, in the stored error and its copies, and in the list of messages.
const TEXT: u64 = 8;

impl<'a> Warnings<'a> {
    pub(super) fn new(budget: &'a Budget) -> Self {
        Self { budget, list: RefCell::default(), said: RefCell::default() }
    }

    /// Adds a warning, unless it was added before. A repeated one is charged, too.
    pub(super) fn push(&self, warning: GltfWarning) -> Result<(), GltfError> {
        let text = warning.to_string();
        self.charge(&text)?;
        if self.said.borrow_mut().insert(text) {
            self.list.borrow_mut().push(warning);
        }
        Ok(())
    }

    /// The part, or its fault, which is charged, and which the caller stores until the part is used. Memory is about the
    /// whole file, so [`GltfError::TooLarge`] and [`GltfError::Memory`] are no part's fault.
    pub(super) fn keep<T>(&self, result: Result<T, GltfError>) -> Result<Part<T>, GltfError> {
        match result {
            Err(error @ (GltfError::TooLarge { .. } | GltfError::Memory { .. })) => Err(error),
            Err(error) => self.charge(&error.to_string()).map(|()| Err(Box::new(error))),
            Ok(value) => Ok(Ok(value)),
        }
    }

    /// The value, or a warning that a part is damaged.
    pub(super) fn leave_out<T>(&self, result: Result<T, GltfError>) -> Result<Option<T>, GltfError> {
        match self.keep(result)? {
            Ok(value) => Ok(Some(value)),
            Err(fault) => self.push(GltfWarning::Damaged { fault }).map(|()| None),
        }
    }

    /// Warns of the stored faults of parts. The scene needs none of these: one that it needs has refused the file.
    pub(super) fn damaged<'p, T: 'p>(&self, parts: impl IntoIterator<Item = &'p Part<T>>) -> Result<(), GltfError> {
        let mut faults = parts.into_iter().filter_map(|part| part.as_ref().err());
        faults.try_for_each(|fault| self.push(GltfWarning::Damaged { fault: fault.clone() }))
    }

    pub(super) fn finish(self) -> Vec<GltfWarning> {
        self.list.into_inner()
    }

    fn charge(&self, text: &str) -> Result<(), GltfError> {
        self.budget.charge_lasting(WARNING + TEXT * text.len() as u64, &|| "the file's warnings".to_owned())
    }
}
