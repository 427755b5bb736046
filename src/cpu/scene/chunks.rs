//! Chunks: lists the chunks of faces of the casters with bits that are to be computed, and the chunks of edges of those with a
//! light whose list is made anew.

use super::table::SceneTable;
use crate::layout::SceneDispatch;

/// The listed chunks of faces and of edges of a group, in order. `lit` is what [`super::reach::reach`] returns, `taken` that
/// of [`super::reach::take`], and `anew` its word for the group and batch.
pub fn chunks(table: SceneTable<'_>, group: &SceneDispatch, lit: &[u32], taken: &[u32], anew: u32) -> [Vec<u32>; 2] {
    let SceneDispatch { face_chunks_at, face_chunks, edge_chunks_at, edge_chunks, .. } = *group;
    let lists = [(face_chunks_at, face_chunks, taken, u32::MAX), (edge_chunks_at, edge_chunks, lit, anew)];
    lists.map(|(at, count, lights, mask)| {
        let is_listed = |&chunk: &u32| {
            let caster = table.word(at, chunk);
            lights.get((group.batch * group.casters + caster) as usize).is_some_and(|&lights| lights & mask != 0)
        };
        (0..count).filter(is_listed).collect()
    })
}
