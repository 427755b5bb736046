//! Reads the triangles of a primitive: lists, strips and fans, with or without indices.

use gltf::json::accessor::ComponentType;
use gltf::json::mesh::Mode;

use super::document::Primitive;
use super::error::GltfError;
use super::formats;
use super::reader::Reader;
use super::warning::GltfWarning;

/// The place of the triangles, for errors.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) mesh: usize,
    pub(super) primitive: usize,
}

/// Whether a mode makes triangles. Points and lines do not.
pub(super) fn has_triangles(mode: Mode) -> bool {
    matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
}

/// Counter-clockwise triangles as indices below `vertices`, in the order and with the corners of the specification. A
/// strip or fan of fewer than three corners has none. Triangles that name a vertex twice are kept. An index that restarts
/// strips begins a new one.
pub(super) fn read(
    reader: &Reader<'_>,
    primitive: &Primitive,
    vertices: usize,
    at: Place,
) -> Result<Vec<[u32; 3]>, GltfError> {
    let Place { mesh, primitive: p } = at;
    let place = format!("meshes[{mesh}].primitives[{p}].indices");
    let count = primitive.indices.map_or(Ok(vertices), |accessor| reader.count(accessor))?;
    if primitive.mode == Mode::Triangles && !count.is_multiple_of(3) {
        reader.warnings.push(GltfWarning::CornerCount { mesh, primitive: p, corners: count })?;
    }
    let faces = face_count(primitive.mode, count as u64) as usize;
    let charge_faces = || reader.charge(faces as u64, size_of::<[u32; 3]>() as u64, &|| place.clone());
    let mark = reader.budget.mark();
    let Some(accessor) = primitive.indices else {
        charge_faces()?;
        return Ok(faces_of(primitive.mode, faces, |corner| corner as u32));
    };
    let indices = reader.integers(accessor, formats::INDICES, &place)?;
    let restart = match reader.accessor(accessor)?.component {
        ComponentType::U8 => u32::from(u8::MAX),
        ComponentType::U16 => u32::from(u16::MAX),
        _ => u32::MAX,
    };
    // Only strips and fans restart on every device. A list restarts where nothing else can be meant.
    let is_vertex = primitive.mode == Mode::Triangles && (restart as usize) < vertices;
    let restarts = |index: u32| index == restart && !is_vertex;
    let bad = |&index: &u32| index as usize >= vertices && !restarts(index);
    if let Some(position) = indices.iter().position(bad) {
        let index = indices[position];
        let (face, corner) = first_use(primitive.mode, position);
        return Err(GltfError::IndexOutOfRange { mesh, primitive: p, position, face, corner, index, vertices });
    }
    charge_faces()?;
    let faces = match indices.iter().position(|&index| index == restart) {
        None => faces_of(primitive.mode, faces, |corner| indices[corner]),
        Some(position) => {
            let index = restart;
            reader.warnings.push(GltfWarning::PrimitiveRestart { mesh, primitive: p, position, index, is_vertex })?;
            // No more faces than without restarts.
            let mut all = Vec::with_capacity(faces);
            for part in indices.split(|&index| restarts(index)) {
                let faces = 0..face_count(primitive.mode, part.len() as u64) as usize;
                all.extend(faces.map(|face| corners(primitive.mode, face).map(|corner| part[corner])));
            }
            all
        }
    };
    drop(indices);
    reader.budget.settle(mark, (faces.capacity() * size_of::<[u32; 3]>()) as u64);
    Ok(faces)
}

/// The number of whole faces of so many corners.
pub(super) fn face_count(mode: Mode, corners: u64) -> u64 {
    match mode {
        Mode::Triangles => corners / 3,
        _ => corners.saturating_sub(2),
    }
}

fn faces_of(mode: Mode, faces: usize, vertex: impl Fn(usize) -> u32) -> Vec<[u32; 3]> {
    (0..faces).map(|face| corners(mode, face).map(&vertex)).collect()
}

/// The positions of a face's corners in the list of corners (glTF 2.0, section 3.7.2.1).
fn corners(mode: Mode, face: usize) -> [usize; 3] {
    match mode {
        Mode::TriangleStrip if face % 2 == 1 => [face, face + 2, face + 1],
        Mode::TriangleStrip => [face, face + 1, face + 2],
        Mode::TriangleFan => [face + 1, face + 2, 0],
        _ => [3 * face, 3 * face + 1, 3 * face + 2],
    }
}

/// The first face that reads a position in the list of corners, and its corner.
fn first_use(mode: Mode, position: usize) -> (usize, usize) {
    let face = match mode {
        Mode::Triangles => position / 3,
        _ => position.saturating_sub(2),
    };
    let corner = corners(mode, face).iter().position(|&at| at == position);
    (face, corner.unwrap_or(0))
}
