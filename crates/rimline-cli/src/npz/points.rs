//! The points that `rimline query` is asked about.

use std::io::{Read, Seek};

use rimline::Origin;
use zip::ZipArchive;

use super::header::ElementType;
use super::read::{Budget, Entry, NpzError, float, is_float, is_real, read_origin, real};

/// Points as an archive has them.
#[derive(Debug, PartialEq)]
pub enum Points {
    /// float32, bit for bit, relative to an origin.
    Single { points: Vec<[f32; 3]>, origin: Origin },
    /// float64, in the world.
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

/// Reads the array `points` (P,3) float32 or float64; either byte order, either array order. There may be an `origin` (3),
/// which they are relative to. More than `memory_limit` bytes are refused.
pub fn read_points(reader: impl Read + Seek, memory_limit: u64) -> Result<Points, NpzError> {
    let mut archive = ZipArchive::new(reader).map_err(NpzError::Archive)?;
    let (archive, budget) = (&mut archive, &mut Budget { limit: memory_limit, used: 0 });
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
