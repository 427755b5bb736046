//! Reading arrays of an archive that may hold anything.

use std::io::{self, Read, Seek};

use rimline::Origin;
use rimline::gltf::Colors;
use rimline::mesh::{MAX_FACES, PolygonLoops};
use zip::ZipArchive;
use zip::result::ZipError;

use super::header::{ElementType, Header, HeaderError};
use crate::charge::{self, CORNER, LOOP, POLYGON, VERTEX};

/// Positions relative to an origin, those of an archive and of a binary STL bit for bit, and triangles whose indices are
/// below their number, or polygons.
#[derive(Debug, Default, PartialEq)]
pub struct Arrays {
    pub positions: Vec<[f32; 3]>,
    /// Empty if there are polygons.
    pub faces: Vec<[u32; 3]>,
    pub polygons: Option<PolygonArrays>,
    pub origin: Origin,
    /// Linear colours of faces or polygons, and of vertices.
    pub colors: Colors,
}

/// Polygons, unchecked: `rimline::Mesh::from_polygons` checks them.
#[derive(Debug, Default, PartialEq)]
pub struct PolygonArrays {
    pub(crate) polygon_loops: Vec<u32>,
    pub(crate) loop_sizes: Vec<u32>,
    pub(crate) loop_corners: Vec<u32>,
}

impl PolygonArrays {
    pub fn loops(&self) -> PolygonLoops<'_> {
        let Self { polygon_loops, loop_sizes, loop_corners } = self;
        PolygonLoops { polygon_loops, loop_sizes, loop_corners }
    }
}

#[derive(Debug, thiserror::Error)]
pub enum NpzError {
    #[error("it is not a ZIP archive that can be read: {0}")]
    Archive(#[from] ZipError),
    #[error("it has no array `{array}`, which is needed here; it has {}", listed(.found))]
    Missing { array: &'static str, found: Vec<String> },
    #[error("array `{array}`: its ZIP entry cannot be read: {source}")]
    Entry { array: String, source: io::Error },
    #[error("array `{array}`: {source}")]
    Header { array: String, source: HeaderError },
    #[error("array `{array}` has elements of type {found}; {wanted}")]
    Element { array: &'static str, found: String, wanted: &'static str },
    #[error("array `{array}` has shape ({}), but {wanted} is needed", shown(.shape))]
    Shape { array: &'static str, shape: Vec<u64>, wanted: &'static str },
    #[error("array `{array}` has {rows} rows, more than the {limit} that can be counted")]
    Rows { array: &'static str, rows: u64, limit: u64 },
    #[error("array `{array}` takes {wanted} bytes by its header, but its ZIP entry holds {held}")]
    Length { array: &'static str, wanted: u64, held: u64 },
    #[error("array `{array}` with {rows} rows does not fit into memory")]
    Memory { array: &'static str, rows: u64 },
    #[error(
        "array `{array}` with {rows} rows takes {needed} bytes of memory with what is made of it, more than the limit of \
         {limit}; if it is meant to be that large, give a larger --memory-limit"
    )]
    TooLarge { array: &'static str, rows: u64, needed: u64, limit: u64 },
    #[error("array `{array}` holds {found}; {wanted}")]
    Value { array: &'static str, found: String, wanted: &'static str },
    #[error("array `{array}`, row {row}, has the number {index}; numbers from 0 to 4294967295 can be read")]
    Index { array: &'static str, row: usize, index: i128 },
    #[error(
        "array `on_face`, row {row}, has the number {index}; faces have numbers from 0 on, and -1 is for a point that is on none"
    )]
    FaceNumber { row: usize, index: i128 },
    #[error(
        "array `on_face`, row {row}, names face {face}, but the model has {faces}: rows of `faces` as `rimline extract` writes them; \
         -1 is for a point that is on none"
    )]
    NoSuchFace { row: usize, face: u32, faces: usize },
    #[error("array `faces`, row {row}, names vertex {index}, but `positions` has {vertices} rows")]
    OutOfRange { row: usize, index: u32, vertices: usize },
    #[error(
        "it has the array `polygon_loops`, and here only meshes of triangles are compared; write one that has `faces` and no \
         such array"
    )]
    Polygons,
    #[error("array `{array}`, row {row}: {source}")]
    Data { array: &'static str, row: usize, source: io::Error },
}

/// Names for a message. A file may have thousands of any length.
pub(super) fn listed(names: &[String]) -> String {
    let beginning = |name: &String| name.chars().take(60).collect::<String>();
    if names.is_empty() { "none".into() } else { names.iter().take(12).map(beginning).collect::<Vec<_>>().join(", ") }
}

/// A shape for a message. A file may have one of thousands of numbers.
pub(super) fn shown(shape: &[u64]) -> String {
    const MOST: usize = 8;
    let numbers = shape.iter().take(MOST).map(u64::to_string).collect::<Vec<_>>().join(", ");
    if shape.len() > MOST { format!("{numbers}, … {} numbers in all", shape.len()) } else { numbers }
}

/// Reads `positions` (V,3) float32, and `faces` (F,3) integers, in either byte order and either array order. Instead of
/// `faces` there may be `polygon_loops`, `loop_sizes` and `loop_corners`, of one dimension each. Positions are relative
/// to `origin` (3), if there is one.
///
/// Refuses arrays that take more than `memory_limit` bytes with the mesh that is made of them. Their headers decide it,
/// before any array is read.
pub fn read(reader: impl Read + Seek, memory_limit: u64) -> Result<Arrays, NpzError> {
    Archive::open(reader, memory_limit)?.model()
}

/// The same, and `lights` (N,4) float32 as `extract` writes them.
pub fn read_with_lights(reader: impl Read + Seek, memory_limit: u64) -> Result<(Arrays, Vec<[f32; 4]>), NpzError> {
    let mut archive = Archive::open(reader, memory_limit)?;
    if archive.has(POLYGON_LOOPS.array) {
        return Err(NpzError::Polygons);
    }
    Ok((archive.model()?, archive.rows(&LIGHTS, FLOAT)?))
}

const INTEGERS: &str = "an integer type of 8 to 64 bits is needed (NumPy: `.astype('u4')`)";
const POSITIONS: Entry = Entry {
    array: "positions",
    shape: "(V, 3)",
    limit: u32::MAX as u64 - 1,
    row_bytes: 0,
    wanted: "float32 is needed (NumPy: `positions.astype('f4')`; \
             of large coordinates take off a point near the model first, and give that as `origin`)",
    accepts: is_float,
};
const FACES: Entry = Entry {
    array: "faces",
    shape: "(F, 3)",
    limit: MAX_FACES as u64,
    row_bytes: 0,
    wanted: "an integer type of 8 to 64 bits is needed (NumPy: `faces.astype('u4')`)",
    accepts: is_integer,
};
/// Arrays of polygons are charged before they are read.
const POLYGON_LOOPS: Entry =
    Entry { array: "polygon_loops", shape: "(P,)", limit: 3 * MAX_FACES as u64, wanted: INTEGERS, ..FACES };
const LOOP_SIZES: Entry = Entry { array: "loop_sizes", shape: "(L,)", ..POLYGON_LOOPS };
const LOOP_CORNERS: Entry = Entry { array: "loop_corners", shape: "(C,)", ..POLYGON_LOOPS };
const LIGHTS: Entry = Entry {
    array: "lights",
    shape: "(N, 4)",
    limit: u32::MAX as u64,
    row_bytes: 2 * 16,
    wanted: "float32 is needed",
    accepts: is_float,
};
pub(super) const ORIGIN: Entry = Entry {
    array: "origin",
    shape: "(3,)",
    limit: 3,
    row_bytes: 64,
    wanted: "float64 or float32 is needed: three finite coordinates",
    accepts: is_real,
};

pub(super) fn is_real(element: ElementType) -> bool {
    matches!((element.kind, element.size), ('f', 4 | 8))
}

pub(super) fn is_float(element: ElementType) -> bool {
    element.kind == 'f' && element.size == 4
}

pub(super) fn is_integer(element: ElementType) -> bool {
    matches!((element.kind, element.size), ('i' | 'u', 1 | 2 | 4 | 8))
}

/// Makes a value of an element's bytes, or says which number it cannot be.
pub(super) type Decode<T> = fn(ElementType, &[u8]) -> Result<T, i128>;

/// Up to 32 bits, as they are. A float keeps them, a NaN its payload.
#[cfg(feature = "depth-map")]
pub(super) const BITS: Decode<u32> = |element, bytes| Ok(raw(element, bytes) as u32);
pub(super) const FLOAT: Decode<f32> = |element, bytes| Ok(f32::from_bits(raw(element, bytes) as u32));
/// A float of either size, exactly.
pub(super) const REAL: Decode<f64> = |element, bytes| {
    let raw = raw(element, bytes);
    Ok(if element.size == 4 { f64::from(f32::from_bits(raw as u32)) } else { f64::from_bits(raw) })
};

/// A bool is a number of a byte.
pub(super) fn index(element: ElementType, bytes: &[u8]) -> Result<u32, i128> {
    let value = raw(element, bytes);
    let unused = 64 - 8 * element.size as u32;
    let value = if element.kind == 'i' { i128::from((value << unused) as i64 >> unused) } else { i128::from(value) };
    u32::try_from(value).map_err(|_| value)
}

/// Up to eight bytes as a little-endian number's low bytes.
fn raw(element: ElementType, bytes: &[u8]) -> u64 {
    let number = |word: u64, &byte: &u8| word << 8 | u64::from(byte);
    if element.big_endian { bytes.iter().fold(0, number) } else { bytes.iter().rev().fold(0, number) }
}

/// How an array must be, and what of it messages say.
pub(super) struct Entry {
    pub(super) array: &'static str,
    pub(super) shape: &'static str,
    pub(super) limit: u64,
    /// Bytes that a row takes of the limit of memory, or a value of an array that is no table.
    pub(super) row_bytes: u64,
    pub(super) wanted: &'static str,
    pub(super) accepts: fn(ElementType) -> bool,
}

struct Extent {
    /// Tuples that are read.
    tuples: u64,
    /// Tuples of a row, as messages count rows.
    row: u64,
}

/// The extent of a table of C columns, or of a list where C is 1.
fn table<const C: usize>(shape: &[u64]) -> Option<Extent> {
    match *shape {
        [rows] if C == 1 => Some(Extent { tuples: rows, row: 1 }),
        [rows, columns] if C > 1 && columns == C as u64 => Some(Extent { tuples: rows, row: 1 }),
        _ => None,
    }
}

pub(super) struct Head {
    pub(super) header: Header,
    pub(super) element: ElementType,
    extent: Extent,
}

/// An archive, and the memory that reading it may take, with everything that is made of it. What is charged is at least the
/// peak of the memory in use at one time: nothing is taken off again.
pub(super) struct Archive<R> {
    zip: ZipArchive<R>,
    limit: u64,
    used: u64,
}

impl<R: Read + Seek> Archive<R> {
    pub(super) fn open(reader: R, limit: u64) -> Result<Self, NpzError> {
        Ok(Self { zip: ZipArchive::new(reader)?, limit, used: 0 })
    }

    pub(super) fn has(&self, array: &str) -> bool {
        self.zip.index_for_name(&format!("{array}.npy")).is_some()
    }

    fn charge(&mut self, array: &'static str, rows: u64, bytes: u64) -> Result<(), NpzError> {
        let (needed, limit) = (self.used.saturating_add(bytes), self.limit);
        if needed > limit {
            return Err(NpzError::TooLarge { array, rows, needed, limit });
        }
        self.used = needed;
        Ok(())
    }

    fn model(&mut self) -> Result<Arrays, NpzError> {
        let origin = self.origin()?;
        let vertices = self.stated::<3>(&POSITIONS)?;
        if self.has(POLYGON_LOOPS.array) {
            self.charge(POSITIONS.array, vertices, vertices.saturating_mul(VERTEX))?;
            for (entry, bytes) in [(&POLYGON_LOOPS, POLYGON), (&LOOP_SIZES, LOOP), (&LOOP_CORNERS, CORNER)] {
                let rows = self.stated::<1>(entry)?;
                self.charge(entry.array, rows, rows.saturating_mul(bytes))?;
            }
            let positions = self.rows(&POSITIONS, FLOAT)?;
            let polygons = PolygonArrays {
                polygon_loops: self.list(&POLYGON_LOOPS, index)?,
                loop_sizes: self.list(&LOOP_SIZES, index)?,
                loop_corners: self.list(&LOOP_CORNERS, index)?,
            };
            return Ok(Arrays { positions, polygons: Some(polygons), origin, ..Arrays::default() });
        }
        let faces = self.stated::<3>(&FACES)?;
        let most = if vertices > 3 * faces { (POSITIONS.array, vertices) } else { (FACES.array, faces) };
        self.charge(most.0, most.1, charge::model(vertices, faces))?;
        let positions: Vec<[f32; 3]> = self.rows(&POSITIONS, FLOAT)?;
        let faces: Vec<[u32; 3]> = self.rows(&FACES, index)?;
        let vertices = positions.len();
        let corners = faces.as_flattened().iter();
        if let Some((corner, &index)) = corners.enumerate().find(|&(_, &index)| index as usize >= vertices) {
            return Err(NpzError::OutOfRange { row: corner / 3, index, vertices });
        }
        Ok(Arrays { positions, faces, origin, ..Arrays::default() })
    }

    /// The array `origin`, if there is one: the point of the world that positions, lights and points are relative to.
    /// Without it the origin is zero.
    pub(super) fn origin(&mut self) -> Result<Origin, NpzError> {
        let given = self.point(&ORIGIN)?;
        match given.iter().find(|c| !c.is_finite()) {
            Some(other) => {
                Err(NpzError::Value { array: ORIGIN.array, found: other.to_string(), wanted: ORIGIN.wanted })
            }
            None => Ok(Origin::new(given)),
        }
    }

    /// Three coordinates, or zeros where there is no such array.
    pub(super) fn point(&mut self, entry: &Entry) -> Result<[f64; 3], NpzError> {
        if !self.has(entry.array) {
            return Ok([0.0; 3]);
        }
        let (_, given) = self.values(entry, REAL, |shape| *shape == [3])?;
        Ok(given.try_into().unwrap_or_default())
    }

    /// The rows of a table of C columns.
    pub(super) fn rows<T: Copy + Default, const C: usize>(
        &mut self,
        entry: &Entry,
        decode: Decode<T>,
    ) -> Result<Vec<[T; C]>, NpzError> {
        Ok(self.tuples(entry, decode, table::<C>)?.1)
    }

    pub(super) fn list<T: Copy + Default>(&mut self, entry: &Entry, decode: Decode<T>) -> Result<Vec<T>, NpzError> {
        Ok(self.rows(entry, decode)?.into_iter().map(|[value]| value).collect())
    }

    /// An array whose shape `fits` accepts, and its values in C order. It has at most three dimensions, and so few values
    /// that their number is no question.
    pub(super) fn values<T: Copy + Default>(
        &mut self,
        entry: &Entry,
        decode: Decode<T>,
        fits: impl Fn(&[u64]) -> bool,
    ) -> Result<(Head, Vec<T>), NpzError> {
        let extent = |shape: &[u64]| {
            let row = shape.last().copied().unwrap_or(1).max(1);
            (shape.len() <= 3 && fits(shape)).then(|| Extent { tuples: shape.iter().product(), row })
        };
        let (head, tuples) = self.tuples::<T, 1>(entry, decode, extent)?;
        Ok((head, tuples.into_iter().map(|[value]| value).collect()))
    }

    /// The rows that the header of a table of C columns states. No data is read.
    fn stated<const C: usize>(&mut self, entry: &Entry) -> Result<u64, NpzError> {
        Ok(self.head::<C>(entry, table::<C>)?.1.extent.tuples)
    }

    fn tuples<T: Copy + Default, const C: usize>(
        &mut self,
        entry: &Entry,
        decode: Decode<T>,
        extent: impl Fn(&[u64]) -> Option<Extent>,
    ) -> Result<(Head, Vec<[T; C]>), NpzError> {
        let Extent { tuples, row } = self.head::<C>(entry, &extent)?.1.extent;
        // A compressed entry may be a thousandth of what it unpacks to.
        self.charge(entry.array, tuples / row, tuples * entry.row_bytes)?;
        let (reader, head) = self.head::<C>(entry, extent)?;
        let tuples = filled(entry.array, &head, reader, decode)?;
        Ok((head, tuples))
    }

    /// Finds the entry and reads its header, which must fit the entry's length.
    fn head<const C: usize>(
        &mut self,
        &Entry { array, shape, limit, wanted, accepts, .. }: &Entry,
        extent: impl Fn(&[u64]) -> Option<Extent>,
    ) -> Result<(impl Read, Head), NpzError> {
        if !self.has(array) {
            let found = self.zip.file_names_raw().map(|name| String::from_utf8_lossy(name).into()).collect();
            return Err(NpzError::Missing { array, found });
        }
        let entry = self.zip.by_name(&format!("{array}.npy"));
        let mut entry = entry.map_err(|source| NpzError::Entry { array: array.into(), source: source.into() })?;
        let held = entry.size();
        let header = Header::read(&mut entry);
        let header = header.map_err(|source| NpzError::Header { array: array.into(), source })?;
        let Some(element) = header.element.filter(|&element| accepts(element)) else {
            return Err(NpzError::Element { array, found: header.descr.chars().take(40).collect(), wanted });
        };
        let Some(extent) = extent(&header.shape) else {
            return Err(NpzError::Shape { array, shape: header.shape, wanted: shape });
        };
        let rows = extent.tuples / extent.row;
        if rows > limit {
            return Err(NpzError::Rows { array, rows, limit });
        }
        // Known before anything is allocated: tuples are below 2^32, so this cannot overflow.
        let wanted = header.length + extent.tuples * (C * element.size) as u64;
        if wanted != held {
            return Err(NpzError::Length { array, wanted, held });
        }
        Ok((entry, Head { header, element, extent }))
    }
}

/// Reads the tuples behind a header, in C order. Memory of tables grows with the data that is really there, not with the
/// header's counts. The first values of another array in Fortran order may take all that was charged for it.
fn filled<T: Copy + Default, const C: usize>(
    array: &'static str,
    Head { header, element, extent }: &Head,
    mut reader: impl Read,
    decode: Decode<T>,
) -> Result<Vec<[T; C]>, NpzError> {
    const CHUNK_ROWS: usize = 1 << 12;
    let (rows, of_row) = (extent.tuples as usize, extent.row as usize);
    let failed = |at: usize, source| NpzError::Data { array, row: at / of_row, source };
    let mut all: Vec<[T; C]> = Vec::new();
    let mut chunk = vec![0; CHUNK_ROWS * C * element.size];
    for first in (0..rows).step_by(CHUNK_ROWS) {
        let bytes = &mut chunk[..CHUNK_ROWS.min(rows - first) * C * element.size];
        reader.read_exact(bytes).map_err(|source| failed(first, source))?;
        for (at, bytes) in (C * first..).zip(bytes.chunks_exact(element.size)) {
            let at = if header.fortran_order { in_c_order(at, &header.shape) } else { at };
            let (row, column) = (at / C, at % C);
            let index = |index| NpzError::Index { array, row: row / of_row, index };
            let value = decode(*element, bytes).map_err(index)?;
            if row >= all.capacity() {
                // Twice as many as there are, or up to this one, and no more than the header says.
                let more = all.len().max(CHUNK_ROWS).max(row + 1 - all.len()).min(rows - all.len());
                let memory = |_| NpzError::Memory { array, rows: (rows / of_row) as u64 };
                all.try_reserve_exact(more).map_err(memory)?;
            }
            if row >= all.len() {
                all.resize(row + 1, [T::default(); C]);
            }
            all[row][column] = value;
        }
    }
    // One byte past the end: only then does the archive compare checksums.
    match reader.take(1).read_to_end(&mut Vec::new()) {
        Ok(0) => Ok(all),
        Ok(_) => Err(failed(rows, io::Error::other("its ZIP entry is longer than it says"))),
        Err(source) => Err(failed(rows, source)),
    }
}

/// The index of a value with the last dimension innermost, from its index with the first innermost. No side of a shape
/// with a value is 0.
fn in_c_order(at: usize, shape: &[u64]) -> usize {
    let sides = shape.iter().map(|&side| side as usize);
    sides.fold((at, 0), |(rest, index), side| (rest / side, index * side + rest % side)).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_of_every_width_and_order() {
        let element = |kind, size, big_endian| ElementType { kind, size, big_endian };
        assert_eq!(index(element('u', 1, false), &[255]), Ok(255));
        assert_eq!(index(element('i', 1, false), &[255]), Err(-1));
        assert_eq!(index(element('u', 2, true), &[1, 2]), Ok(258));
        assert_eq!(index(element('i', 8, false), &[7, 0, 0, 0, 0, 0, 0, 0]), Ok(7));
        assert_eq!(index(element('i', 4, true), &[255, 255, 255, 254]), Err(-2));
        assert_eq!(index(element('u', 8, false), &[0, 0, 0, 0, 1, 0, 0, 0]), Err(1 << 32));
    }

    #[test]
    fn a_message_shows_the_beginning_of_some_names() {
        let names: Vec<String> = (0..100).map(|name| format!("{name}{}", "a".repeat(1000))).collect();
        assert_eq!(listed(&names).len(), 12 * 62 - 2);
        assert_eq!(listed(&["faces".to_owned(), "lights".to_owned()]), "faces, lights");
    }

    #[test]
    fn the_last_dimension_becomes_the_innermost() {
        let of = |shape: &[u64]| {
            let mut values = vec![0; 24];
            (0..24).for_each(|at| values[in_c_order(at, shape)] = at);
            values
        };
        // Row r, column c of (4, 6) lies at r + 4 c.
        assert_eq!(of(&[4, 6])[..8], [0, 4, 8, 12, 16, 20, 1, 5]);
        // Plane p, row r, column c of (2, 3, 4) lies at p + 2 r + 6 c.
        assert_eq!(of(&[2, 3, 4])[..13], [0, 6, 12, 18, 2, 8, 14, 20, 4, 10, 16, 22, 1]);
        assert_eq!(of(&[24]), (0..24).collect::<Vec<_>>());
        assert_eq!(in_c_order(0, &[]), 0);
    }

    #[test]
    fn columns_become_rows() {
        let header = Header::read(&mut Header::bytes(ElementType::U8, &[2, 3]).as_slice()).expect("it is our own");
        let header = Header { fortran_order: true, ..header };
        let head = Head { header, element: ElementType::U8, extent: Extent { tuples: 2, row: 1 } };
        let rows = filled("faces", &head, &[1_u8, 4, 2, 5, 3, 6][..], index).expect("six bytes are there");
        assert_eq!(rows, [[1, 2, 3], [4, 5, 6]]);
        // The fourth number is in column 1 of row 1.
        let element = ElementType { kind: 'i', ..ElementType::U8 };
        let bytes = [1_u8, 4, 2, 255, 3, 6];
        let found = filled::<u32, 3>("faces", &Head { element, ..head }, &bytes[..], index);
        assert!(matches!(found, Err(NpzError::Index { row: 1, index: -1, .. })), "{found:?}");
    }
}
