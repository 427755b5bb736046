//! The header of a .npy array: its element type, order and shape.
//!
//! The format is that of `numpy.lib.format`: a magic string, a version, a length, and a Python dictionary of three entries.
//! Only these are accepted, and read without recursion, because a file may say anything.

use std::fmt;
use std::io::{self, Read};

/// Type of an array's elements, as NumPy writes it: `<f4`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ElementType {
    /// `f` float, `i` and `u` integer, `b` bool. Read from a file: any letter.
    pub kind: char,
    /// Bytes an element.
    pub size: usize,
    pub big_endian: bool,
}

impl ElementType {
    const fn native(kind: char, size: usize) -> Self {
        Self { kind, size, big_endian: cfg!(target_endian = "big") }
    }

    // In this machine's byte order.
    pub const U8: Self = Self::native('u', 1);
    pub const BOOL: Self = Self::native('b', 1);
    pub const U16: Self = Self::native('u', 2);
    pub const U32: Self = Self::native('u', 4);
    pub const I32: Self = Self::native('i', 4);
    pub const F32: Self = Self::native('f', 4);
    pub const F64: Self = Self::native('f', 8);

    fn parse(descr: &str) -> Option<Self> {
        let mut chars = descr.chars();
        let order = chars.next()?;
        let kind = chars.next()?;
        let size = chars.as_str().parse().ok()?;
        let big_endian = match order {
            '<' | '|' => false,
            '>' => true,
            '=' => cfg!(target_endian = "big"),
            _ => return None,
        };
        Some(Self { kind, size, big_endian })
    }
}

impl fmt::Display for ElementType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let order = match (self.size, self.big_endian) {
            (1, _) => '|',
            (_, false) => '<',
            (_, true) => '>',
        };
        write!(f, "{order}{}{}", self.kind, self.size)
    }
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Header {
    /// The type as the file writes it: any string.
    pub(crate) descr: String,
    /// `descr`, where it is an order, a letter and a size. Callers check the letter and the size.
    pub(crate) element: Option<ElementType>,
    pub(crate) fortran_order: bool,
    pub(crate) shape: Vec<u64>,
    /// Bytes from the file's begin to the data.
    pub(crate) length: u64,
}

#[derive(Debug, thiserror::Error)]
pub enum HeaderError {
    #[error("it ends within the header: {0}")]
    Read(#[from] io::Error),
    #[error("it does not begin as a .npy array does")]
    Magic,
    #[error("its .npy version {0} is unknown; 1, 2 and 3 can be read")]
    Version(u8),
    #[error("its header takes {0} bytes, more than any array of numbers needs")]
    Length(u32),
    #[error("its header cannot be understood at byte {0}")]
    Syntax(usize),
    #[error("its header has no `{0}`")]
    Missing(&'static str),
}

const MAGIC: &[u8; 6] = b"\x93NUMPY";
/// Plain arrays usually take 128 bytes; NumPy itself refuses more than 10,000.
const LONGEST: u32 = 1 << 16;

impl Header {
    pub(super) fn read(reader: &mut impl Read) -> Result<Self, HeaderError> {
        let mut start = [0; 8];
        reader.read_exact(&mut start)?;
        if start[..6] != *MAGIC {
            return Err(HeaderError::Magic);
        }
        let mut length = [0; 4];
        let digits = match start[6] {
            1 => 2,
            2 | 3 => 4,
            version => return Err(HeaderError::Version(version)),
        };
        reader.read_exact(&mut length[..digits])?;
        let length = u32::from_le_bytes(length);
        if length > LONGEST {
            return Err(HeaderError::Length(length));
        }
        let mut text = vec![0; length as usize];
        reader.read_exact(&mut text)?;
        Ok(Self { length: (start.len() + digits) as u64 + u64::from(length), ..Self::parse(&text)? })
    }

    fn parse(text: &[u8]) -> Result<Self, HeaderError> {
        let (mut descr, mut fortran_order, mut shape) = (None, None, None);
        let mut at = Cursor { text, next: 0 };
        at.expect(b'{')?;
        while !at.take(b'}') {
            let key = at.string()?;
            at.expect(b':')?;
            match key.as_str() {
                "descr" => descr = Some(at.string()?),
                "fortran_order" => fortran_order = Some(at.boolean()?),
                "shape" => shape = Some(at.tuple()?),
                _ => return Err(at.error()),
            }
            if !at.take(b',') {
                at.expect(b'}')?;
                break;
            }
        }
        if at.peek().is_some() {
            return Err(at.error());
        }
        let descr = descr.ok_or(HeaderError::Missing("descr"))?;
        Ok(Self {
            element: ElementType::parse(&descr),
            descr,
            fortran_order: fortran_order.ok_or(HeaderError::Missing("fortran_order"))?,
            shape: shape.ok_or(HeaderError::Missing("shape"))?,
            length: 0,
        })
    }

    /// The header of an array in C order, as NumPy 1.14 and later write it: its end at a multiple of 64 bytes.
    pub(super) fn bytes(element: ElementType, shape: &[usize]) -> Vec<u8> {
        let shape: String = match shape {
            [single] => format!("({single},)"),
            _ => format!("({})", shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")),
        };
        let mut text = format!("{{'descr': '{element}', 'fortran_order': False, 'shape': {shape}, }}");
        let unpadded = MAGIC.len() + 4 + text.len() + 1;
        text.extend(std::iter::repeat_n(' ', unpadded.next_multiple_of(64) - unpadded));
        text.push('\n');
        let mut bytes = MAGIC.to_vec();
        bytes.extend([1, 0]);
        bytes.extend((text.len() as u16).to_le_bytes());
        bytes.extend(text.into_bytes());
        bytes
    }
}

/// A position in the header's text; white space between tokens is passed over.
struct Cursor<'a> {
    text: &'a [u8],
    next: usize,
}

impl Cursor<'_> {
    fn error(&self) -> HeaderError {
        HeaderError::Syntax(self.next)
    }

    fn peek(&mut self) -> Option<u8> {
        while self.text.get(self.next).is_some_and(u8::is_ascii_whitespace) {
            self.next += 1;
        }
        self.text.get(self.next).copied()
    }

    fn take(&mut self, byte: u8) -> bool {
        let found = self.peek() == Some(byte);
        self.next += usize::from(found);
        found
    }

    fn expect(&mut self, byte: u8) -> Result<(), HeaderError> {
        if self.take(byte) { Ok(()) } else { Err(self.error()) }
    }

    /// The bytes from here for which `belongs` holds.
    fn run(&mut self, belongs: impl Fn(u8) -> bool) -> &[u8] {
        let rest = &self.text[self.next.min(self.text.len())..];
        let length = rest.iter().position(|&byte| !belongs(byte)).unwrap_or(rest.len());
        self.next += length;
        &rest[..length]
    }

    fn string(&mut self) -> Result<String, HeaderError> {
        let Some(quote @ (b'\'' | b'"')) = self.peek() else {
            return Err(self.error());
        };
        self.next += 1;
        let text = String::from_utf8_lossy(self.run(|byte| byte != quote && byte != b'\\')).into_owned();
        self.expect(quote)?;
        Ok(text)
    }

    fn boolean(&mut self) -> Result<bool, HeaderError> {
        self.peek();
        match self.run(|byte| byte.is_ascii_alphabetic()) {
            b"True" => Ok(true),
            b"False" => Ok(false),
            _ => Err(self.error()),
        }
    }

    fn tuple(&mut self) -> Result<Vec<u64>, HeaderError> {
        let mut values = Vec::new();
        self.expect(b'(')?;
        while !self.take(b')') {
            let digits = String::from_utf8_lossy(self.run(|byte| byte.is_ascii_digit())).into_owned();
            // Python 2 wrote long integers as `3L`.
            self.take(b'L');
            values.push(digits.parse().map_err(|_| self.error())?);
            if !self.take(b',') {
                self.expect(b')')?;
                break;
            }
        }
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Header, HeaderError> {
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((text.len() as u16).to_le_bytes());
        bytes.extend(text.as_bytes());
        Header::read(&mut bytes.as_slice())
    }

    #[test]
    fn what_is_written_is_read() {
        let bytes = Header::bytes(ElementType::F32, &[7, 3]);
        assert_eq!(bytes.len() % 64, 0);
        let header = Header::read(&mut bytes.as_slice()).expect("it is our own");
        assert_eq!((header.element, header.shape), (Some(ElementType::F32), vec![7, 3]));
        let single = Header::read(&mut Header::bytes(ElementType::U8, &[5]).as_slice()).expect("it is our own");
        assert_eq!((single.descr.as_str(), single.shape), ("|u1", vec![5]));
    }

    #[test]
    fn other_writers_are_understood() {
        let header = read("{\"shape\":(2L,3),'fortran_order':True , 'descr':'>i8'}").expect("it is sound");
        assert!(header.fortran_order);
        assert_eq!(header.element, Some(ElementType { kind: 'i', size: 8, big_endian: true }));
    }

    #[test]
    fn anything_else_is_an_error() {
        let nested = format!("{{'descr': {}", "(".repeat(60_000));
        for text in [
            "",
            "{",
            "{'descr': '<f4'}",
            "{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': (1, 3)}",
            "{'descr': '<f4', 'fortran_order': Maybe, 'shape': (1, 3)}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999999999999, 3)}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (-1, 3)}",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (1, 3)} trailing",
            &nested,
        ] {
            assert!(read(text).is_err(), "{text:.60}");
        }
        assert!(matches!(Header::read(&mut &b"\x93NUMPX\x01\x00"[..]), Err(HeaderError::Magic)));
        let endless = b"\x93NUMPY\x02\x00\xff\xff\xff\xff";
        assert!(matches!(Header::read(&mut &endless[..]), Err(HeaderError::Length(_))));
    }
}
