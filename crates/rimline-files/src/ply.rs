//! PLY files, which may hold anything: vertices, and faces of any number of corners, as text or in binary.

use std::io::{self, BufRead, Read, Seek, SeekFrom};

use rimline::mesh::MAX_POLYGON_CORNERS;

use crate::collected::{Collected, Refused};
use crate::coordinates::number;
use crate::line::shown;
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
    #[error("`{element}` {index}{fault}")]
    Element { element: String, index: u64, fault: ElementFault },
}

/// The fault of an element, as it goes on in a message.
#[derive(Debug, thiserror::Error)]
pub enum ElementFault {
    #[error(": cannot be read: {0}")]
    Read(io::Error),
    #[error(": the file ends within it; get the whole file")]
    Ended,
    #[error(": {found:?} is no number")]
    Number { found: String },
    #[error(": a list cannot have {found} elements")]
    List { found: f64 },
    #[error(" names vertex {found}, but there are {vertices}; they are counted from 0")]
    OutOfRange { found: f64, vertices: u64 },
    #[error(" has {found} corner{}; a face needs at least 3", if *.found == 1 { "" } else { "s" })]
    Corners { found: usize },
    #[error(" has more than {MAX_POLYGON_CORNERS} corners; cut it into several")]
    FaceTooLarge,
    #[error(
        ": what is read so far takes {needed} bytes of memory with what is made of it, more than the limit of {limit}; if it is \
         meant to be that large, give a larger --memory-limit"
    )]
    TooLarge { needed: u64, limit: u64 },
}

impl From<io::Error> for ElementFault {
    fn from(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::UnexpectedEof { Self::Ended } else { Self::Read(error) }
    }
}

impl From<Refused> for ElementFault {
    fn from(refused: Refused) -> Self {
        match refused {
            Refused::Corners(found) => Self::Corners { found },
            Refused::FaceTooLarge => Self::FaceTooLarge,
            Refused::TooLarge { needed, limit } => Self::TooLarge { needed, limit },
        }
    }
}

impl ElementFault {
    fn at(self, element: &str, index: u64) -> PlyError {
        match self {
            Self::Read(error) => PlyError::Read(error),
            fault => PlyError::Element { element: shown(element.as_bytes()), index, fault },
        }
    }
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
    model.finish().map_err(|refused| ElementFault::from(refused).at("face", 0))?.ok_or(PlyError::NoFaces)
}

impl Header {
    fn read(reader: &mut impl BufRead) -> Result<Self, PlyError> {
        let mut text = reader.by_ref().take(MAX_HEADER);
        let has_returns = |first: &[u8]| first.starts_with(b"ply\r") && !matches!(first.get(4), Some(b'\r' | b'\n'));
        let end = if has_returns(text.fill_buf()?) { b'\r' } else { b'\n' };
        let (mut encoding, mut elements) = (None, Vec::<Element>::new());
        let mut line = 0;
        loop {
            let Some(header) = header_line(&mut text, end)? else { return Err(PlyError::Endless) };
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
                        return Err(PlyError::Twice { line, name: shown(name.as_bytes()) });
                    }
                    elements.push(Element { name: name.into(), count, properties: Vec::new() });
                }
                ["property", ref words @ ..] => {
                    let property = Property::of(words).map_err(wrong)?;
                    let element = elements.last_mut().ok_or_else(|| wrong(Property::WANTED))?;
                    if element.properties.iter().any(|other| other.name == property.name) {
                        return Err(PlyError::Twice { line, name: shown(property.name.as_bytes()) });
                    }
                    element.properties.push(property);
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

/// The next line without its end: CR, or LF with or without a CR before.
fn header_line(text: &mut impl BufRead, end: u8) -> io::Result<Option<Vec<u8>>> {
    let mut line = Vec::new();
    text.read_until(end, &mut line)?;
    let whole = line.strip_suffix(&[end]);
    Ok(whole.map(|line| line.strip_suffix(b"\r").unwrap_or(line).to_vec()))
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
        if stated <= most {
            return Ok(());
        }
        Err(PlyError::Cut { element: shown(self.name.as_bytes()), stated, most })
    }

    fn read(&self, body: &mut Body<impl BufRead>, model: &mut Collected, vertices: u64) -> Result<(), PlyError> {
        let is_face = self.name == "face";
        let axes = (self.name == "vertex").then(|| self.axes()).transpose()?;
        if axes.is_some() {
            model.check_vertices(self.count).map_err(|refused| ElementFault::from(refused).at(&self.name, 0))?;
        }
        // Without properties it is nothing, however many are stated.
        let count = if self.properties.is_empty() { 0 } else { self.count };
        let channels = self.channels().filter(|_| is_face || axes.is_some());
        let mut values = vec![0.0; self.properties.len()];
        let mut read_one = || {
            for (value, property) in values.iter_mut().zip(&self.properties) {
                match property.length {
                    None => *value = body.value(property.scalar)?,
                    Some(length) if is_face && property.is_corners() => {
                        body.face(length, property.scalar, model, vertices)?;
                    }
                    Some(length) => {
                        (0..body.length(length)?).try_for_each(|_| body.value(property.scalar).map(drop))?;
                    }
                }
            }
            if let Some(axes) = axes {
                model.vertex(axes.map(|column| values[column]))?;
            }
            match channels.map(|channels| channels.map(|channel| channel.of(&values))) {
                Some(color) if is_face => model.color_faces(color)?,
                Some(color) => model.color_vertex(color)?,
                None => {}
            }
            Ok::<_, ElementFault>(())
        };
        (0..count).try_for_each(|index| read_one().map_err(|fault| fault.at(&self.name, index)))
    }

    /// The column of a number of this name.
    fn column(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|property| property.name == name && property.length.is_none())
    }

    /// The columns of a position.
    fn axes(&self) -> Result<[usize; 3], PlyError> {
        let axis = |property| self.column(property).ok_or(PlyError::NoPosition { property });
        Ok([axis("x")?, axis("y")?, axis("z")?])
    }

    /// Where the colour is, if it has one.
    fn channels(&self) -> Option<[Channel; 3]> {
        let channel = |name| {
            let column = self.column(name)?;
            let most = match self.properties[column].scalar {
                Scalar { kind: 'f', .. } => 1.0,
                Scalar { bytes: 2, .. } => f64::from(u16::MAX),
                Scalar { .. } => f64::from(u8::MAX),
            };
            Some(Channel { column, most })
        };
        Some([channel("red")?, channel("green")?, channel("blue")?])
    }
}

impl Property {
    const WANTED: &str = "a property is `property TYPE NAME` or `property list TYPE TYPE NAME`, after an element";

    /// The property of these words of its line, or what is wanted instead.
    fn of(words: &[&str]) -> Result<Self, &'static str> {
        let (length, scalar, name) = match *words {
            ["list", length, scalar, name] => (Some(length), scalar, name),
            [scalar, name] => (None, scalar, name),
            _ => return Err(Self::WANTED),
        };
        let scalar_of = |name| Scalar::named(name).ok_or("its type is not one of PLY's");
        Ok(Self { name: name.into(), length: length.map(scalar_of).transpose()?, scalar: scalar_of(scalar)? })
    }

    /// Whether it is the list of a face's corners.
    fn is_corners(&self) -> bool {
        ["vertex_indices", "vertex_index"].contains(&&*self.name)
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

struct Body<R> {
    reader: R,
    encoding: Encoding,
    /// A number of text.
    word: Vec<u8>,
}

impl<R: BufRead> Body<R> {
    fn value(&mut self, scalar: Scalar) -> Result<f64, ElementFault> {
        if self.encoding == Encoding::Text {
            self.read_word()?;
            let word = Some(&self.word).filter(|word| word.len() <= MAX_WORD);
            let found = word.and_then(|word| std::str::from_utf8(word).ok()).and_then(number);
            return found.ok_or_else(|| ElementFault::Number { found: shown(&self.word) });
        }
        let mut bytes = [0; 8];
        let value_bytes = &mut bytes[..scalar.bytes];
        self.reader.read_exact(value_bytes)?;
        if self.encoding == Encoding::BigEndian {
            value_bytes.reverse();
        }
        Ok(scalar.value(bytes))
    }

    /// The length of a list. No more are read than the file has, so it may be anything.
    fn length(&mut self, scalar: Scalar) -> Result<u64, ElementFault> {
        let found = self.value(scalar)?;
        if found >= 0.0 && found.fract() == 0.0 { Ok(found as u64) } else { Err(ElementFault::List { found }) }
    }

    /// The corners of a face.
    fn face(
        &mut self,
        length: Scalar,
        corner: Scalar,
        model: &mut Collected,
        vertices: u64,
    ) -> Result<(), ElementFault> {
        let length = self.length(length)?;
        model.begin_face()?;
        for _ in 0..length {
            let found = self.value(corner)?;
            // NaN is none, either.
            if !(found >= 0.0 && found < vertices.min(u32::MAX.into()) as f64 && found.fract() == 0.0) {
                return Err(ElementFault::OutOfRange { found, vertices });
            }
            model.corner(found as u32)?;
        }
        Ok(model.end_face()?)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_shows_the_beginning_of_a_long_name() {
        let name = "long".repeat(1000);
        for header in [
            format!("element {name} 9\nproperty int x\nend_header\n"),
            format!("element {name} 1\nproperty int x\nend_header\nnone\n"),
            format!("element {name} 1\nelement {name} 1\n"),
            format!("element a 1\nproperty int {name}\nproperty int {name}\n"),
        ] {
            let file = io::Cursor::new(format!("ply\nformat ascii 1.0\n{header}"));
            let message = read(file, 1 << 20, false).expect_err("it has no faces").to_string();
            assert!(message.contains("longlong") && message.len() < 300, "{message}");
        }
    }
}
