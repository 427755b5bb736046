//! PLY files, which may hold anything: vertices, and faces of any number of corners, as text or in binary.

use std::io::{self, BufRead, Read, Seek, SeekFrom};

use rimline::mesh::MAX_POLYGON_CORNERS;

use crate::collected::{Collected, Refused};
use crate::coordinates::number;
use crate::mtl::linear;
use crate::npz::Arrays;

/// Why a file is refused.
#[derive(Debug, thiserror::Error)]
pub enum PlyError {
    #[error("cannot be read: {0}")]
    Read(#[from] io::Error),
    #[error("its header has no end: there is no line `end_header` in the first {MAX_HEADER} bytes")]
    Endless,
    #[error("line {line} of its header: {found:?} is not understood; {wanted}")]
    Header { line: usize, found: String, wanted: &'static str },
    #[error("line {line} of its header: {name:?} stands there twice, so what belongs to it is not clear")]
    Twice { line: usize, name: String },
    #[error("its vertices have no {property:?}; positions are the properties x, y and z of the element `vertex`")]
    NoPosition { property: &'static str },
    #[error(
        "it has no faces, which are a list `vertex_indices` in the element `face`; clouds of points and strips of triangles are \
         not read, so export the model as polygons"
    )]
    NoFaces,
    #[error("it states {stated} of `{element}`, and the rest of the file has room for {most}; get the whole file")]
    Cut { element: String, stated: u64, most: u64 },
    #[error("`{element}` {index}: the file ends within it; get the whole file")]
    Ended { element: String, index: u64 },
    #[error("`{element}` {index}: {found:?} is no number")]
    Number { element: String, index: u64, found: String },
    #[error("`{element}` {index}: a list cannot have {found} elements")]
    List { element: String, index: u64, found: f64 },
    #[error("`{element}` {index} names vertex {found}, but there are {vertices}; they are counted from 0")]
    OutOfRange { element: String, index: u64, found: f64, vertices: u64 },
    #[error("`{element}` {index} has {found} corner{}; a face needs at least 3", if *.found == 1 { "" } else { "s" })]
    Corners { element: String, index: u64, found: usize },
    #[error("`{element}` {index} has more than {MAX_POLYGON_CORNERS} corners; cut it into several")]
    FaceTooLarge { element: String, index: u64 },
    #[error(
        "`{element}` {index}: what is read so far takes {needed} bytes of memory with what is made of it, more than the limit of \
         {limit}; if it is meant to be that large, give a larger --memory-limit"
    )]
    TooLarge { element: String, index: u64, needed: u64, limit: u64 },
}

const MAX_HEADER: u64 = 1 << 17;
/// Bytes of a number in text.
const MAX_WORD: usize = 400;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// The type of a number: its kind, as in `float`, and its bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Scalar {
    kind: char,
    bytes: usize,
}

impl Scalar {
    fn named(name: &str) -> Option<Self> {
        let (kind, bytes) = match name {
            "char" | "int8" => ('i', 1),
            "uchar" | "uint8" => ('u', 1),
            "short" | "int16" => ('i', 2),
            "ushort" | "uint16" => ('u', 2),
            "int" | "int32" => ('i', 4),
            "uint" | "uint32" => ('u', 4),
            "float" | "float32" => ('f', 4),
            "double" | "float64" => ('f', 8),
            _ => return None,
        };
        Some(Self { kind, bytes })
    }

    /// The number of bytes with the least significant first. All types fit.
    fn value(self, bytes: [u8; 8]) -> f64 {
        let raw = u64::from_le_bytes(bytes);
        match (self.kind, self.bytes) {
            ('f', 4) => f32::from_bits(raw as u32).into(),
            ('f', _) => f64::from_bits(raw),
            ('i', 1) => (raw as i8).into(),
            ('i', 2) => (raw as i16).into(),
            ('i', _) => (raw as i32).into(),
            _ => raw as f64,
        }
    }
}

struct Property {
    name: String,
    /// The type of a list's length, if it is one.
    length: Option<Scalar>,
    scalar: Scalar,
}

struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

struct Header {
    encoding: Encoding,
    elements: Vec<Element>,
}

/// Reads positions, faces and colours, relative to an origin near them, and skips everything else. Faces come as
/// triangles if all of them are triangles, else as polygons.
///
/// Refuses a model that takes more than `memory_limit` bytes with its mesh, before it is kept. The mesh is one of polygons
/// where these `are_whole`, else one of their triangles.
pub fn read(mut reader: impl BufRead + Seek, memory_limit: u64, are_whole: bool) -> Result<Arrays, PlyError> {
    let header = Header::read(&mut reader)?;
    let at = reader.stream_position()?;
    let mut left = reader.seek(SeekFrom::End(0))?.saturating_sub(at);
    reader.seek(SeekFrom::Start(at))?;
    let vertices = header.elements.iter().find(|element| element.name == "vertex").map_or(0, |element| element.count);
    let mut body = Body { reader, encoding: header.encoding, word: Vec::new() };
    let mut model = Collected::new(memory_limit, are_whole);
    for element in &header.elements {
        element.check(header.encoding, left)?;
        element.read(&mut body, &mut model, vertices)?;
        left = left.saturating_sub(element.count.saturating_mul(element.least(header.encoding)));
    }
    let last = ElementIndex { element: "face", index: 0 };
    model.finish().map_err(|refused| last.refused(refused))?.ok_or(PlyError::NoFaces)
}

impl Header {
    fn read(reader: &mut impl BufRead) -> Result<Self, PlyError> {
        let mut text = reader.by_ref().take(MAX_HEADER);
        let (mut encoding, mut elements) = (None, Vec::<Element>::new());
        let mut line = 0;
        loop {
            let Some(header) = header_line(&mut text)? else { return Err(PlyError::Endless) };
            line += 1;
            let header = String::from_utf8_lossy(&header);
            let words: Vec<&str> = header.split_ascii_whitespace().take(6).collect();
            let wrong = |wanted| PlyError::Header { line, found: header.chars().take(80).collect(), wanted };
            match words[..] {
                ["ply"] if line == 1 => {}
                _ if line == 1 => return Err(wrong("a PLY file begins with a line `ply`")),
                [] | ["comment" | "obj_info", ..] => {}
                ["format", "ascii", _] => encoding = Some(Encoding::Text),
                ["format", "binary_little_endian", _] => encoding = Some(Encoding::LittleEndian),
                ["format", "binary_big_endian", _] => encoding = Some(Encoding::BigEndian),
                ["element", name, count] => {
                    let count = count.parse().map_err(|_| wrong("an element is `element NAME COUNT`"))?;
                    if elements.iter().any(|element| element.name == name) {
                        return Err(PlyError::Twice { line, name: name.into() });
                    }
                    elements.push(Element { name: name.into(), count, properties: Vec::new() });
                }
                ["property", ref of @ ..] => {
                    let wanted =
                        "a property is `property TYPE NAME` or `property list TYPE TYPE NAME`, after an element";
                    let (length, scalar, name) = match *of {
                        ["list", length, scalar, name] => (Some(length), scalar, name),
                        [scalar, name] => (None, scalar, name),
                        _ => return Err(wrong(wanted)),
                    };
                    let scalar_of = |name| Scalar::named(name).ok_or_else(|| wrong("its type is not one of PLY's"));
                    let (length, scalar) = (length.map(scalar_of).transpose()?, scalar_of(scalar)?);
                    let Some(element) = elements.last_mut() else { return Err(wrong(wanted)) };
                    if element.properties.iter().any(|property| property.name == name) {
                        return Err(PlyError::Twice { line, name: name.into() });
                    }
                    element.properties.push(Property { name: name.into(), length, scalar });
                }
                ["end_header"] => {
                    let encoding = encoding.ok_or_else(|| wrong("a line `format` must come before"))?;
                    return Ok(Self { encoding, elements });
                }
                _ => {
                    return Err(wrong(
                        "a header has `format`, `comment`, `element` and `property`, and ends in `end_header`",
                    ));
                }
            }
        }
    }
}

/// The next line without its end, LF or CR LF.
fn header_line(text: &mut impl BufRead) -> io::Result<Option<Vec<u8>>> {
    let mut line = Vec::new();
    text.read_until(b'\n', &mut line)?;
    if line.pop() != Some(b'\n') {
        return Ok(None);
    }
    if line.last() == Some(&b'\r') {
        line.pop();
    }
    Ok(Some(line))
}

impl Element {
    /// The fewest bytes that one of them takes. A number of text and what parts it from the next are two.
    fn least(&self, encoding: Encoding) -> u64 {
        let of = |property: &Property| match encoding {
            Encoding::Text => 2,
            _ => property.length.unwrap_or(property.scalar).bytes as u64,
        };
        self.properties.iter().map(of).sum()
    }

    /// Refuses more of them than there is room for in the file. At its end a number need not be parted from another.
    fn check(&self, encoding: Encoding, left: u64) -> Result<(), PlyError> {
        let (stated, least) = (self.count, self.least(encoding));
        let most = (left + 1).checked_div(least).unwrap_or(u64::MAX);
        if stated > most { Err(PlyError::Cut { element: self.name.clone(), stated, most }) } else { Ok(()) }
    }

    fn read(&self, body: &mut Body<impl BufRead>, model: &mut Collected, vertices: u64) -> Result<(), PlyError> {
        if self.name == "vertex" {
            return self.read_vertices(body, model);
        }
        let is_corners = |property: &Property| {
            self.name == "face"
                && property.length.is_some()
                && ["vertex_indices", "vertex_index"].contains(&&*property.name)
        };
        // Without properties it is nothing, however many are stated.
        let count = if self.properties.is_empty() { 0 } else { self.count };
        let channels = self.channels().filter(|_| self.name == "face");
        let mut values = vec![0.0; self.properties.len()];
        for index in 0..count {
            let at = ElementIndex { element: &self.name, index };
            for (value, property) in values.iter_mut().zip(&self.properties) {
                let Some(length) = property.length else {
                    *value = body.value(property.scalar, at)?;
                    continue;
                };
                let length = body.length(length, at)?;
                if !is_corners(property) {
                    (0..length).try_for_each(|_| body.value(property.scalar, at).map(drop))?;
                    continue;
                }
                model.begin_face().map_err(|refused| at.refused(refused))?;
                for _ in 0..length {
                    let found = body.value(property.scalar, at)?;
                    // NaN is none, either.
                    if !(found >= 0.0 && found < vertices.min(u32::MAX.into()) as f64 && found.fract() == 0.0) {
                        return Err(PlyError::OutOfRange { element: self.name.clone(), index, found, vertices });
                    }
                    model.corner(found as u32).map_err(|refused| at.refused(refused))?;
                }
                model.end_face().map_err(|refused| at.refused(refused))?;
            }
            if let Some(channels) = channels {
                model
                    .color_faces(channels.map(|channel| channel.of(&values)))
                    .map_err(|refused| at.refused(refused))?;
            }
        }
        Ok(())
    }

    /// Where the colour is, if it has one.
    fn channels(&self) -> Option<[Channel; 3]> {
        let found = ["red", "green", "blue"].map(|name| {
            let column =
                self.properties.iter().position(|property| property.name == name && property.length.is_none())?;
            let most = match self.properties[column].scalar {
                Scalar { kind: 'f', .. } => 1.0,
                Scalar { bytes: 2, .. } => f64::from(u16::MAX),
                Scalar { .. } => f64::from(u8::MAX),
            };
            Some(Channel { column, most })
        });
        let [Some(red), Some(green), Some(blue)] = found else { return None };
        Some([red, green, blue])
    }

    fn read_vertices(&self, body: &mut Body<impl BufRead>, model: &mut Collected) -> Result<(), PlyError> {
        let mut columns = [0; 3];
        for (column, property) in columns.iter_mut().zip(["x", "y", "z"]) {
            let found =
                self.properties.iter().position(|candidate| candidate.name == property && candidate.length.is_none());
            *column = found.ok_or(PlyError::NoPosition { property })?;
        }
        model
            .check_vertices(self.count)
            .map_err(|refused| ElementIndex { element: &self.name, index: 0 }.refused(refused))?;
        let channels = self.channels();
        let mut values = vec![0.0; self.properties.len()];
        for index in 0..self.count {
            let at = ElementIndex { element: &self.name, index };
            for (value, property) in values.iter_mut().zip(&self.properties) {
                match property.length {
                    Some(length) => {
                        let length = body.length(length, at)?;
                        (0..length).try_for_each(|_| body.value(property.scalar, at).map(drop))?;
                    }
                    None => *value = body.value(property.scalar, at)?,
                }
            }
            model.vertex(columns.map(|column| values[column])).map_err(|refused| at.refused(refused))?;
            if let Some(channels) = channels {
                model
                    .color_vertex(channels.map(|channel| channel.of(&values)))
                    .map_err(|refused| at.refused(refused))?;
            }
        }
        Ok(())
    }
}

/// A component of colours: the property, and the number that stands for 1.
#[derive(Clone, Copy)]
struct Channel {
    column: usize,
    most: f64,
}

impl Channel {
    /// The linear value. Files have values for displays, floats too.
    fn of(self, values: &[f64]) -> f32 {
        linear(values[self.column] / self.most)
    }
}

/// An element, for messages.
#[derive(Clone, Copy)]
struct ElementIndex<'a> {
    element: &'a str,
    index: u64,
}

impl ElementIndex<'_> {
    fn refused(self, refused: Refused) -> PlyError {
        let (element, index) = (self.element.into(), self.index);
        match refused {
            Refused::Corners(found) => PlyError::Corners { element, index, found },
            Refused::FaceTooLarge => PlyError::FaceTooLarge { element, index },
            Refused::TooLarge { needed, limit } => PlyError::TooLarge { element, index, needed, limit },
        }
    }
}

struct Body<R> {
    reader: R,
    encoding: Encoding,
    /// A number of text.
    word: Vec<u8>,
}

impl<R: BufRead> Body<R> {
    fn value(&mut self, scalar: Scalar, at: ElementIndex<'_>) -> Result<f64, PlyError> {
        let ended = |error: io::Error| match error.kind() {
            io::ErrorKind::UnexpectedEof => PlyError::Ended { element: at.element.into(), index: at.index },
            _ => error.into(),
        };
        if self.encoding == Encoding::Text {
            self.read_word().map_err(ended)?;
            let word = Some(&self.word).filter(|word| word.len() <= MAX_WORD);
            let found = word.and_then(|word| std::str::from_utf8(word).ok()).and_then(number);
            let shown = || String::from_utf8_lossy(&self.word[..self.word.len().min(160)]).chars().take(40).collect();
            return found.ok_or_else(|| PlyError::Number {
                element: at.element.into(),
                index: at.index,
                found: shown(),
            });
        }
        let mut bytes = [0; 8];
        let value_bytes = &mut bytes[..scalar.bytes];
        self.reader.read_exact(value_bytes).map_err(ended)?;
        if self.encoding == Encoding::BigEndian {
            value_bytes.reverse();
        }
        Ok(scalar.value(bytes))
    }

    /// The length of a list. No more are read than the file has, so it may be anything.
    fn length(&mut self, scalar: Scalar, at: ElementIndex<'_>) -> Result<u64, PlyError> {
        let found = self.value(scalar, at)?;
        if found >= 0.0 && found.fract() == 0.0 {
            return Ok(found as u64);
        }
        Err(PlyError::List { element: at.element.into(), index: at.index, found })
    }

    /// The next word of text. One that is too long for a number is cut.
    fn read_word(&mut self) -> io::Result<()> {
        self.word.clear();
        loop {
            let chunk = self.reader.fill_buf()?;
            if chunk.is_empty() {
                return if self.word.is_empty() { Err(io::ErrorKind::UnexpectedEof.into()) } else { Ok(()) };
            }
            let blanks = if self.word.is_empty() {
                chunk.iter().take_while(|byte| byte.is_ascii_whitespace()).count()
            } else {
                0
            };
            let word_bytes = chunk[blanks..].iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
            let is_end = blanks + word_bytes < chunk.len();
            let kept = word_bytes.min(MAX_WORD + 1 - self.word.len());
            self.word.extend_from_slice(&chunk[blanks..blanks + kept]);
            self.reader.consume(blanks + word_bytes);
            if is_end {
                return Ok(());
            }
        }
    }
}
