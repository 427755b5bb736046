//! STL files, which may hold anything: triangles that share no vertices, in binary or as text.

use std::io::{self, BufRead, Read, Seek, SeekFrom};

use rimline::Origin;
use rimline::mesh::MAX_FACES;

use crate::charge;
use crate::coordinates::number;
use crate::line::{self, Next, Statements, numbers, shown};
use crate::npz::Arrays;

/// Why a file is refused.
#[derive(Debug, thiserror::Error)]
pub enum StlError {
    #[error("cannot be read: {0}")]
    Read(#[from] io::Error),
    #[error("line {line}: {found:?} is no number; a corner is `vertex x y z`")]
    Number { line: usize, found: String },
    #[error("line {line}: the corner has {found} coordinates; it needs 3, as in `vertex x y z`")]
    Coordinates { line: usize, found: usize },
    #[error("line {line}: the facet has {found} corners so far; it needs 3, and `endloop` behind them")]
    Corners { line: usize, found: usize },
    #[error("it ends within a facet, so a part of it is missing; get the whole file")]
    Open,
    #[error(
        "it states {stated} triangles and holds {held}, so a part of it is missing; get the whole file, or export it again"
    )]
    Cut { stated: u32, held: u64 },
    #[error("it has {faces} triangles, more than the {MAX_FACES} that can be counted")]
    Faces { faces: u64 },
    #[error(
        "{faces} triangles take {needed} bytes of memory with what is made of them, more than the limit of {limit}; if it is \
         meant to be that large, give a larger --memory-limit"
    )]
    TooLarge { faces: u64, needed: u64, limit: u64 },
    #[error("it has no triangles")]
    NoFaces,
}

/// Bytes before the triangles of a binary file, the last four of which are their number, and bytes of a triangle.
const HEADER: u64 = 84;
const TRIANGLE: usize = 50;

/// Whether a file of this length is in binary. Some tools write a little behind the triangles.
pub(crate) fn is_binary(start: &[u8], length: u64) -> bool {
    let count = start.get(80..84).and_then(|count| count.try_into().ok()).map(u32::from_le_bytes);
    let fits = |count: u32| (0..=512).contains(&length.wrapping_sub(HEADER + TRIANGLE as u64 * u64::from(count)));
    count.is_some_and(|count| count > 0 && fits(count))
}

/// Whether a file begins like text. Some binary files begin with the same word.
pub(crate) fn is_text(start: &[u8]) -> bool {
    let text = line::text(start).to_ascii_lowercase();
    let contains = |word: &[u8]| text.windows(word.len()).any(|window| window == word);
    text.starts_with(b"solid") && (contains(b"facet") || contains(b"endsolid"))
}

/// Reads the triangles, each with three vertices of its own: those of text relative to an origin near them, those in
/// binary bit for bit. Refuses a model that takes more than `memory_limit` bytes with its mesh, before it is kept.
pub fn read(mut reader: impl BufRead + Seek, memory_limit: u64) -> Result<Arrays, StlError> {
    let length = reader.seek(SeekFrom::End(0))?;
    reader.rewind()?;
    let mut start = Vec::new();
    reader.by_ref().take(1 << 16).read_to_end(&mut start)?;
    reader.rewind()?;
    let mut model = Triangles::new(memory_limit, Origin::ZERO);
    if is_text(&start) && !is_binary(&start, length) {
        text(&mut reader, &mut model)?;
        let origin = model.needed_origin();
        if !origin.is_zero() {
            // The positions are in `f32` already.
            reader.rewind()?;
            model = Triangles::new(memory_limit, origin);
            text(&mut reader, &mut model)?;
        }
    } else {
        binary(reader, length, &mut model)?;
    }
    let Triangles { positions, origin, .. } = model;
    if positions.is_empty() {
        return Err(StlError::NoFaces);
    }
    let faces = (0..positions.len() as u32 / 3).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
    Ok(Arrays { positions, faces, origin, ..Arrays::default() })
}

/// The triangles so far, three positions each.
struct Triangles {
    positions: Vec<[f32; 3]>,
    limit: u64,
    /// Positions of text are relative to it.
    origin: Origin,
    /// Bounds and smallest edge of the triangles of text, in `f64`.
    bounds: Option<[[f64; 3]; 2]>,
    smallest_edge: f64,
}

impl Triangles {
    fn new(limit: u64, origin: Origin) -> Self {
        Self { positions: Vec::new(), limit, origin, bounds: None, smallest_edge: f64::INFINITY }
    }

    /// The origin that triangles of text need.
    fn needed_origin(&self) -> Origin {
        self.bounds.map_or(Origin::ZERO, |bounds| Origin::near(bounds, || self.smallest_edge))
    }

    /// Takes a triangle of text into account.
    fn extend(&mut self, corners: &[[f64; 3]]) {
        let edges = corners.iter().zip(corners.iter().cycle().skip(1)).map(|(&from, &to)| [from, to]);
        self.smallest_edge = self.smallest_edge.min(Origin::smallest_edge(edges));
        self.bounds = Origin::bounds(self.bounds.into_iter().flatten().chain(corners.iter().copied()));
    }

    /// Refuses so many triangles if there is no room for them with their mesh.
    fn check(&self, faces: u64) -> Result<(), StlError> {
        if faces > MAX_FACES as u64 {
            return Err(StlError::Faces { faces });
        }
        let (needed, limit) = (charge::model(3 * faces, faces), self.limit);
        if needed > limit { Err(StlError::TooLarge { faces, needed, limit }) } else { Ok(()) }
    }
}

fn binary(mut reader: impl BufRead, length: u64, model: &mut Triangles) -> Result<(), StlError> {
    let mut header = [0; HEADER as usize];
    let held = length.saturating_sub(HEADER) / TRIANGLE as u64;
    reader.read_exact(&mut header).map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => StlError::NoFaces,
        _ => error.into(),
    })?;
    let [.., a, b, c, d] = header;
    let stated = u32::from_le_bytes([a, b, c, d]);
    if u64::from(stated) > held {
        return Err(StlError::Cut { stated, held });
    }
    model.check(stated.into())?;
    model.positions.reserve_exact(3 * stated as usize);
    let mut triangle = [0; TRIANGLE];
    for _ in 0..stated {
        reader.read_exact(&mut triangle)?;
        // A normal, three corners, and two bytes that mean something to some programs.
        let (coordinates, _) = triangle[12..48].as_chunks::<4>();
        let (corners, _) = coordinates.as_chunks::<3>();
        model.positions.extend(corners.iter().map(|corner| corner.map(f32::from_le_bytes)));
    }
    Ok(())
}

/// Reads the corners of all solids. Normals are made anew of them, and names mean nothing.
fn text(reader: impl BufRead, model: &mut Triangles) -> Result<(), StlError> {
    let (mut lines, mut corners) = (Statements::new(reader), Vec::new());
    loop {
        // A line and its copy while it grows, and positions, which double.
        let listed = 2 * 12 * model.positions.len() as u64;
        let statement = match lines.next(model.limit.saturating_sub(listed) / 3)? {
            Next::Statement(statement) => statement,
            Next::End if !corners.is_empty() => return Err(StlError::Open),
            Next::End => return Ok(()),
            Next::TooLong { .. } => {
                let (faces, limit) = (model.positions.len() as u64 / 3, model.limit);
                return Err(StlError::TooLarge { faces, needed: limit.saturating_add(1), limit });
            }
        };
        let line = statement.line;
        let mut words = statement.words();
        let Some(word) = words.next() else { continue };
        if word.eq_ignore_ascii_case(b"vertex") {
            let found = numbers(words, number).map_err(|word| StlError::Number { line, found: shown(word) })?;
            let (corner, found): ([f64; 3], usize) = found;
            if found != 3 {
                return Err(StlError::Coordinates { line, found });
            }
            corners.push(corner);
            if corners.len() > 3 {
                return Err(StlError::Corners { line, found: corners.len() });
            }
            model.positions.push(model.origin.position(corner));
        } else if word.eq_ignore_ascii_case(b"endloop") {
            if corners.len() != 3 {
                return Err(StlError::Corners { line, found: corners.len() });
            }
            model.extend(&corners);
            corners.clear();
            model.check(model.positions.len() as u64 / 3)?;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::error::Error;

    use crate::{ReadOptions, read_bytes};

    #[test]
    fn text_far_away_is_read_like_an_obj() -> Result<(), Box<dyn Error>> {
        let corners = ["392143.517 34 -5820467.702", "392143.717 34 -5820467.702", "392143.517 34.3 -5820467.702"];
        let vertices = corners.map(|corner| format!("vertex {corner}\n")).concat();
        let stl = format!("solid a\nfacet normal 0 0 1\nouter loop\n{vertices}endloop\nendfacet\nendsolid a\n");
        let obj = corners.map(|corner| format!("v {corner}\n")).concat() + "f 1 2 3\n";
        let options = ReadOptions::default();
        let [stl, obj] = [read_bytes(stl.as_bytes(), None, &options)?, read_bytes(obj.as_bytes(), None, &options)?];
        assert!(!stl.origin().is_zero());
        assert_eq!((stl.origin(), stl.world_positions()), (obj.origin(), obj.world_positions()));
        Ok(())
    }
}
