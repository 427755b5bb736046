//! Reading arrays of an archive that may hold anything.

use std::io::{self, Read, Seek};

use rimline::Origin;
use rimline::mesh::PolygonLoops;
use zip::ZipArchive;
use zip::result::ZipError;

use super::charge::{self, CORNER, LOOP, POLYGON, VERTEX};
use super::header::{ElementType, Header, HeaderError};

/// Positions relative to an origin, those of an archive bit for bit, and triangles whose indices are below their number, or
/// polygons.
#[derive(Debug, Default, PartialEq)]
pub struct Arrays {
    pub positions: Vec<[f32; 3]>,
    /// Empty if there are polygons.
    pub faces: Vec<[u32; 3]>,
    pub polygons: Option<PolygonArrays>,
    pub origin: Origin,
}

/// Polygons, unchecked: `rimline::Mesh::from_polygons` checks them.
#[derive(Debug, Default, PartialEq)]
pub struct PolygonArrays {
    polygon_loops: Vec<[u32; 1]>,
    loop_sizes: Vec<[u32; 1]>,
    loop_corners: Vec<[u32; 1]>,
}

impl PolygonArrays {
    /// Polygons of one loop each.
    pub(crate) fn of_single_loops(sizes: &[u32], corners: &[u32]) -> Self {
        Self {
            polygon_loops: vec![[1]; sizes.len()],
            loop_sizes: sizes.as_chunks().0.to_vec(),
            loop_corners: corners.as_chunks().0.to_vec(),
        }
    }

    pub fn loops(&self) -> PolygonLoops<'_> {
        PolygonLoops {
            polygon_loops: self.polygon_loops.as_flattened(),
            loop_sizes: self.loop_sizes.as_flattened(),
            loop_corners: self.loop_corners.as_flattened(),
        }
    }
}

#[derive(Debug, thiserror::Error)]
pub enum NpzError {
    #[error("it is not a ZIP archive that can be read: {0}")]
    Archive(#[source] ZipError),
    #[error("it has no array `{array}`, which is needed here; it has {}", listed(.found))]
    Missing { array: &'static str, found: Vec<String> },
    #[error("array `{array}`: its ZIP entry cannot be read: {source}")]
    Entry { array: &'static str, source: ZipError },
    #[error("array `{array}`: {source}")]
    Header { array: &'static str, source: HeaderError },
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
    #[error("array `{entry}`: its ZIP entry cannot be read: {source}")]
    Unreadable { entry: String, source: io::Error },
    #[error("array `{entry}`: {source}")]
    Unheaded { entry: String, source: HeaderError },
    #[error("array `{array}`, row {row}: {source}")]
    Data { array: &'static str, row: usize, source: io::Error },
}

pub(super) fn listed(names: &[String]) -> String {
    match names {
        [] => "none".into(),
        names => names.iter().take(12).map(String::as_str).collect::<Vec<_>>().join(", "),
    }
}

/// A shape for a message. A file may have one of thousands of numbers.
pub(super) fn shown(shape: &[u64]) -> String {
    const MOST: usize = 8;
    let numbers = shape.iter().take(MOST).map(u64::to_string).collect::<Vec<_>>().join(", ");
    if shape.len() > MOST { format!("{numbers}, … {} numbers in all", shape.len()) } else { numbers }
}

/// The memory that reading one archive may take, with everything that is made of it. The charge is the peak of the
/// memory in use at one time.
pub(super) struct Budget {
    pub(super) limit: u64,
    pub(super) used: u64,
}

impl Budget {
    fn take(&mut self, array: &'static str, rows: u64, bytes: u64) -> Result<(), NpzError> {
        let needed = self.used.saturating_add(bytes);
        if needed > self.limit {
            return Err(NpzError::TooLarge { array, rows, needed, limit: self.limit });
        }
        self.used = needed;
        Ok(())
    }
}

/// Reads `positions` (V,3) float32, and `faces` (F,3) integers, in either byte order and either array order. Instead of
/// `faces` there may be `polygon_loops`, `loop_sizes` and `loop_corners`, of one dimension each. Positions are relative
/// to `origin` (3), if there is one.
///
/// Refuses arrays that take more than `memory_limit` bytes with the mesh that is made of them. Their headers decide it,
/// before any array is read.
pub fn read(reader: impl Read + Seek, memory_limit: u64) -> Result<Arrays, NpzError> {
    let mut budget = Budget { limit: memory_limit, used: 0 };
    read_arrays(&mut ZipArchive::new(reader).map_err(NpzError::Archive)?, &mut budget)
}

/// The same, and `lights` (N,4) float32 as `extract` writes them.
pub fn read_with_lights(reader: impl Read + Seek, memory_limit: u64) -> Result<(Arrays, Vec<[f32; 4]>), NpzError> {
    let mut archive = ZipArchive::new(reader).map_err(NpzError::Archive)?;
    let mut budget = Budget { limit: memory_limit, used: 0 };
    if archive.index_for_name("polygon_loops.npy").is_some() {
        return Err(NpzError::Polygons);
    }
    let arrays = read_arrays(&mut archive, &mut budget)?;
    let lights = Entry {
        array: "lights",
        shape: "(N, 4)",
        limit: u64::from(u32::MAX),
        row_bytes: 2 * 16,
        wanted: "float32 is needed",
        accepts: is_float,
    };
    Ok((arrays, lights.rows(&mut archive, &mut budget, float)?))
}

fn read_arrays(archive: &mut ZipArchive<impl Read + Seek>, budget: &mut Budget) -> Result<Arrays, NpzError> {
    let positions = Entry {
        array: "positions",
        shape: "(V, 3)",
        limit: u64::from(u32::MAX) - 1,
        row_bytes: 0,
        wanted: "float32 is needed (NumPy: `positions.astype('f4')`; \
                 of large coordinates take off a point near the model first, and give that as `origin`)",
        accepts: is_float,
    };
    let faces = Entry {
        array: "faces",
        shape: "(F, 3)",
        limit: rimline::mesh::MAX_FACES as u64,
        row_bytes: 0,
        wanted: "an integer type of 8 to 64 bits is needed (NumPy: `faces.astype('u4')`)",
        accepts: is_integer,
    };
    let origin = read_origin(archive, budget)?;
    let stated = positions.stated::<3>(archive)?;
    if archive.index_for_name("polygon_loops.npy").is_some() {
        budget.take("positions", stated, stated.saturating_mul(VERTEX))?;
        let array = |array: &'static str, shape: &'static str, row_bytes: u64| Entry {
            array,
            shape,
            limit: 3 * rimline::mesh::MAX_FACES as u64,
            row_bytes,
            wanted: "an integer type of 8 to 64 bits is needed (NumPy: `.astype('u4')`)",
            accepts: is_integer,
        };
        let polygon_loops = array("polygon_loops", "(P,)", POLYGON);
        let loop_sizes = array("loop_sizes", "(L,)", LOOP);
        let loop_corners = array("loop_corners", "(C,)", CORNER);
        for entry in [&polygon_loops, &loop_sizes, &loop_corners] {
            let rows = entry.stated::<1>(archive)?;
            budget.take(entry.array, rows, rows.saturating_mul(entry.row_bytes))?;
        }
        let positions = positions.rows(archive, budget, float)?;
        // They are charged already.
        let mut rows = |entry| Entry { row_bytes: 0, ..entry }.rows(archive, budget, index);
        let polygons = PolygonArrays {
            polygon_loops: rows(polygon_loops)?,
            loop_sizes: rows(loop_sizes)?,
            loop_corners: rows(loop_corners)?,
        };
        return Ok(Arrays { positions, faces: Vec::new(), polygons: Some(polygons), origin });
    }
    let stated_faces = faces.stated::<3>(archive)?;
    let needed = charge::model(stated, stated_faces);
    let (array, rows) = if stated > 3 * stated_faces { ("positions", stated) } else { ("faces", stated_faces) };
    budget.take(array, rows, needed)?;
    let positions = positions.rows(archive, budget, float)?;
    let faces: Vec<[u32; 3]> = faces.rows(archive, budget, index)?;
    let vertices = positions.len();
    for (row, face) in faces.iter().enumerate() {
        if let Some(&index) = face.iter().find(|&&index| index as usize >= vertices) {
            return Err(NpzError::OutOfRange { row, index, vertices });
        }
    }
    Ok(Arrays { positions, faces, polygons: None, origin })
}

const ORIGIN: Entry = Entry {
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

/// A float of either size, exactly.
#[expect(clippy::unnecessary_wraps, reason = "it stands beside `index`, which may fail")]
pub(super) fn real(element: ElementType, bytes: &[u8]) -> Result<f64, i128> {
    let raw = raw(element, bytes);
    Ok(if element.size == 4 { f64::from(f32::from_bits(raw as u32)) } else { f64::from_bits(raw) })
}

/// Reads the array `origin`, if there is one: the point of the world that positions, lights and points are relative to. Without it the origin is zero.
pub(super) fn read_origin(archive: &mut ZipArchive<impl Read + Seek>, budget: &mut Budget) -> Result<Origin, NpzError> {
    if !ORIGIN.is_in(archive) {
        return Ok(Origin::ZERO);
    }
    let given = ORIGIN.values(archive, budget, real, |shape| *shape == [3])?.elements;
    if let Some(other) = given.iter().find(|c| !c.is_finite()) {
        return Err(NpzError::Value { array: ORIGIN.array, found: other.to_string(), wanted: ORIGIN.wanted });
    }
    let mut xyz = [0.0; 3];
    xyz.iter_mut().zip(given).for_each(|(to, given)| *to = given);
    Ok(Origin::new(xyz))
}

pub(super) fn is_float(element: ElementType) -> bool {
    element.kind == 'f' && element.size == 4
}

pub(super) fn is_integer(element: ElementType) -> bool {
    matches!((element.kind, element.size), ('i' | 'u', 1 | 2 | 4 | 8))
}

pub(super) struct Entry {
    pub(super) array: &'static str,
    pub(super) shape: &'static str,
    pub(super) limit: u64,
    /// Bytes that a row takes of the budget, or a value of an array that is no table.
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

/// An array of any shape, its values in C order.
pub(super) struct Values<T> {
    pub(super) shape: Vec<u64>,
    pub(super) element: ElementType,
    pub(super) elements: Vec<T>,
}

impl Entry {
    pub(super) fn rows<T: Copy + Default, const C: usize>(
        &self,
        archive: &mut ZipArchive<impl Read + Seek>,
        budget: &mut Budget,
        decode: fn(ElementType, &[u8]) -> Result<T, i128>,
    ) -> Result<Vec<[T; C]>, NpzError> {
        let (_, _, rows) = self.tuples(archive, budget, decode, table::<C>)?;
        Ok(rows)
    }

    /// The rows that the header of a table of C columns states. No data is read.
    fn stated<const C: usize>(&self, archive: &mut ZipArchive<impl Read + Seek>) -> Result<u64, NpzError> {
        let (_, head) = self.head::<C>(archive, table::<C>)?;
        Ok(head.tuples)
    }

    /// An array whose shape `fits` accepts. It has at most three dimensions, and so few values that their number is no question.
    pub(super) fn values<T: Copy + Default>(
        &self,
        archive: &mut ZipArchive<impl Read + Seek>,
        budget: &mut Budget,
        decode: fn(ElementType, &[u8]) -> Result<T, i128>,
        fits: impl Fn(&[u64]) -> bool,
    ) -> Result<Values<T>, NpzError> {
        let extent = |shape: &[u64]| {
            let row = shape.last().copied().unwrap_or(1).max(1);
            (shape.len() <= 3 && fits(shape)).then(|| Extent { tuples: shape.iter().product(), row })
        };
        let (header, element, tuples) = self.tuples::<T, 1>(archive, budget, decode, extent)?;
        let mut elements: Vec<T> = tuples.into_iter().map(|[value]| value).collect();
        if header.fortran_order {
            elements = in_c_order(&elements, &header.shape);
        }
        Ok(Values { shape: header.shape, element, elements })
    }

    pub(super) fn is_in(&self, archive: &ZipArchive<impl Read + Seek>) -> bool {
        archive.index_for_name(&format!("{}.npy", self.array)).is_some()
    }

    fn tuples<T: Copy + Default, const C: usize>(
        &self,
        archive: &mut ZipArchive<impl Read + Seek>,
        budget: &mut Budget,
        decode: fn(ElementType, &[u8]) -> Result<T, i128>,
        extent: impl Fn(&[u64]) -> Option<Extent>,
    ) -> Result<(Header, ElementType, Vec<[T; C]>), NpzError> {
        let (entry, head) = self.head::<C>(archive, extent)?;
        // A compressed entry may be a thousandth of what it unpacks to.
        budget.take(self.array, head.tuples / head.row, head.tuples * self.row_bytes)?;
        let elements = Elements { array: self.array, head, decode };
        let tuples = elements.read(entry)?;
        Ok((elements.head.header, elements.head.element, tuples))
    }

    /// Finds the entry and reads its header, which must fit the entry's length.
    fn head<'a, const C: usize>(
        &self,
        archive: &'a mut ZipArchive<impl Read + Seek>,
        extent: impl Fn(&[u64]) -> Option<Extent>,
    ) -> Result<(impl Read + 'a, Head), NpzError> {
        let array = self.array;
        let name = format!("{array}.npy");
        if archive.index_for_name(&name).is_none() {
            let found = archive.file_names_raw().map(|name| String::from_utf8_lossy(name).into());
            let found = found.collect();
            return Err(NpzError::Missing { array, found });
        }
        let mut entry = archive.by_name(&name).map_err(|source| NpzError::Entry { array, source })?;
        let held = entry.size();
        let header = Header::read(&mut entry).map_err(|source| NpzError::Header { array, source })?;
        let element = header.element.filter(|&element| (self.accepts)(element));
        let element = element.ok_or_else(|| NpzError::Element {
            array,
            found: header.descr.chars().take(40).collect(),
            wanted: self.wanted,
        })?;
        let Some(Extent { tuples, row }) = extent(&header.shape) else {
            return Err(NpzError::Shape { array, shape: header.shape, wanted: self.shape });
        };
        let (rows, limit) = (tuples / row, self.limit);
        if rows > limit {
            return Err(NpzError::Rows { array, rows, limit });
        }
        // Known before anything is allocated: tuples are below 2^32, so this cannot overflow.
        let wanted = header.length + tuples * (C * element.size) as u64;
        if wanted != held {
            return Err(NpzError::Length { array, wanted, held });
        }
        Ok((entry, Head { header, element, tuples, row }))
    }
}

struct Head {
    header: Header,
    element: ElementType,
    tuples: u64,
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

struct Elements<T> {
    array: &'static str,
    head: Head,
    decode: fn(ElementType, &[u8]) -> Result<T, i128>,
}

impl<T: Copy + Default> Elements<T> {
    /// Memory grows with the data that is really there, whatever the header says.
    fn read<const C: usize>(&self, mut reader: impl Read) -> Result<Vec<[T; C]>, NpzError> {
        const CHUNK_ROWS: usize = 1 << 12;
        let Head { header, element, tuples, row: of_row } = &self.head;
        let (array, rows, of_row) = (self.array, *tuples as usize, *of_row as usize);
        let failed = |at: usize, source| NpzError::Data { array, row: at / of_row, source };
        let mut all: Vec<[T; C]> = Vec::new();
        let mut chunk = vec![0; CHUNK_ROWS * C * element.size];
        for first in (0..rows).step_by(CHUNK_ROWS) {
            let bytes = &mut chunk[..CHUNK_ROWS.min(rows - first) * C * element.size];
            reader.read_exact(bytes).map_err(|source| failed(first, source))?;
            for (at, bytes) in (C * first..).zip(bytes.chunks_exact(element.size)) {
                let (row, column) = if header.fortran_order { (at % rows, at / rows) } else { (at / C, at % C) };
                let index = |index| NpzError::Index { array, row: at / C / of_row, index };
                let value = (self.decode)(*element, bytes).map_err(index)?;
                if row >= all.capacity() {
                    // Twice as many as there are, and no more than the header says.
                    let more = all.len().max(CHUNK_ROWS).min(rows - all.len());
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
}

/// Values that lie with the first dimension innermost, with the last innermost.
fn in_c_order<T: Copy>(values: &[T], shape: &[u64]) -> Vec<T> {
    let mut sides = [1, 1, 1];
    sides.iter_mut().rev().zip(shape.iter().rev()).for_each(|(side, &given)| *side = given as usize);
    let [planes, rows, columns] = sides;
    let places = (0..planes).flat_map(|plane| (0..rows).map(move |row| plane + planes * row));
    let places = places.flat_map(|first| (0..columns).map(move |column| first + planes * rows * column));
    places.filter_map(|place| values.get(place).copied()).collect()
}

/// Up to eight bytes as a little-endian number's low bytes.
pub(super) fn raw(element: ElementType, bytes: &[u8]) -> u64 {
    let mut low = [0; 8];
    for (i, &byte) in bytes.iter().enumerate() {
        low[if element.big_endian { bytes.len() - 1 - i } else { i }] = byte;
    }
    u64::from_le_bytes(low)
}

/// The same bits; a NaN keeps its payload.
#[expect(clippy::unnecessary_wraps, reason = "it stands beside `index`, which may fail")]
pub(super) fn float(element: ElementType, bytes: &[u8]) -> Result<f32, i128> {
    Ok(f32::from_bits(raw(element, bytes) as u32))
}

pub(super) fn index(element: ElementType, bytes: &[u8]) -> Result<u32, i128> {
    let value = raw(element, bytes);
    let value = if element.kind == 'i' {
        let unused = 64 - 8 * element.size as u32;
        i128::from((value << unused) as i64 >> unused)
    } else {
        i128::from(value)
    };
    u32::try_from(value).map_err(|_| value)
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
    fn the_last_dimension_becomes_the_innermost() {
        let of = |shape: &[u64]| in_c_order(&(0..24).collect::<Vec<u32>>(), shape);
        // Row r, column c of (4, 6) lies at r + 4 c.
        assert_eq!(of(&[4, 6])[..8], [0, 4, 8, 12, 16, 20, 1, 5]);
        // Plane p, row r, column c of (2, 3, 4) lies at p + 2 r + 6 c.
        assert_eq!(of(&[2, 3, 4])[..13], [0, 6, 12, 18, 2, 8, 14, 20, 4, 10, 16, 22, 1]);
        assert_eq!(of(&[24]), (0..24).collect::<Vec<u32>>());
        assert_eq!(in_c_order(&[7], &[]), [7]);
    }

    #[test]
    fn columns_become_rows() {
        let bytes: Vec<u8> = vec![1, 4, 2, 5, 3, 6];
        let mut header = Header::read(&mut Header::bytes(ElementType::U8, &[2, 3]).as_slice()).expect("it is our own");
        header.fortran_order = true;
        let head = Head { header, element: ElementType::U8, tuples: 2, row: 1 };
        let rows =
            Elements { array: "faces", head, decode: index }.read(bytes.as_slice()).expect("six bytes are there");
        assert_eq!(rows, [[1, 2, 3], [4, 5, 6]]);
    }
}
