//! Differences between two archives, down to the bit.

use std::fmt;
use std::io::{Cursor, Read};

use zip::ZipArchive;

use super::header::Header;
use super::read::{NpzError, listed, shown};

/// A difference between an archive and the one expected of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Difference {
    /// It has other arrays, or in another order.
    Arrays { given: Vec<String>, expected: Vec<String> },
    /// An array's elements are of another type, or its shape is another.
    Form { array: String, given: String, expected: String },
    /// An array's bits. `first` is the first element that differs.
    Bits { array: String, count: u64, first: Element },
    /// All arrays are equal; the bytes around them are not, from this one on.
    Container { byte: usize },
}

/// An element in two archives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Element {
    pub row: usize,
    pub column: usize,
    /// The light of the lowest bit that differs, where the array's bits are lights'.
    pub light: Option<usize>,
    pub given: u64,
    pub expected: u64,
}

impl Difference {
    pub fn array(&self) -> Option<&str> {
        match self {
            Self::Form { array, .. } | Self::Bits { array, .. } => Some(array),
            Self::Arrays { .. } | Self::Container { .. } => None,
        }
    }

    pub fn bits(&self) -> u64 {
        if let Self::Bits { count, .. } = self { *count } else { 0 }
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Arrays { given, expected } => {
                write!(f, "its arrays are {} instead of {}", listed(given), listed(expected))
            }
            Self::Form { array, given, expected } => write!(f, "`{array}` is {given} instead of {expected}"),
            Self::Bits { array, count, first } => {
                let plural = if *count == 1 { "bit" } else { "bits" };
                write!(f, "`{array}` has {count} {plural} otherwise, first in row {}, {first}", first.row)
            }
            Self::Container { byte } => write!(
                f,
                "its arrays are equal, but its bytes are others from byte {byte} on: `rimline extract` did not write it"
            ),
        }
    }
}

impl fmt::Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { column, given, expected, .. } = self;
        match self.light {
            Some(light) => {
                let bit = |word: u64| word >> (light % 32) & 1;
                write!(f, "light {light}: {} in the file, {} found", bit(*given), bit(*expected))
            }
            None => write!(f, "column {column}: {given:#x} in the file, {expected:#x} found"),
        }
    }
}

/// Everything that `given` has otherwise than `expected`, an archive of ours.
pub fn compare(given: &[u8], expected: &[u8]) -> Result<Vec<Difference>, NpzError> {
    if given == expected {
        return Ok(Vec::new());
    }
    let (mut given_archive, mut expected_archive) = (open(given)?, open(expected)?);
    let [names, expected_names] = [&given_archive, &expected_archive].map(names);
    if names != expected_names {
        return Ok(vec![Difference::Arrays { given: names, expected: expected_names }]);
    }
    let mut differences = Vec::new();
    for (index, name) in names.iter().enumerate() {
        let ours = Array::read(&mut expected_archive, index, name, u64::MAX)?;
        // An entry may unpack to anything; one byte too many says enough.
        let theirs = Array::read(&mut given_archive, index, name, ours.data.len() as u64 + 1)?;
        differences.extend(theirs.differs_from(&ours));
    }
    if differences.is_empty() {
        let byte = given.iter().zip(expected).take_while(|(given, expected)| given == expected).count();
        differences.push(Difference::Container { byte });
    }
    Ok(differences)
}

type Archive<'a> = ZipArchive<Cursor<&'a [u8]>>;

fn open(bytes: &[u8]) -> Result<Archive<'_>, NpzError> {
    Ok(ZipArchive::new(Cursor::new(bytes))?)
}

fn names(archive: &Archive<'_>) -> Vec<String> {
    let name = |raw: &[u8]| {
        let name = String::from_utf8_lossy(raw);
        name.strip_suffix(".npy").unwrap_or(&name).to_owned()
    };
    archive.file_names_raw().map(name).collect()
}

/// An array as its entry has it.
struct Array {
    name: String,
    header: Header,
    data: Vec<u8>,
}

impl Array {
    fn read(archive: &mut Archive<'_>, index: usize, name: &str, most: u64) -> Result<Self, NpzError> {
        let name = name.to_owned();
        let unreadable = |source| NpzError::Entry { array: name.clone(), source };
        let mut reader = archive.by_index(index).map_err(|error| unreadable(error.into()))?;
        let header = Header::read(&mut reader).map_err(|source| NpzError::Header { array: name.clone(), source })?;
        let mut data = Vec::new();
        reader.take(most).read_to_end(&mut data).map_err(unreadable)?;
        Ok(Self { name, header, data })
    }

    fn form(&self) -> String {
        let order = if self.header.fortran_order { ", in column order" } else { "" };
        let Header { descr, shape, .. } = &self.header;
        let descr: String = descr.chars().take(40).collect();
        format!("{descr} of shape ({}) in {} bytes{order}", shown(shape), self.data.len())
    }

    fn differs_from(&self, expected: &Self) -> Option<Difference> {
        let array = self.name.clone();
        let [form, expected_form] = [self, expected].map(Self::form);
        if form != expected_form {
            return Some(Difference::Form { array, given: form, expected: expected_form });
        }
        let size = expected.header.element.map_or(1, |element| element.size).max(1);
        let columns = (expected.header.shape.iter().skip(1).product::<u64>() as usize).max(1);
        let pairs = self.data.chunks(size).map(raw).zip(expected.data.chunks(size).map(raw));
        let mut different = pairs.enumerate().filter(|(_, (given, expected))| given != expected);
        let (at, (given, expected)) = different.next()?;
        let wrong_bits = |(given, expected): (u64, u64)| u64::from((given ^ expected).count_ones());
        let count = wrong_bits((given, expected)) + different.map(|(_, pair)| wrong_bits(pair)).sum::<u64>();
        let column = at % columns;
        let is_mask = ["facing", "silhouette", "winding"].contains(&array.as_str());
        let light = is_mask.then(|| 32 * column + (given ^ expected).trailing_zeros() as usize);
        let first = Element { row: at / columns, column, light, given, expected };
        Some(Difference::Bits { array, count, first })
    }
}

/// Up to eight little-endian bytes.
fn raw(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte))
}

#[cfg(test)]
mod tests {
    use super::super::{ElementType, NpzWriter};
    use super::*;

    fn archive(facing: [u32; 4], kind: [u8; 2]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut npz = NpzWriter::new(Cursor::new(&mut bytes));
        npz.array("facing", ElementType::U32, &[2, 2], |to| to.write_all(bytemuck::cast_slice(&facing)))
            .expect("facing");
        npz.array("edge_kind", ElementType::U8, &[2], |to| to.write_all(&kind)).expect("kinds");
        npz.finish().expect("it goes to memory");
        bytes
    }

    #[test]
    fn each_bit_is_found_where_it_is() {
        let expected = archive([1, 2, 3, 4], [0, 2]);
        assert_eq!(compare(&expected, &expected).expect("sound"), []);
        let given = archive([1, 2, 3, 4 ^ 0x0101], [0, 1]);
        let found = compare(&given, &expected).expect("sound");
        let facing = Element { row: 1, column: 1, light: Some(32), given: 0x105, expected: 4 };
        let kind = Element { row: 1, column: 0, light: None, given: 1, expected: 2 };
        assert_eq!(
            found,
            [
                Difference::Bits { array: "facing".into(), count: 2, first: facing },
                Difference::Bits { array: "edge_kind".into(), count: 2, first: kind },
            ]
        );
        assert_eq!(
            found[0].to_string(),
            "`facing` has 2 bits otherwise, first in row 1, light 32: 1 in the file, 0 found"
        );
    }

    #[test]
    fn what_is_around_the_arrays_counts_too() {
        let expected = archive([1, 2, 3, 4], [0, 2]);
        let mut given = expected.clone();
        // The hour of the first entry, in its own header and in the directory.
        for at in 10..given.len() {
            if given[at - 10..].starts_with(b"PK\x03\x04") {
                given[at + 1] ^= 8;
                break;
            }
        }
        let found = compare(&given, &expected).expect("sound");
        assert_eq!(found, [Difference::Container { byte: 11 }]);
        given.pop();
        assert!(compare(&given, &expected).is_err());
    }
}
