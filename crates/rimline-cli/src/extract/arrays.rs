//! The output contract: which arrays, in which order and shape.

use std::io::{self, Seek, Write};

use rimline::internals::layout::EdgeMasks;
use rimline::internals::light::batches;
use rimline::mesh::EdgeKind;
use rimline::{Light, Mesh, Origin};

use super::Found;
use rimline_files::npz::{ElementType, NpzWriter, write_origin};

pub(crate) fn write_lights(npz: &mut NpzWriter<impl Write + Seek>, lights: &[Light]) -> io::Result<()> {
    let components: Vec<[f32; 4]> = lights.iter().map(|light| light.to_array()).collect();
    npz.slice("lights", ElementType::F32, &[lights.len(), 4], &components)
}

/// Writes all arrays; positions and lights are relative to the origin. Nothing is copied whole: what needs another form
/// is converted piece by piece.
pub(crate) fn write(
    file: impl Write + Seek,
    mesh: &Mesh,
    lights: &[Light],
    found: &Found<'_>,
    origin: Origin,
) -> io::Result<()> {
    let (faces, edges, words) = (mesh.face_count(), mesh.edges().len(), batches(lights.len()));
    let mut npz = NpzWriter::new(file);
    npz.slice("positions", ElementType::F32, &[found.positions.len(), 3], &found.positions)?;
    npz.slice("faces", ElementType::U32, &[mesh.faces().len(), 3], mesh.faces())?;
    if let Some(polygons) = mesh.polygons() {
        let of_triangles = polygons.triangle_polygons();
        npz.slice("triangle_polygons", ElementType::U32, &[of_triangles.len()], &of_triangles)?;
        let loops = |polygon| polygons.loops(polygon);
        let all_loops = || (0..polygons.len()).flat_map(loops);
        npz.array("polygon_loops", ElementType::U32, &[polygons.len()], |to| {
            pieces(to, 0..polygons.len(), |polygon| loops(polygon).len() as u32)
        })?;
        npz.array("loop_sizes", ElementType::U32, &[all_loops().count()], |to| {
            pieces(to, all_loops(), |corners| corners.len() as u32)
        })?;
        let corners = all_loops().map(<[u32]>::len).sum();
        npz.array("loop_corners", ElementType::U32, &[corners], |to| {
            pieces(to, all_loops().flatten(), |&corner| corner)
        })?;
    }
    write_lights(&mut npz, lights)?;
    npz.slice("edges", ElementType::U32, &[edges, 2], mesh.edges().vertices())?;
    npz.array("edge_faces", ElementType::U32, &[edges, 2], |to| {
        // No face 1 is `0xFFFFFFFF` here as in memory; `face_0` has its flag taken off.
        pieces(to, mesh.edges().iter(), |edge| [edge.face_0, edge.face_1.unwrap_or(u32::MAX)])
    })?;
    npz.array("edge_kind", ElementType::U8, &[edges], |to| {
        pieces(to, mesh.edges().iter(), |edge| match edge.kind {
            EdgeKind::Consistent => 0_u8,
            EdgeKind::Inconsistent => 1,
            EdgeKind::Boundary => 2,
        })
    })?;
    npz.array("facing", ElementType::U32, &[faces, words], planes(&found.facing, faces, words, |&mask| mask))?;
    if mesh.polygons().is_some() {
        npz.array("twisted", ElementType::U32, &[faces, words], planes(&found.twisted, faces, words, |&mask| mask))?;
    }
    let silhouette = |masks: &EdgeMasks| masks.silhouette;
    npz.array("silhouette", ElementType::U32, &[edges, words], planes(&found.masks, edges, words, silhouette))?;
    let winding = |masks: &EdgeMasks| masks.winding;
    npz.array("winding", ElementType::U32, &[edges, words], planes(&found.masks, edges, words, winding))?;
    write_origin(&mut npz, origin)?;
    npz.finish()
}

/// Items converted and written a few thousand at a time.
fn pieces<T, U: bytemuck::NoUninit>(
    to: &mut dyn Write,
    items: impl Iterator<Item = T>,
    convert: impl Fn(T) -> U,
) -> io::Result<()> {
    const PIECE: usize = 1 << 14;
    let mut piece = Vec::with_capacity(PIECE);
    for item in items {
        piece.push(convert(item));
        if piece.len() == PIECE {
            to.write_all(bytemuck::cast_slice(&piece))?;
            piece.clear();
        }
    }
    to.write_all(bytemuck::cast_slice(&piece))
}

/// From a plane a word to the words of each item side by side.
fn planes<'a, T>(
    planes: &'a [T],
    items: usize,
    words: usize,
    word: impl Fn(&T) -> u32 + 'a,
) -> impl FnOnce(&mut dyn Write) -> io::Result<()> + 'a {
    move |to| {
        let all = (0..items).flat_map(|item| (0..words).map(move |plane| plane * items + item));
        pieces(to, all, |at| word(&planes[at]))
    }
}
