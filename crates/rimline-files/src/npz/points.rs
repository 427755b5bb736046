//! The points that `rimline query` is asked about.

use std::io::{Read, Seek};

use rimline::Origin;
use rimline::mesh::NO_FACE;

use super::header::ElementType;
use super::read::{Archive, Entry, FLOAT, NpzError, REAL, index, is_float, is_integer, is_real};

/// The points of an archive, and the faces that they are on.
#[derive(Debug, PartialEq)]
pub struct PointArrays {
    pub points: Points,
    /// One for each point, [`NO_FACE`] for a point that is on none.
    pub on_face: Option<Vec<u32>>,
}

impl PointArrays {
    /// Checks that the points are on faces of a model that has so many.
    pub fn check_faces(&self, faces: usize) -> Result<(), NpzError> {
        let mut named = self.on_face.iter().flatten().enumerate();
        match named.find(|&(_, &face)| face != NO_FACE && face as usize >= faces) {
            Some((row, &face)) => Err(NpzError::NoSuchFace { row, face, faces }),
            None => Ok(()),
        }
    }
}

#[derive(Debug, PartialEq)]
pub enum Points {
    /// float32, bit for bit, relative to an origin.
    Single { points: Vec<[f32; 3]>, origin: Origin },
    /// float64, in the world: an origin of the file is added.
    Double(Vec<[f64; 3]>),
}

impl Points {
    /// The points relative to an origin: bit for bit if they are already, else rounded once.
    pub fn relative_to(self, to: Origin) -> Vec<[f32; 3]> {
        match self {
            Self::Single { points, origin } if origin == to => points,
            Self::Single { points, origin } => {
                points.into_iter().map(|point| to.position(origin.to_world(point))).collect()
            }
            Self::Double(points) => points.into_iter().map(|point| to.position(point)).collect(),
        }
    }
}

const ON_FACE: Entry = Entry {
    array: "on_face",
    shape: "(P,), a number for each row of `points`,",
    limit: u32::MAX as u64,
    row_bytes: 4,
    wanted: "an integer type of 8 to 64 bits is needed (NumPy: `on_face.astype('i4')`)",
    accepts: is_integer,
};
const SINGLE: Entry = Entry {
    array: "points",
    shape: "(P, 3)",
    limit: u32::MAX as u64,
    row_bytes: 16,
    wanted: "float32 or float64 is needed (NumPy: `points.astype('f8')`)",
    accepts: is_float,
};
/// With the points in float32 that are made of them.
const DOUBLE: Entry = Entry { row_bytes: 24 + 16, accepts: is_real, ..SINGLE };

/// Reads the array `points` (P,3) float32 or float64; either byte order, either array order. There may be an `origin` (3),
/// which they are relative to, and `on_face` (P) integers, the face that each point is on. More than `memory_limit`
/// bytes are refused.
pub fn read_points(reader: impl Read + Seek, memory_limit: u64) -> Result<PointArrays, NpzError> {
    let mut archive = Archive::open(reader, memory_limit)?;
    let (points, count) = match archive.rows(&SINGLE, FLOAT) {
        Err(NpzError::Element { .. }) => {
            let mut points = archive.rows(&DOUBLE, REAL)?;
            let origin = archive.origin()?.to_array();
            points.iter_mut().flat_map(|point| point.iter_mut().zip(origin)).for_each(|(c, origin)| *c += origin);
            let count = points.len();
            (Points::Double(points), count)
        }
        found => {
            let points = found?;
            let count = points.len();
            (Points::Single { points, origin: archive.origin()? }, count)
        }
    };
    if !archive.has(ON_FACE.array) {
        return Ok(PointArrays { points, on_face: None });
    }
    let faces = archive.list(&ON_FACE, face).map_err(|error| match error {
        NpzError::Index { row, index, .. } => NpzError::FaceNumber { row, index },
        error => error,
    })?;
    if faces.len() != count {
        let (array, shape, wanted) = (ON_FACE.array, vec![faces.len() as u64], ON_FACE.shape);
        return Err(NpzError::Shape { array, shape, wanted });
    }
    Ok(PointArrays { points, on_face: Some(faces) })
}

/// The number of a face, or −1 for none.
fn face(element: ElementType, bytes: &[u8]) -> Result<u32, i128> {
    index(element, bytes).or_else(|other| if other == -1 { Ok(NO_FACE) } else { Err(other) })
}
