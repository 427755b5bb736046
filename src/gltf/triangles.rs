//! Reads the triangles of a primitive: lists, strips and fans, with or without indices.

use super::document::{Component, Mode, Primitive};
use super::error::GltfError;
use super::reader::{self, Reader};
use super::warning::GltfWarning;

/// Counter-clockwise triangles as indices below `vertices`, in the order and with the corners of the specification. A
/// strip or fan of fewer than three corners has none. Triangles that name a vertex twice stay. The largest index of its
/// type begins a new strip or fan, and in a list a new triangle unless it names a vertex. `json_path` is the primitive's
/// JSON path.
pub(super) fn read(
    reader: &Reader<'_>,
    primitive: &Primitive,
    vertices: usize,
    json_path: &str,
) -> Result<Vec<[u32; 3]>, GltfError> {
    let mode = primitive.mode;
    let indices_path = format!("{json_path}.indices");
    let changed = |problem| reader.warnings.push(GltfWarning::Changed { json_path: json_path.to_owned(), problem });
    let count = primitive.indices.map_or(Ok(vertices), |accessor| reader.count(accessor))?;
    if mode == Mode::Triangles && !count.is_multiple_of(3) {
        let over = count % 3;
        changed(format!(": {count} corners are no whole number of triangles; the last {over} are left out"))?;
    }
    let faces = face_count(mode, count as u64) as usize;
    let charge_faces = || reader.budget.charge(faces as u64, size_of::<[u32; 3]>() as u64, &|| indices_path.clone());
    let mark = reader.budget.mark();
    let Some(accessor) = primitive.indices else {
        charge_faces()?;
        return Ok((0..faces).map(|face| corners(mode, face).map(|corner| corner as u32)).collect());
    };
    let indices = reader.integers(accessor, reader::INDICES, &indices_path)?;
    let restart = match reader.accessor(accessor)?.component {
        Component::U8 => u32::from(u8::MAX),
        Component::U16 => u32::from(u16::MAX),
        _ => u32::MAX,
    };
    // Only strips and fans restart on every device. A list restarts only at an index that can mean nothing else.
    let is_vertex = mode == Mode::Triangles && (restart as usize) < vertices;
    let restarts = |index: u32| index == restart && !is_vertex;
    let bad = |&index: &u32| index as usize >= vertices && !restarts(index);
    if let Some(position) = indices.iter().position(bad) {
        let (index, [face, corner]) = (indices[position], first_use(mode, position));
        let at = format!(": index {position} (face {face}, corner {corner})");
        return Err(GltfError::invalid(json_path, format!("{at} is {index}, but there are {vertices} vertices")));
    }
    charge_faces()?;
    if let Some(position) = indices.iter().position(|&index| index == restart) {
        let reading = if is_vertex { "a vertex" } else { "a restart" };
        let fault = format!(": index {position} is the primitive restart value {restart}, which glTF forbids");
        changed(format!("{fault}; it is read as {reading}"))?;
    }
    // No more faces than without restarts.
    let mut all = Vec::with_capacity(faces);
    for part in indices.split(|&index| restarts(index)) {
        let faces = 0..face_count(mode, part.len() as u64) as usize;
        all.extend(faces.map(|face| corners(mode, face).map(|corner| part[corner])));
    }
    drop(indices);
    reader.budget.settle(mark, (all.capacity() * size_of::<[u32; 3]>()) as u64);
    Ok(all)
}

/// The number of whole faces of this number of corners.
pub(super) fn face_count(mode: Mode, corners: u64) -> u64 {
    match mode {
        Mode::Triangles => corners / 3,
        _ => corners.saturating_sub(2),
    }
}

/// The positions of a face's corners in the list of corners (glTF 2.0, section 3.7.2.1).
fn corners(mode: Mode, face: usize) -> [usize; 3] {
    match mode {
        Mode::Strip if face % 2 == 1 => [face, face + 2, face + 1],
        Mode::Strip => [face, face + 1, face + 2],
        Mode::Fan => [face + 1, face + 2, 0],
        _ => [3 * face, 3 * face + 1, 3 * face + 2],
    }
}

/// The first face that reads a position in the list of corners, and its corner.
fn first_use(mode: Mode, position: usize) -> [usize; 2] {
    let face = match mode {
        Mode::Triangles => position / 3,
        _ => position.saturating_sub(2),
    };
    [face, corners(mode, face).iter().position(|&at| at == position).unwrap_or(0)]
}
