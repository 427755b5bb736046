//! The points that `rimline query` is asked about.

use std::io::{Read, Seek};

use rimline::Origin;
use rimline::mesh::NO_FACE;
use zip::ZipArchive;

use super::header::ElementType;
use super::read::{Budget, Entry, NpzError, float, index, is_float, is_integer, is_real, read_origin, real};

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
    /// float64, in the world.
    Double(Vec<[f64; 3]>),
}

impl Points {
    fn len(&self) -> usize {
        match self {
            Self::Single { points, .. } => points.len(),
            Self::Double(points) => points.len(),
        }
    }

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

/// Reads the array `points` (P,3) float32 or float64; either byte order, either array order. There may be an `origin` (3),
/// which they are relative to, and `on_face` (P) integers, the face that each point is on. More than `memory_limit` bytes are
/// refused.
pub fn read_points(reader: impl Read + Seek, memory_limit: u64) -> Result<PointArrays, NpzError> {
    let mut archive = ZipArchive::new(reader).map_err(NpzError::Archive)?;
    let (archive, budget) = (&mut archive, &mut Budget { limit: memory_limit, used: 0 });
    let points = read_places(archive, budget)?;
    let on_face = if ON_FACE.is_in(archive) { Some(read_faces(archive, budget, points.len())?) } else { None };
    Ok(PointArrays { points, on_face })
}

const ON_FACE: Entry = Entry {
    array: "on_face",
    shape: "(P,), a number for each row of `points`,",
    limit: u32::MAX as u64,
    row_bytes: 4,
    wanted: "an integer type of 8 to 64 bits is needed (NumPy: `on_face.astype('i4')`)",
    accepts: is_integer,
};

/// The number of a face, or −1 for none.
fn face(element: ElementType, bytes: &[u8]) -> Result<u32, i128> {
    index(element, bytes).or_else(|other| if other == -1 { Ok(NO_FACE) } else { Err(other) })
}

fn read_faces(
    archive: &mut ZipArchive<impl Read + Seek>,
    budget: &mut Budget,
    points: usize,
) -> Result<Vec<u32>, NpzError> {
    let rows: Vec<[u32; 1]> = ON_FACE.rows(archive, budget, face).map_err(|error| match error {
        NpzError::Index { row, index, .. } => NpzError::FaceNumber { row, index },
        error => error,
    })?;
    if rows.len() != points {
        let (array, shape, wanted) = (ON_FACE.array, vec![rows.len() as u64], ON_FACE.shape);
        return Err(NpzError::Shape { array, shape, wanted });
    }
    Ok(rows.into_iter().map(|[face]| face).collect())
}

fn read_places(archive: &mut ZipArchive<impl Read + Seek>, budget: &mut Budget) -> Result<Points, NpzError> {
    let points = |row_bytes: u64, accepts: fn(ElementType) -> bool| Entry {
        array: "points",
        shape: "(P, 3)",
        limit: u64::from(u32::MAX),
        row_bytes,
        wanted: "float32 or float64 is needed (NumPy: `points.astype('f8')`)",
        accepts,
    };
    let single = points(16, is_float);
    match single.rows(archive, budget, float) {
        Err(NpzError::Element { .. }) => {}
        found => return Ok(Points::Single { points: found?, origin: read_origin(archive, budget)? }),
    }
    // With the points in float32 that are made of them.
    let mut points = points(24 + 16, is_real).rows(archive, budget, real)?;
    let [x, y, z] = read_origin(archive, budget)?.to_array();
    for point in &mut points {
        *point = [point[0] + x, point[1] + y, point[2] + z];
    }
    Ok(Points::Double(points))
}
