//! The array `origin`: the point of the world that positions, lights and points are relative to.

use std::io::{self, Read, Seek, Write};

use rimline::Origin;
use zip::ZipArchive;

use super::header::ElementType;
use super::read::{Budget, Entry, NpzError, raw};
use super::write::NpzWriter;

const ORIGIN: Entry = Entry {
    array: "origin",
    shape: "(3,)",
    limit: 3,
    row_bytes: 64,
    wanted: "float64 or float32 is needed: three finite coordinates",
    accepts: is_real,
};

/// A float of either size.
pub(super) fn is_real(element: ElementType) -> bool {
    matches!((element.kind, element.size), ('f', 4 | 8))
}

/// A float of either size, exactly.
#[expect(clippy::unnecessary_wraps, reason = "it stands beside `index`, which may fail")]
pub(super) fn real(element: ElementType, bytes: &[u8]) -> Result<f64, i128> {
    let raw = raw(element, bytes);
    Ok(if element.size == 4 { f64::from(f32::from_bits(raw as u32)) } else { f64::from_bits(raw) })
}

/// Reads the array, if there is one. Without it the origin is zero.
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

/// Writes the array, unless the origin is zero. It is the last of an archive.
pub fn write_origin(npz: &mut NpzWriter<impl Write + Seek>, origin: Origin) -> io::Result<()> {
    if origin.is_zero() {
        return Ok(());
    }
    npz.array(ORIGIN.array, ElementType::F64, &[3], |to| to.write_all(bytemuck::cast_slice(&origin.to_array())))
}
