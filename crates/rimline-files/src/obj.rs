//! Wavefront OBJ files, which may hold anything: positions, and faces of any number of corners.

use std::io::{self, BufRead};

use rimline::mesh::MAX_POLYGON_CORNERS;

use crate::collected::{Collected, Refused, WHITE};
use crate::coordinates::number;
use crate::line::{Next, Statement, Statements, numbers, shown};
use crate::mtl::{self, Materials, joined, linear};
use crate::npz::Arrays;

/// Why a file is refused.
#[derive(Debug, thiserror::Error)]
pub enum ObjError {
    #[error("cannot be read: {0}")]
    Read(#[from] io::Error),
    #[error("line {line}: {fault}")]
    Line { line: usize, fault: LineFault },
    #[error("it has no faces, which are lines `f v v v …`; export the model as polygons")]
    NoFaces,
    #[error("{source}; the last line has no end, so the file may be cut off")]
    CutOff { source: Box<ObjError> },
}

/// The fault of a line.
#[derive(Debug, thiserror::Error)]
pub enum LineFault {
    #[error("{found:?} is no number; a vertex is `v x y z`")]
    Number { found: String },
    #[error("the vertex has {found} coordinate{}; it needs 3, as in `v x y z`", if *.found == 1 { "" } else { "s" })]
    Coordinates { found: usize },
    #[error("{found:?} is no corner; write it as `v`, `v/vt`, `v//vn` or `v/vt/vn`, all of them whole numbers")]
    Corner { found: String },
    #[error("the face has {found} corner{}; it needs at least 3, and a line is an `l`", if *.found == 1 { "" } else { "s" })]
    Corners { found: usize },
    #[error("the face has more than {MAX_POLYGON_CORNERS} corners; cut it into several")]
    FaceTooLarge,
    #[error(
        "a face names vertex {index}, but there are {vertices} vertices; they are counted from 1, and from −1 backwards"
    )]
    OutOfRange { index: i64, vertices: usize },
    #[error("`{statement}` is part of a curved surface, which is not read; export the model as polygons")]
    Curved { statement: String },
    #[error(
        "`call` stands for the lines of another file, which is not read; put them here, or export the model as one file"
    )]
    Call,
    #[error(
        "`csh` asks to run a program, which is never done; leave the line out if the model has all its faces without"
    )]
    Program,
    #[error(
        "what is read so far takes {needed} bytes of memory with what is made of it, more than the limit of {limit}; if it is \
         meant to be that large, give a larger --memory-limit"
    )]
    TooLarge { needed: u64, limit: u64 },
}

impl From<Refused> for LineFault {
    fn from(refused: Refused) -> Self {
        match refused {
            Refused::Corners(found) => Self::Corners { found },
            Refused::FaceTooLarge => Self::FaceTooLarge,
            Refused::TooLarge { needed, limit } => Self::TooLarge { needed, limit },
        }
    }
}

impl LineFault {
    /// The error. `is_cut`: the last line of the file was read, and has no end.
    fn at(self, line: usize, is_cut: bool) -> ObjError {
        let may_be_cut = matches!(
            self,
            Self::Number { .. }
                | Self::Coordinates { .. }
                | Self::Corner { .. }
                | Self::Corners { .. }
                | Self::OutOfRange { .. }
        );
        let error = ObjError::Line { line, fault: self };
        if is_cut && may_be_cut { ObjError::CutOff { source: Box::new(error) } } else { error }
    }
}

/// Words that an OBJ file may begin with.
const FIRST_WORDS: [&[u8]; 10] = [b"v", b"vt", b"vn", b"f", b"o", b"g", b"s", b"mtllib", b"usemtl", b"l"];

/// Whether text begins like an OBJ file.
pub fn begins_like(bytes: &[u8]) -> bool {
    const FAR: usize = 1 << 16;
    let mut lines = Statements::new(&bytes[..bytes.len().min(FAR)]);
    while let Ok(Next::Statement(statement)) = lines.next(FAR as u64) {
        if let Some(word) = statement.words().next() {
            return FIRST_WORDS.contains(&word);
        }
    }
    false
}

/// Reads positions, faces and colours, relative to an origin near them, and skips everything else. Faces come as
/// triangles if all of them are triangles, else as polygons.
///
/// Refuses a model that takes more than `memory_limit` bytes with its mesh, before it is kept. The mesh is one of
/// polygons where these `are_whole`, else one of their triangles.
pub fn read(
    reader: impl BufRead,
    materials: &mut Materials<'_>,
    memory_limit: u64,
    are_whole: bool,
) -> Result<Arrays, ObjError> {
    let mut lines = Statements::new(reader);
    let model = Collected::new(memory_limit, are_whole);
    let mut obj = Obj { model, materials, color: None, highest: (0, 0) };
    loop {
        // The line and its copy while it grows.
        let room = obj.model.room() / 3;
        let (line, taken) = match lines.next(room)? {
            Next::Statement(statement) => (statement.line, obj.take(&statement)),
            Next::TooLong { line } => {
                let needed = memory_limit.saturating_add(1);
                (line, Err(LineFault::TooLarge { needed, limit: memory_limit }))
            }
            Next::End => {
                let line = obj.highest.1;
                let model = obj.finish().map_err(|fault| fault.at(line, lines.is_cut))?;
                return model.ok_or(ObjError::NoFaces);
            }
        };
        taken.map_err(|fault| fault.at(line, lines.is_cut))?;
    }
}

/// The model as far as it was read.
struct Obj<'m, 'f> {
    model: Collected,
    materials: &'m mut Materials<'f>,
    /// The colour of the material in use.
    color: Option<[f32; 3]>,
    /// The largest vertex that a face names, from 1, and its line. Faces may stand before their vertices.
    highest: (i64, usize),
}

impl Obj<'_, '_> {
    fn take(&mut self, statement: &Statement<'_>) -> Result<(), LineFault> {
        let line = statement.line;
        let mut words = statement.words();
        match words.next() {
            Some(b"v") => self.vertex(words),
            Some(b"f" | b"fo") => self.face(line, words),
            Some(b"usemtl") => {
                let before = self.color.replace(self.materials.color(line, &joined(statement.name())));
                Ok(self.model.color_faces(before.unwrap_or(WHITE))?)
            }
            Some(b"mtllib") => self.library(line, statement.name()),
            Some(b"call") => Err(LineFault::Call),
            Some(b"csh") => Err(LineFault::Program),
            // Faces say the same as all other statements of curved surfaces.
            Some(word @ (b"surf" | b"bzp" | b"bsp")) => Err(LineFault::Curved { statement: shown(word) }),
            _ => Ok(()),
        }
    }

    /// Names of files, or one name that has blanks.
    fn library<'a>(&mut self, line: usize, words: impl Iterator<Item = &'a [u8]>) -> Result<(), LineFault> {
        let name = joined(words);
        let are_many = name.to_ascii_lowercase().windows(5).any(|part| part == b".mtl ");
        let names = if are_many { name.split(|&byte| byte == b' ').collect() } else { vec![&name[..]] };
        for name in names {
            let bytes = self.materials.read(line, &String::from_utf8_lossy(name), self.model.room() / mtl::BYTES);
            self.model.charge(bytes * mtl::BYTES)?;
        }
        Ok(())
    }

    /// Coordinates. A weight or a colour may follow; weights are for curves alone.
    fn vertex<'a>(&mut self, words: impl Iterator<Item = &'a [u8]>) -> Result<(), LineFault> {
        let found = numbers(words, number).map_err(|word| LineFault::Number { found: shown(word) })?;
        let ([x, y, z, red, green, blue], found) = found;
        if found < 3 {
            return Err(LineFault::Coordinates { found });
        }
        self.model.vertex([x, y, z])?;
        if found == 6 {
            self.model.color_vertex([red, green, blue].map(linear))?;
        }
        Ok(())
    }

    fn face<'a>(&mut self, line: usize, words: impl Iterator<Item = &'a [u8]>) -> Result<(), LineFault> {
        self.model.begin_face()?;
        for word in words {
            let index = corner(word).ok_or_else(|| LineFault::Corner { found: shown(word) })?;
            let vertices = self.model.vertices();
            // Below 0 they count backwards from the last vertex so far.
            let one_based = if index < 0 { index.saturating_add(vertices as i64).saturating_add(1) } else { index };
            let vertex = u32::try_from(one_based).ok().and_then(|one_based| one_based.checked_sub(1));
            let vertex = vertex.ok_or(LineFault::OutOfRange { index, vertices })?;
            self.highest = self.highest.max((one_based, line));
            self.model.corner(vertex)?;
        }
        Ok(self.model.end_face()?)
    }

    /// The model, or none if it has no faces.
    fn finish(self) -> Result<Option<Arrays>, LineFault> {
        let Self { mut model, color, highest: (index, _), .. } = self;
        color.map_or(Ok(()), |color| model.color_faces(color))?;
        let vertices = model.vertices();
        if index > vertices as i64 {
            return Err(LineFault::OutOfRange { index, vertices });
        }
        Ok(model.finish()?)
    }
}

/// The vertex of a corner, of which texture coordinate and normal are whole numbers or left out.
fn corner(word: &[u8]) -> Option<i64> {
    let number = |part: &[u8]| std::str::from_utf8(part).ok()?.parse::<i64>().ok();
    let mut parts = word.split(|&byte| byte == b'/');
    let vertex = number(parts.next()?)?;
    let others: [Option<&[u8]>; 3] = [parts.next(), parts.next(), parts.next()];
    let are_right = others[..2].iter().flatten().all(|part| part.is_empty() || number(part).is_some());
    (are_right && others[2].is_none()).then_some(vertex)
}
